"""Summarises a comparison: as a table, a sentence, and a JSON document."""

from collections.abc import Sequence

import numpy as np

from remosplat_drake.base.table import Table
from remosplat_drake.benchmark.carrying_table import (
    carrying_document,
    carrying_table,
)
from remosplat_drake.benchmark.cells import (
    format_median,
    format_rate,
    rate_interval,
)
from remosplat_drake.benchmark.moving_table import (
    moving_document,
    moving_table,
)
from remosplat_drake.benchmark.paper_results import PAPER_TRIALS
from remosplat_drake.benchmark.result import RULES
from remosplat_drake.benchmark.summary import Comparison, Row, gather

RULE = RULES[0]
"""The success rule of the overview: the rule in the paper's text."""


def overview_table(comparison: Comparison) -> Table:
    """Makes the table of the most important columns, with one row per method.

    Args:
        comparison: The methods to show.
    """
    if comparison.is_moving:
        return moving_table(comparison)
    if comparison.is_carrying:
        return carrying_table(comparison)
    rows = []
    for row in comparison.rows:
        paper = comparison.paper.get(row.method)
        least = _least_clearance(row)
        rows.append(
            (
                row.method,
                format_rate(_successes(row), len(row)),
                ""
                if paper is None
                else f"{100 * paper.successes / PAPER_TRIALS:.1f}",
                str(row.collisions()),
                "–" if least is None else f"{1e3 * least:.1f}",
                format_median(1e3 * row.times("tick_p50"), 2),
            )
        )
    header = ("method", "reached [%]", "paper [%]", "collisions")
    return Table(
        comparison.title,
        (*header, "least clearance [mm]", "tick [ms]"),
        tuple(rows),
        "Reached: by the rule in the paper's text, with 95 % intervals. "
        "Ticks: median.",
    )


def headline(comparison: Comparison) -> str:
    """Returns a sentence or two on the methods that reach most targets.

    Args:
        comparison: The methods to compare.
    """
    most = max(map(_successes, comparison.rows))
    best = [row for row in comparison.rows if _successes(row) == most]
    count, several = len(best[0]), len(best) > 1
    low, high = rate_interval(most, count)
    collisions = sum(row.collisions() for row in best)
    touched = "never" if not collisions else f"{collisions} times"
    text = (
        f"{', '.join(row.method for row in best)} "
        f"{'reach' if several else 'reaches'} the most targets: {most} of "
        f"{count} ({100 * low:.0f} to {100 * high:.0f} % with 95 % "
        f"confidence), colliding {touched}."
    )
    run = [row for row in comparison.rows if row.method in comparison.paper]
    if not run:
        return text
    papers = max(run, key=lambda row: comparison.paper[row.method].successes)
    theirs = comparison.paper[papers.method].successes / PAPER_TRIALS
    return (
        f"{text} Of the paper's methods in this comparison, {papers.method} "
        f"has the highest success in the paper, {100 * theirs:.1f} %; here it "
        f"reaches {_successes(papers)} of {len(papers)}."
    )


def document(trials: Sequence) -> dict:
    """Collects results into the document of `benchmark --json`.

    Args:
        trials: The results of all trials.
    """
    return {"comparisons": [_entry(c) for c in gather(trials)]}


def _entry(comparison: Comparison) -> dict:
    first = comparison.rows[0]
    return {
        "title": comparison.title,
        "suite": comparison.suite,
        "families": comparison.families(),
        "spheres": first.spheres,
        "station": first.station,
        "scenes": len(first),
        "methods": [_method(row, comparison) for row in comparison.rows],
    }


def _method(row: Row, comparison: Comparison) -> dict:
    paper = comparison.paper.get(row.method)
    ticks = {name: row.times(name) for name in ("tick_p50", "tick_p99")}
    return {
        "method": row.method,
        "gains": row.gains,
        "splat": row.splat,
        "trials": len(row),
        "reached": {rule: int(row.successes(rule).sum()) for rule in RULES},
        "collisions": row.collisions(),
        "least_clearance": _least_clearance(row),
        **{
            name: float(np.median(times)) if len(times) else None
            for name, times in ticks.items()
        },
        "moving": moving_document(row) if comparison.is_moving else None,
        "carrying": carrying_document(row) if comparison.is_carrying else None,
        "paper": paper and {"trials": PAPER_TRIALS, "reached": paper.successes},
    }


def _successes(row: Row) -> int:
    return int(row.successes(RULE).sum())


def _least_clearance(row: Row) -> float | None:
    values = row.values("minimum_distance", RULE, np.ones(len(row), bool))
    return float(values.min()) if len(values) else None
