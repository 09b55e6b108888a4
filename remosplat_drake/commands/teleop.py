"""`remosplat teleop`: a person moves the target while the map grows."""

import argparse
import importlib.util
import json
import math
import time
from contextlib import ExitStack
from pathlib import Path

from rich.console import Console

from remosplat_drake.app.compiling import compiling_shown
from remosplat_drake.app.diagram import Application, build
from remosplat_drake.app.map_knowledge import examine_map, saved_places
from remosplat_drake.app.run_result import INTERRUPTED, TIME_LIMIT
from remosplat_drake.app.scenario import LONGEST_RUN, Scenario, load_scenario
from remosplat_drake.app.stages.cockpit import cockpit_job, first_picture
from remosplat_drake.app.stages.teleoperation import (
    Teleoperation,
    wrist_camera_mount,
)
from remosplat_drake.app.start import start_gates
from remosplat_drake.app.teleop_session import (
    check_mappable,
    holds_session,
    open_teleoperation,
    removed_on_failure,
)
from remosplat_drake.app.warm_up import compile_kernels
from remosplat_drake.app.world import World, load_world
from remosplat_drake.base.atomic_file import write_atomically
from remosplat_drake.base.errors import MissingExtraError, RemoSplatError
from remosplat_drake.base.progress import Progress
from remosplat_drake.base.tcp_port import check_free
from remosplat_drake.cockpit.cockpit_process import CockpitProcess
from remosplat_drake.cockpit.messages import CodeIssued
from remosplat_drake.commands.driving import (
    INCOMPLETE,
    drive,
    log_is_whole,
)
from remosplat_drake.commands.flags import (
    add_record_argument,
    opened_recorder,
)
from remosplat_drake.commands.gate_keeping import (
    Admission,
    add_accept_argument,
    admit,
    check_accepted,
)
from remosplat_drake.commands.number_flags import port_number, positive
from remosplat_drake.commands.tables import open_console
from remosplat_drake.commands.wire import (
    add_robot_arguments,
    prepare_robot,
)
from remosplat_drake.mapping.store.session import SCENARIO_FILE
from remosplat_drake.visualization.page import MeshcatPage

COCKPIT, MESHCAT = "cockpit", "meshcat"
VIEWERS = (COCKPIT, MESHCAT)
"""The kinds of operator's page."""

LOOPBACK = "127.0.0.1"
"""Network interface that other computers cannot reach."""

DEFAULT_SCENARIO = "StudioLive"
"""Name of the default scenario."""

MAP_KNOWLEDGE = "map_knowledge.json"
"""Name of a file in a run's folder. It contains the error and problems of the
scenario's map, and the problems that the operator accepted."""

EXAMPLES = """
remosplat teleop StudioLive
remosplat teleop --session sessions/monday
"""
"""Examples at the end of `--help`."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declares the command's flags."""
    parser.add_argument(
        "scenario",
        nargs="?",
        help=(
            "NAME, FILE or FILE:NAME (default: the scenario of the session, "
            f"or {DEFAULT_SCENARIO})"
        ),
    )
    parser.add_argument(
        "--session",
        type=Path,
        metavar="DIR",
        help=(
            "folder of a new session, or of a session to continue (default: "
            "a new folder in sessions/)"
        ),
    )
    add_robot_arguments(parser)
    parser.add_argument(
        "--trajectory",
        type=Path,
        metavar="FILE",
        help="file of target poses and button presses with their times, which "
        "replaces a person",
    )
    parser.add_argument(
        "--headless",
        action="store_true",
        help="serve no browser page; a file (--trajectory) or a stream of "
        "poses then moves the target",
    )
    parser.add_argument(
        "--realtime-rate",
        type=positive,
        metavar="R",
        help=(
            "speed of a simulation relative to the wall clock (default: the "
            "scenario's, or else 1)"
        ),
    )
    parser.add_argument(
        "--duration",
        type=positive,
        default=math.inf,
        metavar="S",
        help=(
            "end after this time [s] (default: end at Ctrl-C). Without a "
            "page, the run also ends when the robot is stopped"
        ),
    )
    parser.add_argument(
        "--viewer",
        choices=VIEWERS,
        default=COCKPIT,
        help="the operator's page: the cockpit, or Meshcat's, which supports a"
        " gamepad (default: %(default)s)",
    )
    parser.add_argument(
        "--host",
        default=LOOPBACK,
        metavar="ADDRESS",
        help=(
            "network interface on which the cockpit is served; 0.0.0.0 for "
            "all (default: this computer only)"
        ),
    )
    parser.add_argument(
        "--port",
        type=port_number,
        help="port of the page (default: first free)",
    )
    parser.add_argument(
        "--scenario-text",
        default="",
        metavar="YAML",
        help=(
            "YAML of settings that override the scenario, e.g. "
            "'{mapping: {voxel: 0.05}}'"
        ),
    )
    add_record_argument(parser)
    add_accept_argument(parser)


