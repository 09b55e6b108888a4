"""Makes the tables of a benchmark, with the paper's results for comparison."""

from collections.abc import Sequence

import numpy as np
from scipy.stats import binomtest

from remosplat_drake.base.table import Table
from remosplat_drake.benchmark.carrying_table import carrying_table
from remosplat_drake.benchmark.cells import (
    format_mean,
    format_median,
    format_rare,
    format_rate,
)
from remosplat_drake.benchmark.motion_table import motion_table
from remosplat_drake.benchmark.moving_table import moving_table
from remosplat_drake.benchmark.paper_results import PAPER_TRIALS, PaperRow
from remosplat_drake.benchmark.result import RULE_TITLES, RULES, TrialResult
from remosplat_drake.benchmark.robot_table import robot_table
from remosplat_drake.benchmark.scan_table import scan_table
from remosplat_drake.benchmark.summary import Comparison, Row, gather

KINEMATIC = "kinematic"
"""Name of the station with which the dynamic station is compared."""

COMMON = (
    ("average_distance", 3),
    ("gracefulness", 3),
    ("path_length", 3),
    ("acceleration", 3),
    ("duration", 2),
)
"""Fields of `Judgement` that are averaged over the trials that all methods
solve, with the number of decimals of each."""


def report_tables(results: Sequence[TrialResult]) -> list[Table]:
    """Makes all tables of some results, in the order of the comparisons."""
    tables, comparisons = [], gather(results)
    for comparison in comparisons:
        if comparison.is_robots:
            tables += [robot_table(comparison, RULES[0])]
            tables += [outcome_table(comparison)]
            continue
        first_table = scan_table if comparison.is_scan else main_table
        if comparison.is_moving:
            tables.append(moving_table(comparison))
        tables += [first_table(comparison, rule) for rule in RULES]
        if comparison.is_carrying:
            tables.append(carrying_table(comparison))
        if comparison.is_motion:
            tables.append(motion_table(comparison, RULES[0]))
        else:
            tables.append(family_table(comparison))
        tables += [
            outcome_table(comparison),
            timing_table(comparison),
        ]
        if len(comparison.rows) > 1:
            tables.append(paired_table(comparison))
    return tables + station_tables(comparisons)


def to_markdown(tables: Sequence[Table], heading: str) -> str:
    """Formats tables as one Markdown document with a heading."""
    parts = [f"# {heading}\n", *(table.to_markdown() for table in tables)]
    return "\n".join(parts)


def main_table(comparison: Comparison, rule: str) -> Table:
    """Makes a table like the paper's Table I; the paper's rows are included.

    Args:
        comparison: The methods to show, one method per row.
        rule: One of the success rules in `RULES`.
    """
    common = comparison.common(rule)
    rows, quoted = [], []
    for row in comparison.rows:
        rows.append(_main_row(row, rule, common))
        if row.method in comparison.paper:
            quoted.append(len(rows))
            rows.append(_paper_row(comparison.paper[row.method]))
    return Table(
        f"{comparison.title}: {RULE_TITLES[rule]}",
        (
            "method",
            "gains",
            "splat",
            "success [%]",
            "avg distance† [m]",
            "gracefulness† [m/s²]",
            "path† [m]",
            "rate-free acc.† [m/s²]",
            "time† [s]",
            "collisions",
            "min clearance [mm]",
            "QP [ms]",
        ),
        tuple(rows),
        f"† mean ± 95 % over the {int(common.sum())} scenes that every method "
        "of this table solves. Rates: solved/run with 95 % Wilson intervals. "
        "Collisions are judged by the true geometry, at ticks and at four "
        "points between them, and shown as count/run with the upper 95 % "
        "bound."
        + (
            f" The paper ran {PAPER_TRIALS} scenes." if comparison.paper else ""
        ),
        texts=3,
        quoted=frozenset(quoted),
    )


def _main_row(row: Row, rule: str, common: np.ndarray) -> tuple[str, ...]:
    over_common = [
        format_mean(row.values(field, rule, common), decimals)
        for field, decimals in COMMON
    ]
    everything = np.ones(len(row), bool)
    clearance = row.values("minimum_distance", rule, everything)
    solve = 1e3 * row.times("solve_mean")
    solve = solve[solve > 0]  # Not every controller solves a program.
    return (
        row.method,
        row.gains,
        row.splat_label,
        format_rate(int(row.successes(rule).sum()), len(row)),
        *over_common,
        format_rare(row.collisions(), len(row)),
        f"{1e3 * clearance.min():.1f}" if len(clearance) else "–",
        f"{solve.mean():.2f} ± {solve.std():.2f}" if len(solve) else "–",
    )


def _paper_row(paper: PaperRow) -> tuple[str, ...]:
    mean, std = paper.solve
    return (
        f"paper: {paper.label}",
        "paper",
        "",
        format_rate(paper.successes, PAPER_TRIALS),
        f"{paper.average_distance:.3f}",
        f"{paper.gracefulness:.3f}",
        f"{paper.path_length:.3f}",
        "",
        "",
        format_rare(paper.collisions, PAPER_TRIALS),
        "",
        f"{mean:.2f} ± {std:.2f}",
    )


