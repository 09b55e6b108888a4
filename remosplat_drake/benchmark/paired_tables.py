"""Tables of two methods, or two stations, scene by scene."""

from collections.abc import Sequence

from remosplat_drake.benchmark.formatting import format_rare, format_rate
from remosplat_drake.benchmark.result import RULES
from remosplat_drake.benchmark.statistics import mcnemar
from remosplat_drake.benchmark.summary import Comparison, Row
from remosplat_drake.benchmark.tables import Table

KINEMATIC = "kinematic"
"""The station that others are compared with."""


def paired_table(comparison: Comparison) -> Table:
    """Every method against the first, scene by scene."""
    first, *others = comparison.rows
    rows = []
    for row in others:
        cells = []
        for rule in RULES:
            only_row, only_first, p = mcnemar(
                row.successes(rule), first.successes(rule)
            )
            cells += [str(only_row), str(only_first), f"{p:.3g}"]
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
        "Scenes that only one of the two solves; p by McNemar's exact test.",
    )


def station_tables(comparisons: Sequence[Comparison]) -> list[Table]:
    """The dynamic station against the kinematic one, method by method."""
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
        only_row, only_ideal, p = mcnemar(a, b)
        lines.append(
            (
                f"{row.method}, {row.spheres} spheres",
                format_rate(int(b.sum()), len(b)),
                format_rate(int(a.sum()), len(a)),
                str(only_ideal),
                str(only_row),
                f"{p:.3g}",
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
    notes = "Scenes that only one of the two solves; p by McNemar's exact test."
    title = "Stations compared, success by the paper's text"
    return [Table(title, header, tuple(lines), notes)] if lines else []
