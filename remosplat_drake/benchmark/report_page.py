"""Writes the report as one page of HTML, with tables and plots."""

import dataclasses as dc
import html
from collections.abc import Callable, Sequence

import numpy as np

from remosplat_drake.base.html_report import (
    OTHERS,
    OURS,
    cards,
    make_page,
    new_plot,
    to_svg,
)
from remosplat_drake.base.table import Table
from remosplat_drake.benchmark.cells import rate_interval
from remosplat_drake.benchmark.overview import headline, overview_table
from remosplat_drake.benchmark.paper_results import PAPER_TRIALS
from remosplat_drake.benchmark.result import TrialResult
from remosplat_drake.benchmark.summary import Comparison, Row, gather

_WIDTH = 6.4
"""Width of a plot [inches]."""


def to_html(
    results: Sequence[TrialResult], tables: Sequence[Table], heading: str
) -> str:
    """Makes a self-contained HTML page with plots and the report's tables."""
    parts = [_overview(comparison) for comparison in gather(results)]
    if tables:
        parts.append("<h2>All tables</h2>")
        parts += [table.to_html() for table in tables]
    return make_page(heading, "\n".join(parts))


def _overview(comparison: Comparison) -> str:
    """Makes the overview of a comparison: sentence, cards, table and plots."""
    table = overview_table(comparison)
    rows, common = comparison.rows, comparison.common("text")
    numbers = {
        "scenes": f"{len(rows[0]):,}",
        "methods": str(len(rows)),
        "trials": f"{sum(map(len, rows)):,}",
        "scenes that all methods reach": str(int(common.sum())),
        "collisions": str(sum(row.collisions() for row in rows)),
    }
    return "\n".join(
        [
            f"<h2>{html.escape(table.title)}</h2>",
            f'<p class="trust">{html.escape(headline(comparison))}</p>',
            cards(numbers),
            dc.replace(table, title="").to_html(),
            _figures(comparison),
        ]
    )


def _figures(comparison: Comparison) -> str:
    plots = {
        "Success by the paper's text": _success_plot(comparison),
        "Smallest true clearance": _box_plot(
            comparison, "minimum_distance", "clearance [m]"
        ),
        "End-effector acceleration": _box_plot(
            comparison, "gracefulness", "mean |a| [m/s²]"
        ),
        "Time of a control tick": _timing_plot(comparison),
        "Control rate and splats": _rate_plot(comparison),
    }
    figures = "\n".join(
        f"<figure><figcaption>{html.escape(caption)}</figcaption>{svg}</figure>"
        for caption, svg in plots.items()
        if svg
    )
    return f'<div class="plots">{figures}</div>'


def _success_plot(comparison: Comparison) -> str:
    """Plots the success of each method and the paper's results."""

    def draw(axes):
        for place, row in enumerate(comparison.rows):
            solved = int(row.successes("text").sum())
            _draw_rate(axes, place - 0.12, solved, len(row), OURS)
            paper = comparison.paper.get(row.method)
            if paper is not None:
                _draw_rate(
                    axes, place + 0.12, paper.successes, PAPER_TRIALS, OTHERS
                )
        axes.set_xlim(0, 102)
        axes.set_xlabel(
            "success [%], 95 % interval (blue: ours, orange: the paper)"
        )

    return _methods_plot(comparison, draw)


def _box_plot(comparison: Comparison, field: str, label: str) -> str:
    """Plots the distribution of a field of `Judgement` over all trials."""
    return _values_plot(
        comparison,
        lambda row: row.values(field, "text", np.ones(len(row), bool)),
        label,
    )


def _timing_plot(comparison: Comparison) -> str:
    """Plots the distribution of the median tick duration of the trials."""
    return _values_plot(
        comparison, lambda row: 1e3 * row.times("tick_p50"), "tick [ms]", True
    )


def _rate_plot(comparison: Comparison) -> str:
    """Plots the control rate over the number of splats, if there are any."""
    rows = [row for row in comparison.rows if row.splat != "none"]
    if not rows:
        return ""
    axes, figure = new_plot(_WIDTH, 3.5)
    for row in rows:
        timed = [t for t in row.trials if t.times is not None]
        axes.plot(
            [t.splat_count for t in timed],
            [1 / t.times.tick_p50 for t in timed if t.times is not None],
            ".",
            label=row.method,
        )
    axes.set_xlabel("splats")
    axes.set_ylabel("control rate possible [Hz]")
    axes.set_yscale("log")
    axes.legend(frameon=False)
    return to_svg(figure)


def _draw_rate(axes, y: float, successes: int, count: int, color: str):
    low, high = rate_interval(successes, count)
    rate = successes / count
    # At a rate of 0 or 1, a rounding error may exclude the rate from the
    # interval.
    below, above = max(rate - low, 0.0), max(high - rate, 0.0)
    axes.errorbar(
        100 * rate,
        y,
        xerr=[[100 * below], [100 * above]],
        fmt="o",
        color=color,
        capsize=3,
    )


def _values_plot(
    comparison: Comparison,
    values: Callable[[Row], np.ndarray],
    label: str,
    log: bool = False,
) -> str:
    def draw(axes):
        axes.boxplot(
            [values(row) for row in comparison.rows],
            orientation="horizontal",
            positions=range(len(comparison.rows)),
            whis=(0, 100),
            medianprops={"color": OURS, "lw": 2},
        )
        axes.set_xlabel(f"{label}: median, quartiles, range")
        axes.set_xscale("log" if log else "linear")

    return _methods_plot(comparison, draw)


def _methods_plot(comparison: Comparison, draw: Callable) -> str:
    """Makes a plot with one line per method; the first is on top."""
    names = [row.method for row in comparison.rows]
    axes, figure = new_plot(_WIDTH, 1 + 0.4 * len(names))
    draw(axes)
    axes.set_yticks(range(len(names)), names)
    axes.set_ylim(len(names) - 0.5, -0.5)
    axes.grid(axis="x", alpha=0.3)
    return to_svg(figure)
