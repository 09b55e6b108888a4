"""The paper's figure 5: an operator pushes the target into obstacles.

A scripted operator pushes the target through the table and into the wall, while
the map is built from frames of the wrist camera.
"""

import argparse
import json
import shutil
import sys
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from rich.console import Console
from rich.table import Table

from apps.studies.command_line import add_output_flag, study_main
from remosplat_drake.app.compiling import compiling_shown
from remosplat_drake.app.diagram import build
from remosplat_drake.app.recorded_run import RecordedRun, load_recorded_run
from remosplat_drake.app.run_result import INTERRUPTED
from remosplat_drake.app.scenario import Scenario, load_scenario
from remosplat_drake.app.scenario_text import scenario_text
from remosplat_drake.app.teleop_session import (
    check_mappable,
    holds_session,
    open_teleoperation,
)
from remosplat_drake.app.warm_up import compile_kernels
from remosplat_drake.app.world import World, load_world, true_scenes
from remosplat_drake.base import resources
from remosplat_drake.base.atomic_file import atomic_write, write_atomically
from remosplat_drake.base.errors import FieldError
from remosplat_drake.base.progress import Progress
from remosplat_drake.commands.driving import drive
from remosplat_drake.mapping.store.session import SCENARIO_FILE
from remosplat_drake.recording.operator_figure import (
    draw_operator_figure,
    save_figure,
)
from remosplat_drake.recording.operator_trace import OperatorTrace
from remosplat_drake.teleop.trajectory_file import load_operator_steps

DEFAULT_SCENARIO = "StudioLive"
"""Default scenario, in which unknown space is an obstacle; the paper treats it
as free."""

SCRIPT = resources.scenarios_dir() / "operators" / "push.yaml"

LATENCY = 3.0
"""Time from a request to the effect of its map, in every run [s]."""

_AFTERWARDS = 1.0
"""Time for which the run continues after the last step [s]."""

_PATIENCE = 5.0
"""Time after which a stopped robot ends the run [s]."""

_SESSION, _SCRIPT = "session", "operator.yaml"
_FIGURE, _METRICS = "figure.png", "metrics.json"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declares the study's flags."""
    parser.add_argument(
        "scenario",
        nargs="?",
        default=DEFAULT_SCENARIO,
        help="NAME, FILE or FILE:NAME, with its true geometry"
        " (default: %(default)s)",
    )
    parser.add_argument(
        "--script",
        type=Path,
        default=SCRIPT,
        metavar="FILE",
        help="script of the operator (default: the shipped push.yaml)",
    )
    add_output_flag(
        parser,
        "push",
        f"folder for {_FIGURE}, {_METRICS} and the session; a complete"
        " session is not run again",
    )


def run(arguments: argparse.Namespace) -> int:
    """Runs, draws and measures; returns 1 if the true scene was touched."""
    console = Console(stderr=True)
    scenario, world = _load(arguments)
    session = arguments.output / _SESSION
    script, followed = arguments.script.read_text(), arguments.output / _SCRIPT
    recorded = None
    if followed.is_file() and followed.read_text() == script:
        recorded = _complete_run(session, scenario)
    if recorded is None:
        write_atomically(followed, script)
        recorded = _record(scenario, world, session, console)
    with Progress(console) as progress:
        total = len(recorded.log)
        trace = recorded.trace(
            lambda done: progress.report("measuring", done, total)
        )
    figure = draw_operator_figure(
        trace,
        stopping=scenario.controller.collision.stopping,
        events=recorded.events,
    )
    save_figure(figure, arguments.output / _FIGURE)
    metrics = measure(recorded, trace)
    with atomic_write(arguments.output / _METRICS) as file:
        json.dump(metrics, file, indent=1)
        file.write("\n")
    console.print(table(metrics))
    console.print(f"{_FIGURE} and {_METRICS} are in {arguments.output}")
    return 0 if metrics["true_clearance_min"] >= 0 else 1


