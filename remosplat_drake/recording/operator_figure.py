"""Draws the paper's figure 5: clearance and deviation of the velocity."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from remosplat_drake.base.atomic_file import atomic_write
from remosplat_drake.base.errors import FieldError, unknown_name
from remosplat_drake.recording.events import MAP, SUPERVISOR, Event
from remosplat_drake.recording.operator_trace import OperatorTrace

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

FORMATS = ("pdf", "png", "svg")
"""Formats of a saved figure, which are also the suffixes of the files."""

_OURS, _TRUE, _LIMIT = "tab:blue", "black", "tab:red"
_MAP, _STOP = "tab:green", "tab:orange"
_SIZE = (7.2, 5.0)  # On paper [in].
_DPI = 150


def draw_operator_figure(
    trace: OperatorTrace,
    *,
    stopping: float,
    events: Sequence[Event] = (),
) -> "Figure":
    """Draws two plots: clearance, and deviation from the desired velocity.

    Args:
        trace: The curves.
        stopping: Distance at which the controller stops approaching [m].
        events: Events of the run. Vertical lines mark new maps and changes of
            the supervisor's mode.
    """
    from matplotlib.figure import Figure

    figure = Figure(figsize=_SIZE, dpi=_DPI, layout="constrained")
    above, below = figure.subplots(2, 1, sharex=True)
    for axes in (above, below):
        _mark_events(axes, trace.time, events)
        axes.grid(alpha=0.3)
    _draw_clearance(above, trace, stopping)
    below.plot(trace.time, trace.deviation, color=_OURS, lw=1.2)
    below.set_ylabel(r"$|v_e^d - v_e^e|$ [m/s]")
    below.set_xlabel("time [s]")
    below.set_ylim(bottom=0)
    below.set_xlim(trace.time[0], trace.time[-1])
    figure.align_ylabels()
    return figure


def save_figure(figure: "Figure", path: Path) -> None:
    """Writes a figure to a file atomically.

    Args:
        figure: The figure.
        path: The file; its suffix determines the format.

    Raises:
        FieldError: The file's suffix is not in `FORMATS`.
        FileError: The file cannot be written.
    """
    check_figure_path(path)
    with atomic_write(path, "wb") as file:
        figure.savefig(file, format=path.suffix[1:])


def check_figure_path(path: Path) -> None:
    """Checks that a figure can be saved at a path.

    Raises:
        FieldError: The path's suffix is not in `FORMATS`.
    """
    ending = path.suffix[1:]
    if ending not in FORMATS:
        raise FieldError(
            str(path), "ending", unknown_name("format", ending, FORMATS)
        )


def _draw_clearance(
    axes: "Axes", trace: OperatorTrace, stopping: float
) -> None:
    """Draws clearances in millimetres, with gaps beyond the oracle's range."""
    seen = np.where(np.isfinite(trace.clearance), trace.clearance, np.nan)
    axes.plot(trace.time, 1e3 * seen, color=_OURS, lw=1.2, label="by the map")
    if trace.true_clearance is not None:
        axes.plot(
            trace.time,
            1e3 * trace.true_clearance,
            color=_TRUE,
            lw=1.0,
            ls=(0, (4, 2)),
            label=f"true, at least {1e3 * trace.true_clearance.min():.1f} mm",
        )
    axes.axhline(0.0, color=_LIMIT, lw=1.2)
    axes.axhline(
        1e3 * stopping,
        color=_LIMIT,
        lw=0.8,
        ls="--",
        label=f"stopping distance, {1e3 * stopping:.0f} mm",
    )
    axes.set_ylabel(r"clearance $\tilde{d}$ [mm]")
    axes.set_ylim(bottom=min(-10.0, *axes.get_ylim()))
    axes.legend(
        loc="lower left",
        bbox_to_anchor=(0.0, 1.0),
        ncols=3,
        fontsize="small",
        frameon=False,
    )


def _mark_events(
    axes: "Axes", time: np.ndarray, events: Sequence[Event]
) -> None:
    """Draws a line at each new map and at each change of the supervisor."""
    for kind, color, label in (
        (MAP, _MAP, "another map"),
        (SUPERVISOR, _STOP, "supervisor"),
    ):
        times = [event.time for event in events if event.kind == kind]
        for t in times:
            # The first tick is not a change.
            if time[0] < t <= time[-1]:
                axes.axvline(t, color=color, lw=1.0, ls=":", label=label)
                label = ""
