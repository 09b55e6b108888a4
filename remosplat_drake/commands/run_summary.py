"""Prints the summary of a run that has ended."""

from rich.console import Console
from rich.table import Table
from rich.text import Text

from remosplat_drake.app.run_result import REACHED, RunResult
from remosplat_drake.base.real_time import LoopQuality, Spread
from remosplat_drake.recording.metrics import RunMetrics


def print_summary(
    result: RunResult, facts: list[tuple[str, str]], console: Console
) -> None:
    """Prints the outcome of a run and its measurements.

    Args:
        result: Result of the run.
        facts: Names and values, from `facts_of`.
        console: Console for the output.
    """
    table = Table(show_header=False, box=None, pad_edge=False)
    style = "bold green" if result.outcome == REACHED else "bold red"
    table.add_row("outcome", Text(result.motion_status.text, style))
    for name, value in facts:
        table.add_row(name, value)
    console.print(table)


def facts_of(
    result: RunResult, loop: LoopQuality | None
) -> list[tuple[str, str]]:
    """Returns the measurements of a run as text, keyed by name.

    Args:
        result: Result of the run.
        loop: Timing of a real robot's loop; None in a simulation.
    """
    metrics = result.metrics
    truth = metrics.truth_clearance_min, metrics.truth_clearance_mean
    facts = [
        ("time", f"{metrics.duration:.2f} s"),
        (
            "clearance (oracle)",
            _millimetres(metrics.clearance_min, metrics.clearance_mean),
        ),
        ("clearance (truth)", _millimetres(*truth)),
    ]
    if metrics.unseen_clearance_min is not None:
        facts.append(("unseen space", _unseen(metrics)))
    most, mean = metrics.line_deviation_max, metrics.line_deviation_mean
    if most is not None and mean is not None:
        beside = f"max {1e3 * most:.1f} mm, mean {1e3 * mean:.1f} mm"
        facts.append(("deviation from the line", beside))
    facts += [
        (
            "path",
            f"{_paths(metrics)}, base {metrics.base_path_length:.3f} m",
        ),
        (
            "tick",
            f"p50 {1e3 * metrics.tick_p50:.2f} ms,"
            f" p99 {1e3 * metrics.tick_p99:.2f} ms"
            f" ({metrics.control_rate:.0f} Hz possible)",
        ),
    ]
    if loop is not None:
        facts += [
            ("status to command", _spread(loop.age)),
            ("period jitter", _spread(loop.jitter)),
            (
                "loop",
                f"{loop.ticks} ticks, {loop.missed} skipped, {loop.unheard} "
                "without a new status",
            ),
        ]
        if loop.image_to_command is not None:
            facts.append(("image to command", _spread(loop.image_to_command)))
    statuses = ", ".join(f"{k} {v}" for k, v in metrics.statuses.items())
    return [*facts, ("ticks", f"{metrics.ticks}: {statuses}")]


def _paths(metrics: RunMetrics) -> str:
    paths = metrics.effector_paths or {"end effector": metrics.path_length}
    return ", ".join(f"{name} {path:.3f} m" for name, path in paths.items())


def _unseen(metrics: RunMetrics) -> str:
    """Prints the smallest distance to unseen space."""
    least = metrics.unseen_clearance_min or 0.0
    if not metrics.unseen_ticks:
        return f"min {1e3 * least:.1f} mm away"
    return (
        f"entered for {metrics.unseen_ticks} ticks, up to"
        f" {-1e3 * least:.1f} mm deep"
    )


def _spread(spread: Spread) -> str:
    return (
        f"p50 {1e3 * spread.p50:.2f} ms, p99 {1e3 * spread.p99:.2f} ms,"
        f" max {1e3 * spread.max:.2f} ms"
    )


def _millimetres(minimum: float | None, mean: float | None) -> str:
    if minimum is None or mean is None:
        return "unknown"
    return f"min {1e3 * minimum:.1f} mm, mean {1e3 * mean:.1f} mm"
