"""Makes the table of trials with movers: contacts, and their causes."""

import numpy as np

from remosplat_drake.base.table import Table
from remosplat_drake.benchmark.cells import (
    format_median,
    format_rare,
    format_rate,
)
from remosplat_drake.benchmark.summary import Comparison, Row
from remosplat_drake.recording.mover_contacts import (
    RESTING,
    RETREATING,
    TOWARDS,
    UNSEEN,
)

RULE = "text"
"""The success rule of the table."""

NOTES = (
    "Numbers of scenes, by the worst contact between the robot and a mover, "
    "at and between ticks. Towards: the touching link moved towards the "
    "mover, so the robot caused the contact. Out of unseen space: the link "
    "moved towards the mover, but at some time after the mover came nearer "
    "than the protective separation distance, no camera saw it. Retreating: "
    "the mover caught up with a link that moved away or sideways. At rest: "
    "the link did not move. Reached: the robot arrived without the first two "
    "kinds of contact, and without a collision with the scene. Reachable: at "
    "least one method of the table arrived, with or without contacts. Waited, "
    "time: medians over the scenes that were reached."
)


def moving_table(comparison: Comparison) -> Table:
    """Makes the table, with one row per method.

    Args:
        comparison: The methods to show, whose trials have movers.
    """
    return Table(
        f"{comparison.title}: with movers",
        (
            "method",
            "reached [%]",
            "of reachable [%]",
            "towards",
            "out of unseen space",
            "retreating",
            "at rest",
            "collisions with the scene",
            "least distance [mm]",
            "waited [s]",
            "time [s]",
            "tick [ms]",
        ),
        tuple(_row(row, reachable(comparison)) for row in comparison.rows),
        NOTES,
    )


def reached(row: Row) -> np.ndarray:
    """Returns whether each trial arrived without causing a contact."""
    faults = np.isin(worst_contacts(row), (TOWARDS, UNSEEN))
    return row.successes(RULE) & ~faults


def worst_contacts(row: Row) -> np.ndarray:
    """Returns the worst kind of contact of each trial; "" without contact."""
    return np.array(
        [t.moving.worst if t.moving else "" for t in row.trials], str
    )


def reachable(comparison: Comparison) -> np.ndarray:
    """Returns the scenes in which at least one method arrived."""
    arrived = [row.successes(RULE) for row in comparison.rows]
    return np.logical_or.reduce(arrived)


def _row(row: Row, reachable: np.ndarray) -> tuple[str, ...]:
    good, worst = reached(row), worst_contacts(row)
    judged = [t.moving for t in row.trials if t.moving is not None]
    least = min((m.distance for m in judged), default=None)
    waited = np.array(
        [
            t.moving.waited
            for t, g in zip(row.trials, good, strict=True)
            if g and t.moving is not None
        ]
    )
    return (
        row.method,
        format_rate(int(good.sum()), len(row)),
        format_rate(int((good & reachable).sum()), int(reachable.sum())),
        format_rare(int((worst == TOWARDS).sum()), len(row)),
        str(int((worst == UNSEEN).sum())),
        str(int((worst == RETREATING).sum())),
        str(int((worst == RESTING).sum())),
        str(row.collisions()),
        "–" if least is None else f"{1e3 * least:.0f}",
        format_median(waited, 1),
        format_median(row.values("duration", RULE, good), 1),
        format_median(1e3 * row.times("tick_p50"), 1),
    )


def moving_document(row: Row) -> dict:
    """Collects a method's results with movers for `benchmark --json`.

    Args:
        row: The trials of a method, with movers.
    """
    good, worst = reached(row), worst_contacts(row)
    return {
        "reached": int(good.sum()),
        **{
            kind: int((worst == kind).sum())
            for kind in (TOWARDS, UNSEEN, RETREATING, RESTING)
        },
    }
