"""`remosplat run`: runs one scenario, with a browser page or headless."""

import argparse
import math
import time
from pathlib import Path
from threading import current_thread, main_thread

from rich.console import Console

from remosplat_drake.app.compiling import compiling_shown
from remosplat_drake.app.diagram import build
from remosplat_drake.app.map_knowledge import examine_map, target_places
from remosplat_drake.app.run_files import (
    METRICS,
    TRAJECTORY,
    run_document,
    save_result,
)
from remosplat_drake.app.run_result import INTERRUPTED, REACHED, RunResult
from remosplat_drake.app.scenario import Scenario
from remosplat_drake.app.start import start_gates
from remosplat_drake.app.warm_up import compile_kernels
from remosplat_drake.app.world import load_world
from remosplat_drake.base.atomic_file import atomic_write, check_writable
from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.base.progress import Progress
from remosplat_drake.base.tcp_port import check_free
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
    add_accept_argument,
    admit,
    check_accepted,
)
from remosplat_drake.commands.hold import (
    add_page_arguments,
    add_viewer_argument,
    hold,
    is_held,
    is_waited_for,
    open_page,
    wait_for_start,
)
from remosplat_drake.commands.json_output import add_json_argument, print_json
from remosplat_drake.commands.number_flags import not_negative
from remosplat_drake.commands.ready import goal_in_words, show_start
from remosplat_drake.commands.run_page import (
    account_of,
    show_verdict,
    show_warnings,
)
from remosplat_drake.commands.run_summary import facts_of, print_summary
from remosplat_drake.commands.splat_scenario import load_given
from remosplat_drake.commands.tables import open_console
from remosplat_drake.commands.wire import (
    add_robot_arguments,
    prepare_robot,
)
from remosplat_drake.visualization.first_view import draw_first
from remosplat_drake.visualization.motion_status_view import draw_end
from remosplat_drake.visualization.page import MeshcatPage
from remosplat_drake.visualization.page_state import (
    PageState,
    ended,
    preparing,
    unsupervised,
)

EXAMPLES = """
remosplat run BookshelfReach
remosplat run scan.ply --save-scenario scan.yaml
remosplat run TableReach --hardware --rehearsal
"""
"""Examples at the end of `--help`."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declares the command's flags."""
    parser.add_argument(
        "scenario",
        nargs="?",
        help="NAME, FILE or FILE:NAME of a scenario (see `remosplat "
        "scenarios`), or a splat file, for which the command generates a "
        "scenario",
    )
    parser.add_argument(
        "--save-scenario",
        type=Path,
        metavar="FILE.yaml",
        help=(
            "file to which the command writes the scenario that it generates "
            "for a splat"
        ),
    )
    parser.add_argument(
        "--headless",
        action="store_true",
        help="run without a browser page, as fast as possible",
    )
    parser.add_argument(
        "--realtime-rate",
        type=not_negative,
        metavar="R",
        help=(
            "simulation speed relative to the wall clock, 0 = unlimited "
            "(default: the scenario's, or else 1 with the page and 0 "
            "headless)"
        ),
    )
    add_robot_arguments(parser)
    parser.add_argument(
        "--output",
        type=Path,
        metavar="DIR",
        help="folder for metrics.json and trajectory.npz",
    )
    parser.add_argument(
        "--save-html",
        type=Path,
        metavar="FILE",
        help="write the page with its replay as one static file",
    )
    parser.add_argument(
        "--scenario-text",
        default="",
        metavar="YAML",
        help=(
            "YAML of settings that override the scenario, e.g. "
            "'{time_limit: 5}'"
        ),
    )
    parser.add_argument(
        "--graphviz",
        type=Path,
        metavar="FILE",
        help="write the diagram as a Graphviz .dot file",
    )
    add_json_argument(parser)
    add_record_argument(parser)
    add_accept_argument(parser)
    add_viewer_argument(parser)
    add_page_arguments(parser)


