"""Makes tables like the paper's Tables II and III, with the paper's rows."""

from collections import defaultdict

from remosplat_drake.base.table import Table
from remosplat_drake.benchmark.cells import format_mean
from remosplat_drake.benchmark.paper_results import (
    PAPER_SCANS,
    PAPER_TARGETS,
    PaperScanRow,
)
from remosplat_drake.benchmark.result import COLLISION, RULE_TITLES
from remosplat_drake.benchmark.summary import Comparison, Row


def scan_table(comparison: Comparison, rule: str) -> Table:
    """Makes a table like the paper's Tables II and III.

    Args:
        comparison: The methods to show, one method per row, above the paper's
            rows.
        rule: One of the success rules in `RULES`.
    """
    rows = [_row(row, rule) for row in comparison.rows]
    ours = len(rows)
    for family in comparison.families():
        rows += [_paper_row(paper) for paper in PAPER_SCANS[family]]
    return Table(
        f"{comparison.title}: {RULE_TITLES[rule]}",
        (
            "method",
            "gains",
            "splat",
            "success",
            "gracefulness [m/s²]",
            "rate-free acc. [m/s²]",
            "collisions",
            "min clearance [mm]",
            "not reached",
        ),
        tuple(rows),
        "Accelerations: mean ± 95 % over the targets that the row's method "
        "reaches, as in the paper's Tables II and III. Collisions and "
        "clearances are measured at ticks and at four points between them, "
        "with the true solids or, if these are unknown, with the capture's "
        "depth. The paper used another scene and other targets.",
        quoted=frozenset(range(ours, len(rows))),
    )


def _row(row: Row, rule: str) -> tuple[str, ...]:
    solved = row.successes(rule)
    clearance = row.values("minimum_distance", rule, solved | ~solved)
    touched = row.count(COLLISION, rule)
    return (
        row.method,
        row.gains,
        row.splat_label,
        f"{int(solved.sum())}/{len(row)}",
        format_mean(row.values("gracefulness", rule, solved), 3),
        format_mean(row.values("acceleration", rule, solved), 3),
        f"{touched}/{len(row)}",
        f"{1e3 * clearance.min():.1f}" if len(clearance) else "–",
        _not_reached(row, rule),
    )


def _not_reached(row: Row, rule: str) -> str:
    """Lists the targets that were not reached, grouped by reason."""
    targets = defaultdict(list)
    for trial in row.trials:
        if not trial.success(rule):
            target = trial.scene.rpartition("/")[2]
            targets[trial.outcome(rule)].append(target)
    return "; ".join(
        f"{outcome}: {', '.join(names)}" for outcome, names in targets.items()
    )


def _paper_row(paper: PaperScanRow) -> tuple[str, ...]:
    gracefulness, collisions = paper.gracefulness, paper.collisions
    return (
        f"paper: {paper.label}",
        "paper",
        "",
        f"{paper.successes}/{PAPER_TARGETS}",
        "–" if gracefulness is None else f"{gracefulness:.3f}",
        "",
        "–" if collisions is None else f"{collisions}/{PAPER_TARGETS}",
        "",
        "",
    )
