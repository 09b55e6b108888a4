"""`remosplat doctor`: checks that a real robot may move."""

import argparse
import copy
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
from rich.console import Console

from remosplat_drake.app.compiling import compiling_shown
from remosplat_drake.app.hardware_run import prepare_for_hardware
from remosplat_drake.app.scenario import Scenario, load_scenario
from remosplat_drake.app.scenario_robot import load_scenario_robot
from remosplat_drake.app.velocity_run import build_velocity_run, play
from remosplat_drake.app.warm_up import compile_kernels
from remosplat_drake.app.world import load_world
from remosplat_drake.base.errors import RemoSplatError, unknown_name
from remosplat_drake.base.progress import Progress
from remosplat_drake.commands.json_output import add_json_argument, print_json
from remosplat_drake.commands.number_flags import positive
from remosplat_drake.commands.tables import open_console
from remosplat_drake.hardware.doctor import drills, host_checks, wire_checks
from remosplat_drake.hardware.doctor.doctor_report import (
    DoctorReport,
    default_path,
    needed_checks,
    this_host,
)
from remosplat_drake.hardware.doctor.drills import (
    BASE_STEP,
    DRILLS,
    EMERGENCY_STOP,
    USER_STOP,
    needed_drills,
)
from remosplat_drake.hardware.doctor.finding import (
    ADVICE,
    FAILED,
    PASSED,
    SKIPPED,
    Finding,
)
from remosplat_drake.robot.robot_model import RobotModel

_STYLES = {
    PASSED: "green",
    ADVICE: "yellow",
    FAILED: "bold red",
    SKIPPED: "dim",
}

EXAMPLES = """
remosplat doctor kitchen.yaml --skip all
remosplat doctor kitchen.yaml --lcm-url 'udpm://239.255.76.67:7667?ttl=1'
"""
"""Examples at the end of `--help`."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declares the command's flags."""
    parser.add_argument(
        "scenario",
        nargs="?",
        help=(
            "NAME, FILE or FILE:NAME (see `remosplat scenarios`): scenario "
            "with the robot and its LCM URL"
        ),
    )
    parser.add_argument(
        "--lcm-url",
        metavar="URL",
        help="LCM URL of the robot's drivers (default: the scenario's"
        " hardware.lcm_url)",
    )
    parser.add_argument(
        "--report",
        type=Path,
        metavar="FILE",
        help=(
            "file of the report (default: the file that `run --hardware` reads)"
        ),
    )
    parser.add_argument(
        "--yes",
        action="store_true",
        help="begin each drill (a test with motion or with a stop button) "
        "without confirmation; the robot MOVES",
    )
    parser.add_argument(
        "--skip",
        action="append",
        default=[],
        metavar="DRILL",
        help=(
            f"skip a drill: one of {', '.join(DRILLS)}, or all. The report "
            "then does not permit a real robot to be driven"
        ),
    )
    parser.add_argument(
        "--patience",
        type=positive,
        default=drills.PATIENCE,
        metavar="S",
        help="longest time to wait until a person presses or releases a stop "
        "button, in seconds (default: %(default)s)",
    )
    add_json_argument(parser)


def run(arguments: argparse.Namespace) -> int:
    """Runs all checks; returns 1 if the report does not permit motion."""
    console = open_console(stderr=arguments.json, soft_wrap=True)
    for name in arguments.skip:
        if name not in (*DRILLS, "all"):
            problem = unknown_name("drill", name, [*DRILLS, "all"])
            raise RemoSplatError(f"--skip: {problem}")
    scenario = load_scenario(arguments.scenario)
    hardware = scenario.hardware
    if arguments.lcm_url:
        hardware.use_url(arguments.lcm_url)
    robot = load_scenario_robot(scenario)
    findings = []
    for finding in _examine(scenario, robot, arguments, console):
        findings.append(finding)
        show_finding(finding, console)
    report = DoctorReport(
        this_host(), hardware.url, time.time(), tuple(findings)
    )
    path = arguments.report or default_path()
    report.save(path)
    console.print(f"the report is {path}")
    lacking = report.lacking(needed_checks(robot.n_base > 0))
    if lacking and not report.failed:
        console.print(
            "the report does not permit a run; missing checks: "
            f"{', '.join(lacking)}"
        )
    if arguments.json:
        print_json(report)
    return 1 if report.failed else 0