def family_table(comparison: Comparison) -> Table:
    """Makes the table of success by family, for both success rules."""
    families = comparison.families()
    rows = []
    for row in comparison.rows:
        cells = []
        for rule in RULES:
            solved = row.successes(rule)
            for family in families:
                of_family = np.array([t.family == family for t in row.trials])
                hits = int((solved & of_family).sum())
                cells.append(format_rate(hits, int(of_family.sum())))
        rows.append((row.method, *cells))
    header = [f"{family}, {rule} [%]" for rule in RULES for family in families]
    return Table(
        f"{comparison.title}: success by family",
        ("method", *header),
        tuple(rows),
    )


def outcome_table(comparison: Comparison) -> Table:
    """Makes the table of failures and their reasons, by the paper's rule."""
    outcomes = comparison.outcomes()
    return Table(
        f"{comparison.title}: outcomes, by the rule in the paper's text",
        ("method", "trials", "success", "collision", *outcomes),
        tuple(
            (
                row.method,
                str(len(row)),
                str(int(row.successes("text").sum())),
                str(row.count("collision", "text")),
                *(str(row.count(outcome, "text")) for outcome in outcomes),
            )
            for row in comparison.rows
        ),
        "local minimum: the robot is at rest at the time limit; timeout: it "
        "still moves; infeasible: the last quadratic program has no "
        "solution; error: the scene cannot be used.",
    )


def timing_table(comparison: Comparison) -> Table:
    """Makes the table of tick durations and achievable control rates."""
    rows = []
    for row in comparison.rows:
        p50, p99 = 1e3 * row.times("tick_p50"), 1e3 * row.times("tick_p99")
        paper = comparison.paper.get(row.method)
        rate = "" if paper is None or not paper.rate else f"{paper.rate:g}"
        rows.append(
            (
                row.method,
                row.splat_label,
                format_median(p50, 2),
                format_median(p99, 2),
                format_median(1e3 / p50, 0),
                rate,
                format_median(row.times("trial"), 1),
            )
        )
    return Table(
        f"{comparison.title}: timing",
        (
            "method",
            "splat",
            "tick p50 [ms]",
            "tick p99 [ms]",
            "rate possible [Hz]",
            "paper [Hz]",
            "trial [s]",
        ),
        tuple(rows),
        "Medians over the trials; several trials ran at the same time.",
        texts=2,
    )


def paired_table(comparison: Comparison) -> Table:
    """Makes the table of paired comparisons of each method with the first."""
    first, *others = comparison.rows
    rows = []
    for row in others:
        cells = []
        for rule in RULES:
            cells += _mcnemar(row.successes(rule), first.successes(rule))
        rows.append((row.method, *cells))
    header = [
        f"{what}, {rule}"
        for rule in RULES
        for what in ("only this", f"only {first.method}", "p")
    ]
    return Table(
        f"{comparison.title}: paired with {first.method}",
        ("method", *header),
        tuple(rows),
        "Numbers of scenes that only one of the two solves; p by McNemar's "
        "exact test.",
    )


def station_tables(comparisons: Sequence[Comparison]) -> list[Table]:
    """Makes the tables that compare the two stations for each method."""
    rows: dict[tuple, Row] = {
        (
            row.method,
            comparison.suite,
            row.spheres,
            row.gains,
            row.scenes,
            row.station,
        ): row
        for comparison in comparisons
        for row in comparison.rows
    }
    lines = []
    for (*setup, station), row in rows.items():
        ideal = rows.get((*setup, KINEMATIC))
        if station == KINEMATIC or ideal is None:
            continue
        a, b = row.successes("text"), ideal.successes("text")
        only_row, only_ideal, p = _mcnemar(a, b)
        lines.append(
            (
                f"{row.method}, {row.spheres} spheres",
                format_rate(int(b.sum()), len(b)),
                format_rate(int(a.sum()), len(a)),
                only_ideal,
                only_row,
                p,
                format_rare(row.collisions(), len(row)),
            )
        )
    header = (
        "method",
        "kinematic [%]",
        "dynamic [%]",
        "only kinematic",
        "only dynamic",
        "p",
        "collisions, dynamic",
    )
    notes = (
        "Numbers of scenes that only one of the two solves; p by McNemar's "
        "exact test."
    )
    title = "Stations compared, success by the paper's text"
    return [Table(title, header, tuple(lines), notes)] if lines else []


def _mcnemar(a: np.ndarray, b: np.ndarray) -> tuple[str, str, str]:
    """Applies McNemar's exact test to the success of two methods.

    Args:
        a: Success of the first method in each scene, shape (n,) bool.
        b: Success of the second method in the same scenes, shape (n,) bool.

    Returns:
        The numbers of scenes that only a solves and that only b solves, and
        the two-sided p-value, as text.
    """
    only_a, only_b = int((a & ~b).sum()), int((b & ~a).sum())
    n = only_a + only_b
    p = binomtest(only_a, n).pvalue if n else 1.0
    return str(only_a), str(only_b), f"{p:.3g}"
