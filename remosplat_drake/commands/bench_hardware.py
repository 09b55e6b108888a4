"""Runs the groups of `remosplat bench` that drive a robot over LCM."""

import math
from collections.abc import Sequence
from pathlib import Path

from rich.console import Console

from remosplat_drake.acceptance.fault_campaign import FaultResult, run_case
from remosplat_drake.acceptance.fault_cases import CASES
from remosplat_drake.acceptance.hardware_processes import (
    STAND_IN,
    wire_works,
)
from remosplat_drake.acceptance.loop_cases import (
    RATES,
    load,
    measure_detection,
    measure_loop,
)
from remosplat_drake.app.scenario import load_scenario
from remosplat_drake.app.world import load_world
from remosplat_drake.base.errors import RemoSplatError, unknown_name
from remosplat_drake.base.progress import Progress
from remosplat_drake.base.real_time import LoopQuality, Spread
from remosplat_drake.base.table import Table
from remosplat_drake.commands.json_output import write_json
from remosplat_drake.commands.tables import open_console, print_table


def run_faults(
    console: Console,
    only: str = "",
    stand_in: Sequence[str] = STAND_IN,
    path: Path | None = None,
) -> list[FaultResult]:
    """Runs the fault campaign and prints a table.

    Args:
        console: Console for the table.
        only: Text. Only cases whose names contain it run; "" selects all cases.
        stand_in: Command line of the simulated robot, which takes the arguments
            of `hardware-sim`.
        path: JSON file that receives the results so far after each case; None
            writes no file.

    Raises:
        RemoSplatError: No case has such a name, this computer does not
            receive its own multicasts, or the file cannot be written.
    """
    cases = [case for case in CASES if only in case.name]
    if not cases:
        names = [case.name for case in CASES]
        raise RemoSplatError(unknown_name("fault", only, names))
    _check_wire()
    world = load_world(load_scenario())
    results, news = [], open_console(stderr=True)
    with Progress(news) as progress:
        for case in progress.over(cases, "breaking things"):
            result = run_case(case, world, stand_in)
            news.print(f"{case.name}: {result.problem or 'as expected'}")
            news.print(f"  {result.reason or result.case.outcome}", style="dim")
            results.append(result)
            if path is not None:
                write_json(path, fault_rows(results))
    print_table(console, fault_table(results))
    console.print(load())
    return results


def run_loops(console: Console) -> list[LoopQuality]:
    """Measures the real-time loop at every rate and prints a table."""
    _check_wire()
    console.print(load())
    with Progress(open_console(stderr=True)) as progress:
        loops = [measure_loop(rate) for rate in progress.over(RATES, "driving")]
    print_table(console, loop_table(loops))
    return loops


def run_detection(console: Console) -> list[LoopQuality]:
    """Measures the loop while cameras detect movers, and prints a table."""
    _check_wire()
    console.print(load())
    loops = [measure_detection()]
    print_table(console, loop_table(loops))
    return loops


def _check_wire() -> None:
    if not wire_works():
        raise RemoSplatError(
            "this computer does not receive its own multicasts; run `ip"
            " link set lo multicast on` and `ip route add 224.0.0.0/4 dev"
            " lo`"
        )


def fault_table(results: list[FaultResult]) -> Table:
    """Makes the table of a fault campaign, with one row per injected fault."""
    return Table(
        "",
        (
            "fault",
            "released",
            "result",
            "to rest [ms]",
            "then moved [mm]",
            "clearance [mm]",
        ),
        tuple(
            (
                result.case.name,
                result.resumed or "–",
                result.problem or "as expected",
                _milli(result.time_to_zero, 0),
                _milli(result.moved_after, 2),
                _milli(result.clearance, 1),
            )
            for result in results
        ),
        texts=3,
    )


def fault_rows(results: list[FaultResult]) -> list[dict]:
    """Converts a fault campaign's results to JSON types; NaN becomes null."""
    rows = []
    for result in results:
        case = result.case
        row = {"fault": case.name, "expected": case.outcome, **vars(result)}
        del row["case"]
        rows.append(
            {
                name: None if isinstance(x, float) and math.isnan(x) else x
                for name, x in row.items()
            }
        )
    return rows


def _milli(value: float, decimals: int) -> str:
    return "–" if math.isnan(value) else f"{1e3 * value:.{decimals}f}"


def loop_table(loops: list[LoopQuality]) -> Table:
    """Makes the table of loop timing, with one row per control rate."""
    return Table(
        "",
        (
            "rate",
            "status to command [ms]",
            "image to command [ms]",
            "period jitter [ms]",
            "work of a tick [ms]",
            "processor time [ms]",
            "ticks",
            "left out",
            "without new status",
        ),
        tuple(
            (
                f"{1 / loop.period:.0f} Hz",
                _spread(loop.age),
                "–"
                if loop.image_to_command is None
                else _spread(loop.image_to_command),
                _spread(loop.jitter),
                _spread(loop.work),
                _spread(loop.busy),
                *(str(n) for n in (loop.ticks, loop.missed, loop.unheard)),
            )
            for loop in loops
        ),
        "Times: p50 / p99 / max.",
    )


def _spread(spread: Spread) -> str:
    values = (spread.p50, spread.p99, spread.max)
    return " / ".join(_milli(value, 2) for value in values)