def run(arguments: argparse.Namespace) -> int:
    """Runs the scenario; returns 0 if the targets were reached, else 1.

    It returns `INCOMPLETE` if the targets were reached, but a file is
    incomplete.
    """
    console = open_console(stderr=True)
    _check_outputs(arguments)
    check_accepted(arguments)
    if arguments.save_html or not arguments.headless:
        check_free(arguments.host, arguments.port)
    waits_for_viewer = is_waited_for(arguments)
    scenario = load_given(
        arguments.scenario,
        arguments.scenario_text,
        console,
        arguments.save_scenario,
        arguments.hardware,
    )
    if arguments.hardware and arguments.realtime_rate is not None:
        raise RemoSplatError(
            "--realtime-rate: a real robot moves in real time; leave this "
            "flag out"
        )
    prepare_robot(arguments, scenario, console)
    page = None
    if arguments.save_html or not arguments.headless:
        page = open_page(arguments)
        page.show(preparing("reading the scenario"))
    preparation = _Preparation(page, arguments.headless, console)
    with (
        Progress(console) as progress,
        compiling_shown(progress, scenario, preparation.tell),
    ):
        preparation.tell("loading the map and the robot")
        world = load_world(scenario)
        if page is not None:
            draw_first(page, world.robot, world.q0, world.splat_W)
        places = target_places(scenario, world)
        knowledge = examine_map(scenario, world, places)
        admission = admit(
            knowledge,
            arguments,
            scenario.source,
            start_gates(scenario, world),
        )
        compile_kernels(scenario, world, plans=bool(arguments.hardware))
    if page is not None:
        show_verdict(page, knowledge)
        show_warnings(page, admission.passage.warnings)
    mcap = opened_recorder(arguments, scenario, world.robot)
    application = build(
        scenario, world, page, hardware=arguments.hardware, mcap=mcap
    )
    if arguments.graphviz:
        with atomic_write(arguments.graphviz) as file:
            file.write(application.diagram.GetGraphvizString(max_depth=1))
    admission.announce(console)
    preparation.print_address()
    if page is not None and application.supervisor is None:
        page.show(unsupervised())
    # At the start and after every stop, a real robot does not move until an
    # operator releases it.
    waits = arguments.hardware or (
        not arguments.headless and is_held(arguments.hold)
    )
    start = 0.0
    try:
        if page is not None:
            if waits_for_viewer:
                show_start(application)
                goal = goal_in_words(application, knowledge)
                wait_for_start(page, f"{scenario.name}: {goal}", console)
            start = time.time() if arguments.hardware else 0.0
            page.start_recording(start)
        result, loop = drive(
            application,
            console,
            rate=_rate(arguments, scenario),
            patience=math.inf if waits else 0.0,
            page=page,
        )
    finally:
        if application.log is not None:
            application.log.close()
    if page is not None:
        # The page shows the result first, since sending the recording takes a
        # while.
        page.end(state_at_end(result))
        ticks = result.trajectory
        if len(ticks.time):
            end = float(ticks.time[-1])
            draw_end(
                application.diagram, result.motion_status, ticks.q[-1], end
            )
    facts = facts_of(result, loop)
    document = run_document(result, application, loop, admission.document())
    if arguments.json:
        print_json(document)
    else:
        print_summary(result, facts, open_console())
    is_recorded = log_is_whole(application, console)
    if arguments.output:
        save_result(result, document, arguments.output)
    if page is not None:
        page.finish_recording()
        state = state_at_end(result)
        account = account_of(result, scenario, state, facts, start)
        page.set_account(account)
        if arguments.save_html:
            page.save_html(arguments.save_html)
    if page is not None and not arguments.headless:
        hold(arguments.hold, page, console)
    if result.outcome == INTERRUPTED:
        return 130
    if result.outcome != REACHED:
        return 1
    return 0 if is_recorded else INCOMPLETE


class _Preparation:
    """Shows the preparation of a run on its page; prints the page's address."""

    def __init__(
        self, page: MeshcatPage | None, headless: bool, console: Console
    ):
        self._page, self._console = page, console
        self._is_said = page is None or headless

    def print_address(self) -> None:
        """Prints the page's address once."""
        if self._page is not None and not self._is_said:
            self._console.print(f"watch at [bold]{self._page.url}[/bold]")
        self._is_said = True

    def tell(self, text: str) -> None:
        """Prints the current step."""
        self.print_address()
        # Meshcat must be called from one thread only, but threads that compile
        # kernels also report progress here.
        if self._page is not None and current_thread() is main_thread():
            self._page.show(preparing(text))


def _rate(arguments: argparse.Namespace, scenario: Scenario) -> float | None:
    """Returns the speed relative to the wall clock; None for a real robot."""
    if arguments.hardware:
        return None
    if arguments.realtime_rate is not None:
        return arguments.realtime_rate
    if scenario.simulator is not None:
        return scenario.simulator.target_realtime_rate
    return 0.0 if arguments.headless else 1.0


def _check_outputs(arguments: argparse.Namespace) -> None:
    """Checks, before the run, that the output files can be written."""
    paths = [arguments.graphviz, arguments.save_html, arguments.save_scenario]
    if arguments.output:
        paths += [arguments.output / name for name in (METRICS, TRAJECTORY)]
    for path in filter(None, paths):
        check_writable(path)


def state_at_end(result: RunResult) -> PageState:
    """Returns the text that the page shows after a run.

    Args:
        result: Result of the run.
    """
    if result.outcome == REACHED:
        _, mark, more = result.motion_status.text.partition(";")
        text = f"in {result.metrics.duration:.1f} s{mark}{more}"
        return ended(text, reached=True)
    return ended(result.motion_status.text, reached=False)
