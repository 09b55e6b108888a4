"""Compares a control loop's times with and without slow clients of its page.

The same run is repeated in real time, in turns without clients and with clients
that draw two pictures a second. The study prints medians and 99th percentiles
of the durations of ticks, and of the processor time of the control thread in a
control period, which includes the drawing on the page.
"""

import argparse
import multiprocessing as mp
import sys
import time
from collections.abc import Sequence

import numpy as np

from apps.studies.command_line import (
    add_count_flag,
    check_least,
    study_main,
)
from apps.studies.slow_clients.client import watch
from remosplat_drake.app.diagram import build
from remosplat_drake.app.scenario import Scenario, load_scenario
from remosplat_drake.app.simulation import run as simulate
from remosplat_drake.app.world import World, load_world
from remosplat_drake.base.table import Table
from remosplat_drake.visualization.page import MeshcatPage
from remosplat_drake.visualization.page_state import STOP, PageState

_CONNECTS = 1.0
"""Time for which clients may connect and receive the scene [s]."""

_FIRST = 0.5
"""Beginning of a run that does not count, for caches [s]."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declares the study's flags."""
    parser.add_argument(
        "scenario",
        nargs="?",
        default="TableReach",
        help="NAME, FILE or FILE:NAME (default: %(default)s)",
    )
    add_count_flag(parser, "rounds", 10, "number of runs of each kind")
    add_count_flag(parser, "clients", 2, "number of slow clients")


def run(arguments: argparse.Namespace) -> int:
    """Runs in turns, and prints the table."""
    check_least("slow_clients", arguments, rounds=1, clients=1)
    scenario = load_scenario(arguments.scenario)
    world = load_world(scenario)
    measure(scenario, world, 0)  # It loads what the first run would wait for.
    kinds = 0, arguments.clients
    runs = [
        {clients: measure(scenario, world, clients) for clients in kinds}
        for _ in range(arguments.rounds)
    ]
    print(table_of(runs).to_markdown(), end="")
    return 0


def measure(scenario: Scenario, world: World, clients: int) -> np.ndarray:
    """Measures one run.

    Args:
        scenario: The scenario.
        world: The content of its files.
        clients: Number of slow clients of its page.

    Returns:
        Duration of each tick, and the processor time of the control thread in
        each control period, shape (2, n) [s].
    """
    page = MeshcatPage()
    application = build(scenario, world, page)
    page.show(PageState("live", "Live", "", (STOP,)))
    ports = page.port, page.meshcat.port()
    context = mp.get_context("spawn")
    watchers = [
        context.Process(target=watch, args=ports, daemon=True)
        for _ in range(clients)
    ]
    for watcher in watchers:
        watcher.start()
    if watchers:
        while page.meshcat.GetNumActiveConnections() < clients:
            time.sleep(0.1)
        time.sleep(_CONNECTS)
    page.start_recording()
    ticks, works, last = [], [], time.thread_time()

    def look(t: float, _, report) -> None:
        nonlocal last
        now = time.thread_time()
        if report is not None and t >= _FIRST:
            ticks.append(report.timings["total"])
            works.append(now - last)
        last = now

    simulate(application, realtime_rate=1.0, on_progress=look)
    for watcher in watchers:
        watcher.kill()
        watcher.join()
    return np.array([ticks, works])


def table_of(runs: Sequence[dict[int, np.ndarray]]) -> Table:
    """Makes a table of the times and of the medians' ratio.

    Args:
        runs: The times of pairs of runs, by their number of clients.
    """
    rows = []
    for i, name in enumerate(("tick", "control thread, per period")):
        without, with_clients = (
            np.concatenate([pair[clients][i] for pair in runs])
            for clients in runs[0]
        )
        ratios = [
            np.median(slow[i]) / np.median(free[i])
            for free, slow in map(dict.values, runs)
        ]
        rows.append(
            (
                name,
                _times(without),
                _times(with_clients),
                f"{np.median(ratios):.2f}",
            )
        )
    clients = max(runs[0])
    header = (
        "milliseconds, median / 99 %",
        "no client",
        f"{clients} slow clients",
        "ratio of medians",
    )
    return Table("", header, tuple(rows))


def _times(values: np.ndarray) -> str:
    median, late = 1e3 * np.percentile(values, [50, 99])
    return f"{median:.2f} / {late:.1f}"


def main(argv: Sequence[str] | None = None) -> int:
    """Runs the study from its command line."""
    return study_main("slow_clients", __doc__, add_arguments, run, argv)


if __name__ == "__main__":
    sys.exit(main())
