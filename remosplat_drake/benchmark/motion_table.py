"""Makes the table of MotionBenchMaker's problems."""

import numpy as np

from remosplat_drake.base.table import Table
from remosplat_drake.benchmark.cells import format_rare, format_rate
from remosplat_drake.benchmark.result import COLLISION, ERROR
from remosplat_drake.benchmark.summary import Comparison, Row

ALL = "all"
"""Family name of the rows over all families."""


def motion_table(comparison: Comparison, rule: str) -> Table:
    """Makes the table of problems, with one row per method and family.

    Args:
        comparison: The methods to show.
        rule: One of the success rules in `RULES`.
    """
    families = comparison.families()
    return Table(
        f"{comparison.title}: by family ({rule})",
        (
            "method",
            "family",
            "reached [%]",
            "collisions",
            "errors",
            "min clearance [mm]",
            "motion time, median [s]",
            "95 % [s]",
            "motion / joint path",
            "jerk, largest [%]",
            "torque, largest [%]",
            "planned [%]",
            "first path, median [ms]",
            "95 % [ms]",
            "checks, median",
            "tick p50 [ms]",
        ),
        tuple(
            _row(row, family, rule)
            for row in comparison.rows
            for family in (*families, ALL)
        ),
        "Neither the map nor the true scene contains the object that the hand "
        "encloses at the goal. In problems with the object, only the hand may "
        "touch it. Collisions are judged by the true geometry, at ticks and "
        "at four points between them. Motion times are computed over the "
        "problems that the row's method reaches. Motion / joint path is the "
        "ratio of the motion time to the time of a straight path in joint "
        "space to the given goal configuration, at the velocity limits and "
        "without regard to obstacles. Jerk is the second difference of the "
        "commands. Torque is the torque that the commands require with an "
        "empty hand. Jerk and torque are relative to the limits in the "
        "robot's description and model file. The columns on paths contain the "
        "number of problems in which a path was found, the time of the search "
        "(with other load on the computer), and the number of configurations "
        "and motions that the search checked. Errors are problems that cannot "
        "be used; they count as not reached.",
        texts=2,
    )


def _row(row: Row, family: str, rule: str) -> tuple[str, ...]:
    chosen = np.array([family in (ALL, t.family) for t in row.trials])
    trials = [
        t for t, is_chosen in zip(row.trials, chosen, strict=True) if is_chosen
    ]
    solved = chosen & row.successes(rule)
    time = row.values("duration", rule, solved)
    clearance = row.values("minimum_distance", rule, chosen)
    straight = np.array(
        [t.joint_time or np.nan for t in trials if t.success(rule)]
    )
    ratio = time / straight
    ratio = ratio[np.isfinite(ratio)]
    ticks = np.array([t.times.tick_p50 for t in trials if t.times is not None])
    searched = [t for t in trials if t.first_checks is not None]
    first_path = np.array([t.times.first_path for t in searched if t.times])
    collided = sum(t.outcome(rule) == COLLISION for t in trials)
    return (
        row.method,
        family,
        format_rate(len(time), len(trials)),
        format_rare(collided, len(trials)),
        str(sum(t.outcome(rule) == ERROR for t in trials)),
        f"{1e3 * clearance.min():.1f}" if len(clearance) else "–",
        _percentile(time, 50),
        _percentile(time, 95),
        _percentile(ratio, 50),
        _largest(row.values("jerk", rule, solved)),
        _largest(row.values("torque", rule, solved)),
        format_rate(len(searched), len(trials)),
        _percentile(1e3 * first_path, 50, 0),
        _percentile(1e3 * first_path, 95, 0),
        _percentile(np.array([t.first_checks for t in searched]), 50, 0),
        _percentile(1e3 * ticks, 50),
    )


def _largest(shares: np.ndarray) -> str:
    known = shares[np.isfinite(shares)]
    return f"{100 * known.max():.0f}" if len(known) else "–"


def _percentile(values: np.ndarray, percent: float, digits: int = 2) -> str:
    if not len(values):
        return "–"
    return f"{np.percentile(values, percent):.{digits}f}"
