"""Makes the table of random targets, with a row per robot and scene."""

import numpy as np

from remosplat_drake.base.table import Table
from remosplat_drake.benchmark.cells import format_rare, format_rate
from remosplat_drake.benchmark.result import COLLISION
from remosplat_drake.benchmark.summary import Comparison, Row


def robot_table(comparison: Comparison, rule: str) -> Table:
    """Makes the table of random targets, by robot and scene.

    Args:
        comparison: The methods to show.
        rule: One of the success rules in `RULES`.
    """
    return Table(
        f"random targets; {comparison.rows[0].spheres} spheres",
        (
            "method",
            "robot, scene",
            "reached [%]",
            "collisions",
            "min clearance [mm]",
            "min self-distance [mm]",
            "motion time, median [s]",
            "95 % [s]",
            "base path, median [m]",
            "planned [%]",
            "first path, median [ms]",
            "tick p50 [ms]",
        ),
        tuple(
            _row(row, family, rule)
            for row in comparison.rows
            for family in comparison.families()
        ),
        "Targets are hand poses of random configurations. In these "
        "configurations, the robot is at least 30 mm from the scene, each "
        "joint is at least a tenth of its range from its limits, and links "
        "keep the required distances from each other. Collisions with the "
        "scene are measured at ticks and at four points between them, with "
        "spheres that enclose all links. Distances between links are measured "
        "at ticks, with convex hulls. The columns of paths contain the number "
        "of targets to which a path was found, and the time of the search, "
        "with other load on the computer.",
        texts=2,
    )


def _row(row: Row, family: str, rule: str) -> tuple[str, ...]:
    chosen = np.array([t.family == family for t in row.trials])
    trials = [
        t for t, is_chosen in zip(row.trials, chosen, strict=True) if is_chosen
    ]
    solved = chosen & row.successes(rule)
    time = row.values("duration", rule, solved)
    way = row.values("base_path_length", rule, solved)
    clearance = 1e3 * row.values("minimum_distance", rule, chosen)
    own = [t.self_distance for t in trials if t.self_distance is not None]
    ticks = np.array([t.times.tick_p50 for t in trials if t.times is not None])
    searched = [t for t in trials if t.first_checks is not None]
    first_path = np.array([t.times.first_path for t in searched if t.times])
    collided = sum(t.outcome(rule) == COLLISION for t in trials)
    return (
        row.method,
        family,
        format_rate(int(solved.sum()), len(trials)),
        format_rare(collided, len(trials)),
        f"{clearance.min():.1f}" if len(clearance) else "–",
        f"{1e3 * min(own):.1f}" if own else "–",
        _percentile(time, 50),
        _percentile(time, 95),
        _percentile(way, 50),
        format_rate(len(searched), len(trials)),
        _percentile(1e3 * first_path, 50),
        _percentile(1e3 * ticks, 50),
    )


def _percentile(values: np.ndarray, percent: float) -> str:
    return f"{np.percentile(values, percent):.2f}" if len(values) else "–"
