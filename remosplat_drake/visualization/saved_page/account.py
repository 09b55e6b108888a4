"""`Account`: the summary of a run for its page: outcome, events and numbers."""

import dataclasses as dc
from collections.abc import Callable, Sequence
from itertools import pairwise

import numpy as np

from remosplat_drake.visualization.clearance_plot import clearance_plot
from remosplat_drake.visualization.page_state import PageState

_STILL = 0.002
"""A joint counts as at rest if its speed is below this [rad/s, m/s]."""
_IDLE = 3.0
"""Longest standstill that a replay shows completely [s]."""
_LEAD = 0.5
"""A replay skips the middle of a long standstill, and shows this time at its
beginning and at its end [s]."""
_POINTS = 380
"""A curve has at most this many points, about one point per pixel."""


@dc.dataclass(frozen=True)
class Moment:
    """An event of a run.

    Attributes:
        time: Time of the event, on the replay's clock [s].
        text: Description of the event.
    """

    time: float
    text: str


@dc.dataclass(frozen=True, eq=False)
class Account:
    """The summary of a run, with times on the replay's clock.

    Attributes:
        state: Outcome of the run.
        time: Times of the ticks, increasing, shape (T,) [s].
        q: Configurations at the ticks, shape (T, n_q).
        clearance: Smallest clearance at each tick, shape (T,) [m]; inf if it
            exceeds the influence distance.
        stopping: Clearance at which the controller stops approaching [m].
        influence: Influence distance: larger clearances are not measured [m].
        moments: Events of the run, in the order of time.
        facts: Names and values of the measurements.
        rate: Playback speed: seconds of the run per second.
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
        """Start of the replay, shortly before the first motion [s]."""
        idle = self.idle()
        at_start = idle and idle[0][0] == self.time[0]
        return idle[0][1] if at_start else float(self.time[0])

    def idle(self) -> list[tuple[float, float]]:
        """Returns start and end times of the standstills that are skipped [s].

        A run without any motion has none.
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
        """Returns a plot of the smallest clearance over the run, as SVG."""
        span = max(float(self.time[-1]), 0.1)
        plot = clearance_plot(
            self.stopping, self.influence, span=span, elapsed=True
        )
        return [plot.draw(*thinned(self.time, self.clearance, np.nanmin))]

    def document(self) -> dict:
        """Returns the content of a page about the run, as types of JSON."""
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
    """Reduces a curve to fewer points, which include its worst values.

    Args:
        time: Times, increasing, shape (T,) [s].
        value: The values, shape (T,).
        worst: Function that chooses the worst of several values.
        most: At most this many points remain.

    Returns:
        Times and values of the remaining points.
    """
    if len(time) <= most:
        return time, value
    groups = np.array_split(np.arange(len(time)), most)
    # If all values of a group are NaN, its result is NaN.
    chosen = [
        worst(value[g]) if not np.isnan(value[g]).all() else np.nan
        for g in groups
    ]
    return time[[g[-1] for g in groups]], np.array(chosen)
