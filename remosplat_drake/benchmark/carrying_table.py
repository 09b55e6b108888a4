"""Makes the table of problems in which the robot carries an object back."""

from collections.abc import Sequence

import numpy as np

from remosplat_drake.base.table import Table
from remosplat_drake.benchmark.cells import (
    format_median,
    format_rare,
    format_rate,
)
from remosplat_drake.benchmark.motion_table import ALL
from remosplat_drake.benchmark.result import (
    COLLISION,
    SUCCESS,
    CarryingResult,
    TrialResult,
)
from remosplat_drake.benchmark.summary import Comparison, Row

RULE = "text"
"""The success rule that decides whether the target was reached."""


def carrying_table(comparison: Comparison) -> Table:
    """Makes the table, with one row per method and family.

    Args:
        comparison: The methods to show. In their trials, the robot carries the
            object back.
    """
    families = comparison.families()
    return Table(
        f"{comparison.title}: carried back",
        (
            "method",
            "family",
            "reached [%]",
            "taken",
            "carried back [%]",
            "collisions",
            "least distance [mm]",
            "time, median [s]",
            "why not",
        ),
        tuple(
            (row.method, *_cells(family, _of_family(row.trials, family)))
            for row in comparison.rows
            for family in (*families, ALL)
        ),
        "Carried back: number of problems in which the end effector reached "
        "the target, and then returned to its first pose with the object. The "
        "object may touch its support until it is lifted off. Only the hand "
        "may touch the object; any other contact of object or robot is a "
        "collision. "
        "Collisions are judged by the true shapes of object and scene, at "
        "ticks and at four points between them. Times are measured from the "
        "grasp.",
        texts=2,
    )


def carrying_document(row: Row) -> dict:
    """Collects a method's results for `benchmark --json`.

    Args:
        row: The trials of a method, in which the robot carries the object back.
    """
    judged = [t.carrying for t in row.trials if t.carrying is not None]
    return {
        "taken": sum(c.taken for c in judged),
        "carried_back": len(_carried_back(row.trials)),
        "collisions": sum(c.outcome == COLLISION for c in judged),
    }


def _carried_back(trials: Sequence[TrialResult]) -> list[CarryingResult]:
    """Returns which reached problems were successfully carried back."""
    return [
        t.carrying
        for t in trials
        if t.success(RULE) and t.carrying and t.carrying.outcome == SUCCESS
    ]


def _of_family(trials: Sequence[TrialResult], family: str) -> list[TrialResult]:
    return [t for t in trials if family in (ALL, t.family)]


def _cells(family: str, trials: list[TrialResult]) -> tuple[str, ...]:
    reached = [t for t in trials if t.success(RULE)]
    judged = [t.carrying for t in trials if t.carrying is not None]
    back = _carried_back(trials)
    least = min((c.minimum_distance for c in judged), default=None)
    reasons = [c.reason for c in judged if c.taken and c.reason]
    return (
        family,
        format_rate(len(reached), len(trials)),
        str(sum(c.taken for c in judged)),
        format_rate(len(back), len(reached)),
        format_rare(sum(c.outcome == COLLISION for c in judged), len(trials)),
        "–" if least is None else f"{1e3 * least:.1f}",
        format_median(np.array([c.duration for c in back]), 1),
        "; ".join(dict.fromkeys(reasons)) or "–",
    )
