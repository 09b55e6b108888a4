"""`Account`: facts of a run, besides its motion."""

import dataclasses as dc
from collections.abc import Callable, Sequence
from itertools import pairwise

import numpy as np

from remosplat_drake.visualization.clearance_plot import clearance_plot
from remosplat_drake.visualization.page_state import PageState

_STILL = 0.002
"""Speed of a joint below which it stands still [rad/s, m/s]."""
_IDLE = 3.0
"""Longest standstill that is shown in full [s]."""
_LEAD = 0.5
"""How much of a skipped standstill is shown, before and after motion [s]."""
_POINTS = 380
"""Greatest number of points of a curve: one for a pixel."""


@dc.dataclass(frozen=True)
class Moment:
    """Something that happened.

    Attributes:
        time: When it happened, on the replay's clock [s].
        text: What happened, in words for a person.
    """

    time: float
    text: str


@dc.dataclass(frozen=True, eq=False)
class Account:
    """The facts about a run, with times on the replay's clock.

    Attributes:
        state: How it ended.
        time: Times of the ticks, increasing, shape (T,) [s].
        q: Configurations at the ticks, shape (T, n_q).
        clearance: Smallest clearance at each tick, shape (T,) [m]; inf beyond
            the oracle's influence.
        stopping: Clearance at which the controller stops approaching [m].
        influence: Clearance beyond which the oracle reports none [m].
        moments: What happened, in the order of time.
        facts: Names and values of the measurements.
        rate: Seconds of the run that the player plays in a second.
    """

    state: PageState
    time: np.ndarray
    q: np.ndarray
    clearance: np.ndarray
    stopping: float
    influence: float
    moments: Sequence[Moment] = ()
    facts: Sequence[tuple[str, str]] = ()
    rate: float = 1.0

    @property
    def begin(self) -> float:
        """When the replay begins: shortly before the first motion [s]."""
        idle = self.idle()
        at_start = idle and idle[0][0] == self.time[0]
        return idle[0][1] if at_start else float(self.time[0])

    def idle(self) -> list[tuple[float, float]]:
        """Returns beginning and end of the standstills that are skipped [s].

        A run that never moves has none.
        """
        speed = np.abs(np.diff(self.q, axis=0)).max(axis=1, initial=0.0)
        moves = speed > _STILL * np.diff(self.time)
        if not moves.any():
            return []
        moving = self.time[:-1][moves]
        ends = np.concatenate([[self.time[0]], moving, [self.time[-1]]])
        spans = []
        for before, after in pairwise(ends):
            if after - before > _IDLE:
                lead = 0.0 if before == self.time[0] else _LEAD
                spans.append((float(before + lead), float(after - _LEAD)))
        return spans

    def closest(self) -> Moment | None:
        """Returns the moment of the smallest clearance; None if unknown."""
        if not np.isfinite(self.clearance).any():
            return None
        k = int(np.nanargmin(self.clearance))
        text = f"nearest to the scene: {1e3 * self.clearance[k]:.0f} mm"
        return Moment(float(self.time[k]), text)

    def plots(self) -> list[str]:
        """Draws the smallest clearance over the whole run, as an SVG."""
        span = max(float(self.time[-1]), 0.1)
        plot = clearance_plot(
            self.stopping, self.influence, span=span, elapsed=True
        )
        return [plot.draw(*thinned(self.time, self.clearance, np.nanmin))]

    def document(self) -> dict:
        """Returns what a page shows of it, as JSON has it."""
        moments = [*self.moments, *filter(None, [self.closest()])]
        return {
            "state": self.state.document(),
            "begin": self.begin,
            "idle": self.idle(),
            "rate": self.rate,
            "facts": list(self.facts),
            "plots": self.plots(),
            "moments": sorted((m.time, m.text) for m in moments),
        }


def thinned(
    time: np.ndarray,
    value: np.ndarray,
    worst: Callable[[np.ndarray], float],
    most: int = _POINTS,
) -> tuple[np.ndarray, np.ndarray]:
    """Thins a curve out, and keeps its worst values.

    Args:
        time: Times, increasing, shape (T,) [s].
        value: The values, shape (T,).
        worst: Chooses one of several values.
        most: Greatest number of points.

    Returns:
        Times and values, at most `most` of them.
    """
    if len(time) <= most:
        return time, value
    groups = np.array_split(np.arange(len(time)), most)
    # A group without any number has none to choose.
    chosen = [
        worst(value[g]) if not np.isnan(value[g]).all() else np.nan
        for g in groups
    ]
    return time[[g[-1] for g in groups]], np.array(chosen)
