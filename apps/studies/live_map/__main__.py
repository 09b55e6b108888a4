"""Measures the cost of a live map for the control loop, in time and memory."""

import argparse
import dataclasses as dc
import json
import sys
import tempfile
from collections.abc import Callable, Sequence
from pathlib import Path

from rich.console import Console
from rich.progress import Progress
from rich.table import Table

from apps.studies.command_line import output_file, study_main
from apps.studies.live_map.cases import (
    QUIET,
    LivePeriods,
    measure_periods,
    measure_unknown,
)
from apps.studies.live_map.drift import DriftErrors, drifting, measure_drift
from apps.studies.live_map.memory import (
    LiveMemory,
    measure_memory,
)
from apps.studies.live_map.memory_use import MemoryTrend
from apps.studies.live_map.session import LiveSession
from remosplat_drake.acceptance.loop_cases import load
from remosplat_drake.app.scenario import Scenario, load_scenario
from remosplat_drake.app.teleop_session import check_mappable
from remosplat_drake.app.world import load_world
from remosplat_drake.base.atomic_file import atomic_write
from remosplat_drake.base.real_time import Spread
from remosplat_drake.commands.number_flags import positive
from remosplat_drake.visualization.page import MeshcatPage

SCENARIO = "StudioLive"

_LATENCY = 2.0
"""Fixed latency of the maps while memory is measured [s]."""

_FRAMES = 12
"""Largest number of a map's frames meanwhile; memory may grow until it is
reached."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declares the study's flags."""
    parser.add_argument(
        "--scenario",
        default=SCENARIO,
        help="NAME, FILE or FILE:NAME (%(default)s)",
    )
    parser.add_argument(
        "--minutes",
        type=positive,
        default=5.0,
        metavar="MIN",
        help="simulated time of the memory measurement (%(default)g)",
    )
    parser.add_argument(
        "--drift",
        type=positive,
        metavar="S",
        help="instead, drive for this simulated time with odometry that drifts"
        " by 2 cm/s",
    )
    parser.add_argument(
        "--json",
        type=output_file,
        metavar="FILE",
        help="JSON file for the numbers",
    )
    parser.add_argument(
        "--rounds",
        type=int,
        default=3,
        help="number of maps of each kind in real time; 0: only measure memory"
        " (%(default)s)",
    )


def run(arguments: argparse.Namespace) -> int:
    """Measures two sessions in real time, and the memory of a long session.

    Raises:
        RemoSplatError: A session cannot begin, or makes no map.
    """
    console, spec = Console(), arguments.scenario
    if arguments.drift:
        console.print(drift_table(_drift(arguments.drift)))
        return 0
    check_mappable(load_scenario(spec))
    console.print(load())
    numbers: dict = {}
    with Progress(console=Console(stderr=True), transient=True) as progress:
        task = progress.add_task("", total=None)

        def tell(stage: str) -> None:
            progress.update(task, description=stage)

        if arguments.rounds > 0:
            for page in (None, MeshcatPage()):
                name = "no page" if page is None else "page served"
                numbers[name] = _by_the_clock(
                    console, spec, name, page, arguments.rounds, tell
                )
        tell("watching memory")
        progress.update(task, total=60 * arguments.minutes)
        memory = _memory(
            spec,
            arguments.minutes,
            lambda time: progress.update(task, completed=time),
        )
    console.print(memory_table(memory))
    console.print(load())
    if arguments.json:
        numbers |= {"memory": dc.asdict(memory), "load": load()}
        with atomic_write(arguments.json) as file:
            json.dump(numbers, file, indent=1)
    return 0


def _scenario(spec: str) -> Scenario:
    """Loads the scenario with asynchronous guidance, as on a real robot."""
    scenario = load_scenario(spec)
    scenario.controller.guidance.asynchronous = True
    return scenario


def _by_the_clock(
    console: Console,
    spec: str,
    name: str,
    page: MeshcatPage | None,
    rounds: int,
    tell: Callable[[str], None],
) -> dict:
    """Measures and prints the timing of a session that runs in real time.

    Args:
        console: Console that shows the tables.
        spec: Name of the scenario.
        name: Name of the session in the tables.
        page: Meshcat page that is served meanwhile; None for no page.
        rounds: Number of maps of each kind.
        tell: Callback for the name of each stage.

    Returns:
        The measured numbers, by name.
    """
    scenario = _scenario(spec)
    world = load_world(scenario, blank=True)
    with tempfile.TemporaryDirectory() as parent:
        folder = Path(parent) / "session"
        with LiveSession(scenario, world, folder, page) as session:
            periods = measure_periods(
                session,
                folder,
                rounds=rounds,
                on_stage=lambda stage: tell(f"{name}: {stage}"),
            )
            unknown = measure_unknown(session, scenario)
    console.print(period_table(periods, name))
    console.print(swap_table(periods, name))
    console.print(unknown_table(unknown, name))
    spreads = {kind: dc.asdict(spread) for kind, spread in unknown.items()}
    return dc.asdict(periods) | {"unknown": spreads}