def _load(arguments: argparse.Namespace) -> tuple[Scenario, World]:
    """Loads the scenario, operated by the script to its end, and its world.

    Raises:
        RemoSplatError: A file is invalid, or the truth is unknown.
    """
    scenario = load_scenario(
        arguments.scenario, f"{{mapping: {{latency: {LATENCY}}}}}"
    )
    if not scenario.scene.truth:
        raise FieldError(
            scenario.source, "scene.truth", "is needed to evaluate the run"
        )
    check_mappable(scenario)
    world = load_world(scenario, blank=True)
    scenes = true_scenes(scenario, world)
    steps = load_operator_steps(arguments.script, scenario.teleop.poses, scenes)
    scenario.teleop.trajectory = str(arguments.script.resolve())
    scenario.time_limit = steps[-1].time + _AFTERWARDS
    return scenario, world


def _complete_run(folder: Path, scenario: Scenario) -> RecordedRun | None:
    """Returns the recorded run if it is complete and has this scenario."""
    if not holds_session(folder):
        return None
    name = scenario.name
    text = (folder / SCENARIO_FILE).read_text()
    if text != scenario_text(scenario, name):
        return None
    recorded = load_recorded_run(folder)
    end = recorded.log.rows["time"][-1] + 2 * scenario.control_period
    return recorded if end >= scenario.time_limit else None


def _record(
    scenario: Scenario, world: World, folder: Path, console: Console
) -> RecordedRun:
    """Runs the script in a new session.

    Raises:
        KeyboardInterrupt: Ctrl-C; the next call begins again.
    """
    if holds_session(folder):
        shutil.rmtree(folder)
    with Progress(console) as progress, compiling_shown(progress):
        compile_kernels(scenario, world)
    teleoperation = open_teleoperation(scenario, world, folder, hardware=False)
    log = None
    try:
        application = build(scenario, world, teleoperation=teleoperation)
        log = application.log
        result, _ = drive(application, console, rate=0.0, patience=_PATIENCE)
    finally:
        if teleoperation.mapping is not None:
            teleoperation.mapping.close()
        if log is not None:
            log.close()
    if result.outcome == INTERRUPTED:
        raise KeyboardInterrupt
    return load_recorded_run(folder)


def measure(recorded: RecordedRun, trace: OperatorTrace) -> dict:
    """Measures a run; distances are in m, times in s.

    None stands for an event that did not occur.
    """
    assert trace.true_clearance is not None
    time, mapped = trace.time, recorded.log.rows["map_version"] > 0
    by_map = trace.clearance[mapped].min(initial=np.inf)
    maps = recorded.session.versions
    return {
        "scenario": recorded.scenario.name,
        "ticks": len(recorded.log),
        "duration": float(time[-1] - time[0]),
        "first_map_at": float(time[mapped][0]) if mapped.any() else None,
        "maps": len(maps),
        "map_seconds_max": max((m.seconds for m in maps.values()), default=0.0),
        "true_clearance_min": float(trace.true_clearance.min()),
        "true_clearance_min_at": float(time[trace.true_clearance.argmin()]),
        "map_clearance_min": float(by_map) if np.isfinite(by_map) else None,
        "stopping_distance": recorded.scenario.controller.collision.stopping,
        "deviation_max": float(trace.deviation.max()),
    }


def table(metrics: dict) -> Table:
    """Makes a table of the metrics, for display."""
    rows = Table("of the run", title="An operator pushes against the scene")
    rows.add_column(metrics["scenario"], justify="right")
    for name, key, scale, unit in (
        ("duration", "duration", 1, "s"),
        ("first map at", "first_map_at", 1, "s"),
        ("smallest true clearance", "true_clearance_min", 1e3, "mm"),
        ("  at", "true_clearance_min_at", 1, "s"),
        ("smallest clearance by a map", "map_clearance_min", 1e3, "mm"),
        ("stopping distance", "stopping_distance", 1e3, "mm"),
        ("largest |v desired - v executed|", "deviation_max", 1, "m/s"),
    ):
        value = metrics[key]
        said = "–" if value is None else f"{scale * value:.2f} {unit}"
        rows.add_row(name, said)
    return rows


def main(argv: Sequence[str] | None = None) -> int:
    """Runs the study from its command line and returns its exit code."""
    return study_main("push", __doc__, add_arguments, run, argv)


if __name__ == "__main__":
    sys.exit(main())