def run(arguments: argparse.Namespace) -> int:
    """Runs a teleoperation until Ctrl-C; returns 1 if the robot is stopped.

    It returns `INCOMPLETE` if a log or a recording is incomplete and the robot
    is not stopped.
    """
    console = open_console(stderr=True)
    check_accepted(arguments)
    scenario = _load_scenario(arguments)
    if not arguments.headless:
        check_free(arguments.host, arguments.port)
    folder = arguments.session or _new_folder(scenario)
    prepare_robot(arguments, scenario, console)
    check_mappable(scenario)
    with (
        Progress(console) as progress,
        compiling_shown(progress, scenario),
    ):
        world = load_world(scenario, blank=scenario.mapping.enabled)
        wrist_camera_mount(scenario, world.robot)
        admission = _admitted(arguments, scenario, world)
        compile_kernels(scenario, world, live_map=True)
    page, cockpit = _pages(arguments, console)
    teleoperation, application = _begin(
        arguments, scenario, world, page, cockpit, folder, admission, console
    )
    log = application.log
    assert log is not None
    # With a page, a stopped robot waits for its release on the page. A real
    # robot waits for a person who arms it, unless the run has a fixed duration.
    waits = arguments.hardware and math.isinf(arguments.duration)
    try:
        console.print(
            f"all data of the run are written to [bold]{folder}[/bold]"
        )
        url = page.url if page is not None else ""
        if cockpit is not None:
            url = cockpit.start(
                cockpit_job(
                    application,
                    teleoperation,
                    host=arguments.host,
                    port=arguments.port,
                    hardware=arguments.hardware,
                ),
                first_picture(application, teleoperation),
            )
        if url:
            console.print(f"operate at [bold]{url}[/bold]; Ctrl-C ends")
        result, _ = drive(
            application,
            console,
            rate=None if arguments.hardware else _rate(arguments, scenario),
            patience=math.inf if url or waits else 0.0,
        )
    finally:
        log.close()
        teleoperation.close()
        if cockpit is not None:
            cockpit.close()
    is_logged = log_is_whole(application, console)
    # The line is not wrapped, so that it can be copied.
    told = f"{result.motion_status.text}; `remosplat replay {folder}` shows it"
    console.print(told, soft_wrap=True)
    if result.outcome not in (INTERRUPTED, TIME_LIMIT):
        return 1
    return 0 if is_logged else INCOMPLETE


def _pages(
    arguments: argparse.Namespace, console: Console
) -> tuple[MeshcatPage | None, CockpitProcess | None]:
    """Returns the operator's page: the cockpit or Meshcat's.

    Raises:
        RemoSplatError: The port is taken, or viser is not installed.
    """
    if arguments.headless:
        return None, None
    if arguments.viewer == MESHCAT:
        return MeshcatPage(port=arguments.port), None
    if importlib.util.find_spec("viser") is None:
        raise MissingExtraError(
            "the cockpit (or use --viewer meshcat)", "cockpit"
        )

    def announce(issued: CodeIssued):
        why = f"{issued.why}; " if issued.why else ""
        code = f"[bold]{issued.code}[/bold]"
        console.print(f"{why}to operate, type the code {code} on the page")

    return None, CockpitProcess(announce)