def _memory(
    spec: str, minutes: float, on_time: Callable[[float], None]
) -> LiveMemory:
    """Measures the memory of a session with a page, which needs more memory.

    The page's traces of hand and base add to it until they are 30 m long.
    """
    scenario = _scenario(spec)
    scenario.mapping.latency = _LATENCY
    scenario.mapping.max_frames = _FRAMES
    world = load_world(scenario, blank=True)
    with tempfile.TemporaryDirectory() as parent:
        folder = Path(parent) / "session"
        with LiveSession(scenario, world, folder, MeshcatPage()) as session:
            return measure_memory(session, minutes, on_time=on_time)


def _drift(seconds: float) -> DriftErrors:
    """Drives a session whose odometry drifts, with frames of 160x120."""
    scenario = drifting("wrist_camera: {width: 160, height: 120}")
    scenario.mapping.latency = 0.5
    world = load_world(scenario, blank=True)
    assert world.truth is not None
    with (
        tempfile.TemporaryDirectory() as parent,
        LiveSession(scenario, world, Path(parent) / "session") as session,
    ):
        return measure_drift(session, world.truth, seconds)


def drift_table(errors: DriftErrors) -> Table:
    """Makes a table of the errors of base and map."""
    table = Table(
        "p50/p99/max",
        "error [mm]",
        title=f"{errors.seconds:g} s, {1e3 * errors.drift:.0f} mm of drift,"
        f" {errors.versions} versions",
    )
    table.add_row("base, in the map", _spread(errors.base, 2))
    table.add_row("discs, from true surfaces", _spread(errors.surfaces, 2))
    return table


def period_table(periods: LivePeriods, name: str) -> Table:
    """Makes a table with one row for each kind of map under construction."""
    table = Table(
        "in the making",
        title=name,
        pad_edge=False,
        caption="p50/p99/max; x: p50 and p99, over those of the first row",
    )
    for heading in ("period [ms]", "x", "tick [ms]", "x", "late"):
        table.add_column(heading, justify="right")
    quiet = periods.times[QUIET]
    for kind, times in periods.times.items():
        table.add_row(
            kind,
            _spread(times.period, 1),
            _ratios(times.period, quiet.period),
            _spread(times.work, 1),
            _ratios(times.work, quiet.work),
            str(times.late),
        )
    return table


def swap_table(periods: LivePeriods, name: str) -> Table:
    """Makes a table with one row for each map that took effect."""
    table = Table("new map", title=name)
    for heading in (
        "announced to in effect [ms]",
        "tick of the change [ms]",
        "first tick on it [ms]",
    ):
        table.add_column(heading, justify="right")
    for swap in periods.swaps:
        values = (swap.latency, swap.tick, swap.next_tick)
        table.add_row(swap.effort, *(f"{1e3 * v:.1f}" for v in values))
    return table


def unknown_table(spreads: dict[str, Spread], name: str) -> Table:
    """Makes a table of the cost of unknown space as an obstacle."""
    table = Table("unknown space is", title=name, caption="p50/p99/max")
    table.add_column("oracle and controller [ms]", justify="right")
    for kind, spread in spreads.items():
        table.add_row(kind, _spread(spread, 2))
    return table


def memory_table(memory: LiveMemory) -> Table:
    """Makes a table with one row per process."""
    table = Table(
        "memory [MB]",
        title=f"{memory.minutes:g} simulated minutes, {memory.maps} changes of"
        f" the map, at most {_FRAMES} frames in each",
        caption="slope per minute after the first third",
    )
    for heading in (
        "after a third",
        "at the end",
        "most",
        "trend",
        "without files",
    ):
        table.add_column(heading, justify="right")
    for name, use in (
        ("control process", memory.control),
        ("mapping process", memory.mapping),
    ):
        table.add_row(name, *_trend(use))
    return table


def _trend(use: MemoryTrend) -> list[str]:
    sizes = [f"{size:.1f}" for size in (use.first, use.last, use.most)]
    return [*sizes, f"{use.slope:+.3f}", f"{use.own_slope:+.3f}"]


def _spread(spread: Spread, decimals: int) -> str:
    values = (spread.p50, spread.p99, spread.max)
    return "/".join(f"{1e3 * value:.{decimals}f}" for value in values)


def _ratios(spread: Spread, quiet: Spread) -> str:
    return f"{spread.p50 / quiet.p50:.2f} {spread.p99 / quiet.p99:.2f}"


def main(argv: Sequence[str] | None = None) -> int:
    """Runs the study from its command line and returns its exit code."""
    return study_main("live_map", __doc__, add_arguments, run, argv)


if __name__ == "__main__":
    sys.exit(main())
