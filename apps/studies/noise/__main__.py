"""Effects of floaters on distance methods: the paper's experiment 3."""

import argparse
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path

from rich.console import Console
from rich.table import Table

from apps.studies.command_line import add_output_flag, check_least, study_main
from apps.studies.noise import experiment, report
from remosplat_drake.app.compiling import compiling_shown
from remosplat_drake.app.scene_config import SceneConfig
from remosplat_drake.base.atomic_file import atomic_write
from remosplat_drake.base.progress import Progress, Stage
from remosplat_drake.robot.robot_model import RobotModel, load_robot
from remosplat_drake.visualization.depth_views import save_picture

QUICK_STATES, QUICK_STARTS = 20, 1


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declares the study's flags."""
    parser.add_argument(
        "--scene",
        nargs=2,
        action="append",
        default=[],
        metavar=("SPLAT.ply", "TRUTH.json"),
        help="a splat and its true geometry; may be repeated (default: the"
        " shipped scenes, unchanged and with floaters added)",
    )
    parser.add_argument(
        "--floaters",
        type=int,
        default=1000,
        help="number of floaters that are added to the shipped scenes (1000)",
    )
    parser.add_argument(
        "--states",
        type=int,
        default=300,
        help="number of robot states at which distances are compared (300)",
    )
    parser.add_argument(
        "--starts",
        type=int,
        default=5,
        help="number of runs of every method in every scene (5); 0 for none",
    )
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument(
        "--quick",
        action="store_true",
        help=f"{QUICK_STATES} states and {QUICK_STARTS} start, for a quick try",
    )
    add_output_flag(
        parser,
        "noise",
        "folder for table, picture and results; an existing experiment is"
        " continued",
    )


def run(arguments: argparse.Namespace) -> int:
    """Measures missing results, and writes tables and a picture."""
    if arguments.quick:
        arguments.states, arguments.starts = QUICK_STATES, QUICK_STARTS
    _check(arguments)
    console = Console(stderr=True)
    robot = load_robot("frankie", floor_height=SceneConfig().floor_height)
    results = report.Results(arguments.output / "results.json")
    with Progress(console) as progress, compiling_shown(progress):
        for scene in _scenes(arguments):
            _measure(robot, scene, results, arguments, progress)
    _write(results, arguments.output)
    for title, headings, rows in _tables(results):
        table = Table(*headings[:2], title=title)
        for heading in headings[2:]:
            table.add_column(heading, justify="right")
        for row in rows:
            table.add_row(*row)
        console.print(table)
    console.print(f"noise.md and noise.png are in {arguments.output}")
    return 0


def _check(arguments: argparse.Namespace) -> None:
    check_least("noise", arguments, states=1, starts=0, floaters=0)


def _scenes(
    arguments: argparse.Namespace,
) -> Iterator[experiment.NoiseScene]:
    if not arguments.scene:
        yield from experiment.demo_scenes(arguments.floaters, arguments.seed)
    for splat, truth in arguments.scene:
        yield experiment.scene_from_files(splat, truth)


def _measure(
    robot: RobotModel,
    scene: experiment.NoiseScene,
    results: report.Results,
    arguments: argparse.Namespace,
    progress: Progress,
) -> None:
    """Measures all methods in one scene, except for existing results."""
    starts = experiment.random_starts(
        robot, scene.truth, arguments.starts, arguments.seed
    )
    steps = len(experiment.METHODS) * (1 + len(starts))
    stage = Stage(scene.name, total=steps)
    progress.show(stage)
    for method in experiment.METHODS:
        field = experiment.method_field(scene, method)
        name = scene.name, method
        where = f"{field.revision} seed {arguments.seed}"
        key = f"{where} states {arguments.states}"
        accuracy = results.kept_accuracy(key)
        if accuracy is None:
            accuracy = experiment.measure_accuracy(
                robot, scene, field, arguments.states, arguments.seed
            )
            results.keep(key, accuracy)
        results.accuracy[name] = accuracy
        stage.done += 1
        for i, q0 in enumerate(starts):
            key = f"{where} start {i}"
            trial = results.kept_trial(key)
            if trial is None:
                trial = experiment.run_trial(robot, scene, field, q0)
                results.keep(key, trial)
            results.trials.setdefault(name, []).append(trial)
            stage.done += 1


def _tables(results: report.Results):
    return (
        (
            report.ACCURACY_TITLE,
            report.ACCURACY_HEADINGS,
            results.accuracy_rows(),
        ),
        (report.TRIAL_TITLE, report.TRIAL_HEADINGS, results.trial_rows()),
    )


def _write(results: report.Results, folder: Path) -> None:
    with atomic_write(folder / "noise.md") as file:
        for title, headings, rows in _tables(results):
            file.write(f"{title}\n\n")
            file.write(report.markdown(headings, rows) + "\n")
    save_picture(report.draw(results), folder / "noise.png")


def main(argv: Sequence[str] | None = None) -> int:
    """Runs the study from its command line and returns its exit code."""
    return study_main("noise", __doc__, add_arguments, run, argv)


if __name__ == "__main__":
    sys.exit(main())