def _examine(
    scenario: Scenario,
    robot: RobotModel,
    arguments: argparse.Namespace,
    console: Console,
) -> Iterator[Finding]:
    """Runs all checks, in the order of a robot's start-up; yields findings."""
    hardware, has_base = scenario.hardware, robot.n_base > 0
    yield host_checks.check_clock()
    yield host_checks.check_priority()
    yield host_checks.check_buffers(scenario.camera is not None)
    yield wire_checks.check_loopback(hardware.url)
    packets = wire_checks.hear_wire(hardware.url)
    publishers = wire_checks.check_publishers(packets, hardware, has_base)
    yield from publishers
    yield wire_checks.check_reach(packets, hardware)
    yield from wire_checks.check_statuses(
        packets, hardware, len(robot.description.arm.joints), has_base
    )
    yield drills.check_thresholds()
    yield drills.check_actuators(robot)
    if any(finding.result == FAILED for finding in publishers):
        yield from (
            Finding(
                name, SKIPPED, "an earlier check has failed", DRILLS[name], ""
            )
            for name in needed_drills(has_base)
        )
        return
    yield from _drill(scenario, robot, arguments, console)


def _drill(
    scenario: Scenario,
    robot: RobotModel,
    arguments: argparse.Namespace,
    console: Console,
) -> Iterator[Finding]:
    """Runs the drills that a person confirms, and yields their findings."""
    watched = drills.WatchedRobot(scenario.hardware, robot)

    def say(text: str) -> None:
        console.print(f"[bold]{text}[/bold]")

    def stop(name: str, stopped: Callable[[], str]) -> Finding:
        return drills.drill_stop(
            name, stopped, watched, say, arguments.patience
        )

    begin = {
        BASE_STEP: lambda: drills.drill_base_step(
            lambda: _base_speeds(scenario, console)
        ),
        USER_STOP: lambda: stop(USER_STOP, watched.arm_stop),
        EMERGENCY_STOP: lambda: stop(EMERGENCY_STOP, watched.base_stop),
    }
    for name in needed_drills(robot.n_base > 0):
        left_out = {name, "all"} & set(arguments.skip)
        if left_out or not (arguments.yes or _agreed(name)):
            why = "--skip" if left_out else "no person agreed"
            yield Finding(name, SKIPPED, why, DRILLS[name], "a person", "")
        else:
            yield begin[name]()


def _base_speeds(
    scenario: Scenario, console: Console
) -> tuple[np.ndarray, np.ndarray]:
    """Commands a step of the base's speed through the diagram of all runs.

    Returns:
        Times of the ticks since the first one [s], and the measured speeds of
        the base [m/s], shape (n,) each.
    """
    scenario = copy.deepcopy(scenario)
    prepare_for_hardware(scenario, None)
    with (
        Progress(console) as progress,
        compiling_shown(progress, scenario),
    ):
        world = load_world(scenario)
        compile_kernels(scenario, world, plans=False)
    step = drills.base_step(world.robot, scenario.control_period)
    ticks = play(build_velocity_run(scenario, world), step)
    told = [(tick.sent, tick.measurement.base) for tick in ticks]
    times = np.array([sent for sent, _ in told])
    speeds = [0.0 if base is None else base.velocity[0] for _, base in told]
    return times - times[0], np.array(speeds)


def _agreed(name: str) -> bool:
    """Returns the answer at the terminal; False if there is no terminal."""
    if not sys.stdin.isatty():
        return False
    answer = input(f"{name}: {DRILLS[name]}. Go on? [y/N] ")
    return answer.strip().lower() in ("y", "yes")


def show_finding(finding: Finding, console: Console) -> None:
    """Prints the result of a check, and a remedy if the check failed."""
    style = _STYLES[finding.result]
    console.print(
        f"[{style}]{finding.result:8}[/] {finding.check}: {finding.found}"
    )
    if finding.result != PASSED:
        console.print(f"         wanted: {finding.wanted}")
        if finding.source:
            console.print(f"         source: {finding.source}")
        if finding.remedy:
            console.print(f"         remedy: {finding.remedy}")
