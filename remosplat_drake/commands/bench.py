"""`remosplat bench`: measures times on this machine."""

import argparse
import dataclasses as dc
from collections.abc import Callable
from functools import partial
from pathlib import Path

from remosplat_drake.base.atomic_file import check_writable
from remosplat_drake.base.errors import FileError, RemoSplatError
from remosplat_drake.base.progress import Progress
from remosplat_drake.base.strict_json import parse_json
from remosplat_drake.base.table import Table
from remosplat_drake.commands.bench_hardware import (
    fault_rows,
    run_detection,
    run_faults,
    run_loops,
)
from remosplat_drake.commands.json_output import print_json, write_json
from remosplat_drake.commands.tables import open_console, print_table
from remosplat_drake.timing.depth_cases import depth_cases
from remosplat_drake.timing.file_cases import file_cases
from remosplat_drake.timing.guidance_cases import guidance_cases
from remosplat_drake.timing.measuring import Case, Timing, measure
from remosplat_drake.timing.mesh_cases import PACKAGES as MESH_PACKAGES
from remosplat_drake.timing.mesh_cases import mesh_cases
from remosplat_drake.timing.object_cases import object_cases
from remosplat_drake.timing.optional_packages import advice
from remosplat_drake.timing.oracle_cases import oracle_cases
from remosplat_drake.timing.planning_cases import planning_cases
from remosplat_drake.timing.self_collision_cases import self_collision_cases
from remosplat_drake.timing.solver_cases import PACKAGES as SOLVER_PACKAGES
from remosplat_drake.timing.solver_cases import solver_cases
from remosplat_drake.timing.tick_cases import tick_cases

GROUPS: dict[str, Callable[[], list[Case]]] = {
    "tick": tick_cases,
    "oracle": oracle_cases,
    "files": file_cases,
    "depth": depth_cases,
    "guidance": guidance_cases,
    "planning": planning_cases,
    "objects": object_cases,
    "self-collision": self_collision_cases,
    "solvers": solver_cases,
    "mesh": mesh_cases,
}
"""For each group of timed cases, the function that makes the cases."""

OTHERS = {"solvers": SOLVER_PACKAGES, "mesh": MESH_PACKAGES}
"""For each group, packages of other projects. If they are installed, the group
times them, too."""

ON_A_WIRE = ("hardware", "detection", "faults")
"""Groups that run the real-time loop with the simulated robot of `remosplat
hardware-sim`. Each of these groups prints its own table."""

EXAMPLES = """
remosplat bench tick
remosplat bench --compare before.json
"""
"""Examples at the end of `--help`."""


STDOUT = "-"
"""Value of `--json` if no file is given."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declares the command's flags."""
    parser.add_argument(
        "group",
        nargs="?",
        choices=[*GROUPS, *ON_A_WIRE],
        help=(
            "time only this group of cases (default: all groups except "
            "hardware, detection and faults). These three groups drive the "
            "simulated robot of `remosplat hardware-sim`: hardware in real "
            "time, detection with cameras that see a moving person, and "
            "faults with injected faults"
        ),
    )
    parser.add_argument(
        "--scenario", help="scenario for the groups tick and solvers"
    )
    parser.add_argument(
        "--case",
        metavar="TEXT",
        default="",
        help="with the group faults: inject only faults whose names contain "
        "this text",
    )
    parser.add_argument(
        "--json",
        nargs="?",
        const=STDOUT,
        metavar="FILE",
        help=(
            "also write the numbers to FILE; without FILE: print only one "
            "JSON document to stdout"
        ),
    )
    parser.add_argument(
        "--compare",
        type=Path,
        metavar="FILE",
        help="show ratios to the timings in a file that --json wrote earlier",
    )


def run(arguments: argparse.Namespace) -> int:
    """Measures every case and prints one table."""
    console = open_console(stderr=arguments.json == STDOUT)
    if arguments.group != "faults" and arguments.case:
        raise RemoSplatError("--case chooses among faults")
    if arguments.group in ON_A_WIRE:
        for flag in ("scenario", "compare"):
            if getattr(arguments, flag):
                raise RemoSplatError(
                    f"--{flag} has no effect on the group "
                    f"{arguments.group}; leave it out"
                )
    if arguments.json not in (None, STDOUT):
        check_writable(Path(arguments.json))
    if arguments.group in ("hardware", "detection"):
        drive = run_loops if arguments.group == "hardware" else run_detection
        loops = drive(console)
        _write(arguments.json, [dc.asdict(loop) for loop in loops])
        return 0
    if arguments.group == "faults":
        path = None if arguments.json in (None, STDOUT) else arguments.json
        results = run_faults(console, arguments.case, path=path and Path(path))
        if arguments.json == STDOUT:
            print_json(fault_rows(results))
        return 1 if any(result.problem for result in results) else 0
    earlier = _read(arguments.compare) if arguments.compare else {}
    makers = {
        **GROUPS,
        "tick": partial(tick_cases, arguments.scenario),
        "solvers": partial(solver_cases, arguments.scenario),
    }
    chosen = [arguments.group] if arguments.group else GROUPS
    news, timings = open_console(stderr=True), []
    for group in chosen:
        # The order of the groups matters: the last groups load further
        # libraries, which change the scheduling of threads.
        with Progress(news) as progress:
            cases = progress.over(makers[group](), f"measuring {group}")
            timings += [measure(case) for case in cases]
    others = (package for group in chosen for package in OTHERS.get(group, ()))
    print_table(console, _table(timings, earlier, advice(others)))
    _write(arguments.json, [dc.asdict(timing) for timing in timings])
    return 0


def _write(path: str | None, rows: list[dict]) -> None:
    if path == STDOUT:
        print_json(rows)
    elif path is not None:
        write_json(Path(path), rows)


def _read(path: Path) -> dict[str, float]:
    try:
        rows = parse_json(path.read_text(), path)
        return {row["name"]: float(row["p50"]) for row in rows}
    except OSError as error:
        raise FileError(path, error.strerror or str(error)) from error
    except (ValueError, KeyError, TypeError) as error:
        raise FileError(
            path, "is not a file that --json has written"
        ) from error


def _table(
    timings: list[Timing], earlier: dict[str, float], notes: str
) -> Table:
    header = ["case", "p50 [ms]", "p99 [ms]", "max [ms]", "calls"]
    with_checks = any(timing.checks is not None for timing in timings)
    if with_checks:
        header += ["checks", "µs per check"]
    if earlier:
        header.append("p50 / earlier")
    rows = []
    for timing in timings:
        times = (timing.p50, timing.p99, timing.longest)
        row = [timing.name, *(f"{1e3 * time:.3f}" for time in times)]
        row.append(str(timing.calls))
        if with_checks:
            row += _checks(timing)
        if earlier:
            before = earlier.get(timing.name)
            row.append(f"{timing.p50 / before:.2f}" if before else "")
        rows.append(tuple(row))
    return Table("", tuple(header), tuple(rows), notes)


def _checks(timing: Timing) -> tuple[str, str]:
    """Returns the number of checks of a search, and the time of each."""
    if timing.checks is None or timing.per_check is None:
        return "", ""
    return f"{timing.checks:.0f}", f"{1e6 * timing.per_check:.0f}"