def _rate(arguments: argparse.Namespace, scenario: Scenario) -> float:
    """Returns the real-time rate of a simulation, which is never unlimited."""
    if arguments.realtime_rate is not None:
        return arguments.realtime_rate
    if scenario.simulator is None:
        return 1.0
    return scenario.simulator.target_realtime_rate or 1.0


def _admitted(
    arguments: argparse.Namespace, scenario: Scenario, world: World
) -> Admission | None:
    """Returns the permission to begin a run; None if there is no map yet.

    Raises:
        RemoSplatError: The run is refused.
    """
    if scenario.mapping.enabled and not scenario.scene.splat:
        return None
    knowledge = examine_map(scenario, world, saved_places(scenario))
    gates = start_gates(scenario, world)
    return admit(knowledge, arguments, scenario.source, gates)


def _begin(
    arguments: argparse.Namespace,
    scenario: Scenario,
    world: World,
    page: MeshcatPage | None,
    cockpit: CockpitProcess | None,
    folder: Path,
    admission: Admission | None,
    console: Console,
) -> tuple[Teleoperation, Application]:
    """Begins or reopens the session; after an error, no file has changed."""
    with removed_on_failure(folder):
        teleoperation = open_teleoperation(
            scenario, world, folder, hardware=arguments.hardware
        )
        # These overrides apply only to this run: the session stores its
        # scenario without them.
        scenario.time_limit = min(arguments.duration, LONGEST_RUN)
        if arguments.trajectory is not None:
            scenario.teleop.trajectory = str(arguments.trajectory.resolve())
        with ExitStack() as undo:
            undo.callback(teleoperation.close)
            application = build(
                scenario,
                world,
                page,
                hardware=arguments.hardware,
                teleoperation=teleoperation,
                mcap=opened_recorder(arguments, scenario, world.robot),
                cockpit=cockpit,
            )
            if admission is not None:
                admission.announce(console)
                _keep(admission, teleoperation.run)
            undo.pop_all()
    return teleoperation, application


def _keep(admission: Admission, run: Path) -> None:
    text = json.dumps(admission.document(), indent=2) + "\n"
    write_atomically(run / MAP_KNOWLEDGE, text)


def _load_scenario(arguments: argparse.Namespace) -> Scenario:
    """Loads the scenario, with overrides from the flags.

    Raises:
        RemoSplatError: Flags contradict each other, or a file is unusable.
    """
    spec, folder = arguments.scenario, arguments.session
    if folder is not None and holds_session(folder):
        if spec is not None:
            raise RemoSplatError(
                f"{folder} is an existing session with its own scenario; give "
                "no scenario name, or choose another folder"
            )
        spec = str(folder / SCENARIO_FILE)
    scenario = load_scenario(spec or DEFAULT_SCENARIO, arguments.scenario_text)
    operator = scenario.teleop
    sources = arguments.trajectory, operator.trajectory, operator.pose_stream
    by_meshcat = arguments.viewer == MESHCAT
    if arguments.host != LOOPBACK and (by_meshcat or arguments.headless):
        raise RemoSplatError(
            "--host: needs the cockpit, in which only a client with the "
            "operator's code moves the robot; leave out --viewer meshcat and "
            "--headless"
        )
    if arguments.hardware and by_meshcat and not any(sources):
        raise RemoSplatError(
            "--hardware: Meshcat's page can only stop a real robot; use the "
            "cockpit, or let another program move the target, by "
            "--trajectory FILE or teleop.pose_stream in the scenario"
        )
    if arguments.headless and not any(sources):
        raise RemoSplatError(
            "--headless: without a page, another program must move the "
            "target, by --trajectory FILE or teleop.pose_stream in the "
            "scenario"
        )
    return scenario


def _new_folder(scenario: Scenario) -> Path:
    name = scenario.name
    return Path("sessions") / f"{name}-{time.strftime('%Y%m%d-%H%M%S')}"
