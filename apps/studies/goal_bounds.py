"""Counts the scenes in which the goal can be held: a bound for every method.

A controller that keeps all spheres a stopping distance away from the scene
cannot succeed if no configuration at the goal does. `goal_configuration`
searches for one; a failed search is not a proof, so the true bound may be
slightly higher.
"""

import argparse
import dataclasses as dc
import hashlib
import json
import os
import sys
from collections import defaultdict
from collections.abc import Callable, Iterable, Sequence
from contextlib import closing
from functools import cache
from pathlib import Path

from rich.console import Console

from apps.studies.command_line import add_output_flag, check_least, study_main
from remosplat_drake.base.atomic_file import check_writable, write_atomically
from remosplat_drake.base.errors import FileError
from remosplat_drake.base.pool import Job, run_jobs
from remosplat_drake.base.strict_json import parse_json
from remosplat_drake.base.table import Table
from remosplat_drake.benchmark.cells import format_rate
from remosplat_drake.benchmark.reaching_task import BenchmarkCase
from remosplat_drake.benchmark.suites import load_cases
from remosplat_drake.generation.feasibility import (
    FILTER_VERSION,
    FeasibilityFilter,
    goal_configuration,
    hand_fits,
)
from remosplat_drake.generation.feasible_scenes import FLOOR_HEIGHT, ROBOT
from remosplat_drake.robot.robot_model import RobotModel, load_robot
from remosplat_drake.scene.primitive_scene import PrimitiveScene

GOALS = "goals.jsonl"
"""Name of the result file in the output folder."""

SPHERE_SETS = ("paper", "covering")
CLEARANCES = (0.021, 0.010)
"""Required clearances at the goal, in descending order [m]."""

_MARGIN = 0.95
"""Configurations must be within this fraction of the goal's tolerances. A
controller stops once it is within the tolerances, and some goals are feasible
only at the limit of the tolerances."""

_SAVE_EVERY = 20  # Verdicts.


@dc.dataclass(frozen=True)
class GoalQuestion:
    """A scene and a sphere set to judge; small enough to be sent to a worker.

    Attributes:
        case: Scene whose goal is searched.
        spheres: Sphere set of the robot.
    """

    case: BenchmarkCase
    spheres: str

    def key(self) -> str:
        """Returns a digest of everything that the answer depends on."""
        task = self.case.task()
        robot = _robot(self.spheres)
        parts = (
            FILTER_VERSION,
            FeasibilityFilter(),
            _MARGIN,
            CLEARANCES,
            robot.spheres.p_LS.tobytes(),
            robot.spheres.radius.tobytes(),
            task.content_hash,
            task.X_WE_target.GetAsMatrix34().tolist(),
            task.X_WB_start,
        )
        return hashlib.sha256(repr(parts).encode()).hexdigest()[:20]


@dc.dataclass(frozen=True)
class GoalVerdict:
    """The largest clearance at which a goal can be held.

    Attributes:
        key: Key of the question.
        suite: Name of the suite.
        family: Family of the scene.
        scene: Name of the scene.
        spheres: Sphere set of the robot.
        held: Largest of `CLEARANCES` at which a configuration at the goal was
            found [m]; None if there is none.
        error: Error text of a failure; empty otherwise.
    """

    key: str
    suite: str
    family: str
    scene: str
    spheres: str
    held: float | None = None
    error: str = ""


def largest_held(
    robot: RobotModel,
    scene: PrimitiveScene,
    clearances: Sequence[float] = CLEARANCES,
) -> float | None:
    """Returns the largest clearance with which the goal can be held.

    Args:
        robot: Model of the robot, with the spheres in question.
        scene: Scene with a target.
        clearances: Clearances to try, in descending order [m].

    Returns:
        The clearance [m]; None if the goal cannot be held with any.
    """
    for clearance in clearances:
        criteria = FeasibilityFilter(robot.spheres.name, clearance)
        if not hand_fits(robot, scene, criteria):
            continue
        q = goal_configuration(robot, scene, criteria, _MARGIN)
        if q is not None:
            return clearance
    return None


def judge(question: GoalQuestion) -> GoalVerdict:
    """Computes one verdict; equal questions give equal verdicts."""
    solids = question.case.task().solids
    assert solids is not None
    held = largest_held(_robot(question.spheres), solids)
    return dc.replace(_head(question), held=held)


def goal_bounds(
    cases: Sequence[BenchmarkCase],
    path: Path,
    jobs: int,
    on_verdict: Callable[[int, int], None] = lambda done, count: None,
) -> list[GoalVerdict]:
    """Returns the verdicts of all scenes for all sphere sets.

    Verdicts in the file are not searched again.

    Args:
        cases: Scenes to judge; scanned ones, which have no solids, are left
            out.
        path: Path of the file that keeps verdicts, even after an interruption.
        jobs: Number of worker processes; 0 runs everything in this one.
        on_verdict: Called with the number of finished verdicts and of all
            verdicts.

    Raises:
        FileError: The file cannot be read or written.
    """
    known = {verdict.key: verdict for verdict in read_verdicts(path)}
    questions = {
        question.key(): question
        for case in cases
        if case.task().solids is not None
        for question in (GoalQuestion(case, s) for s in SPHERE_SETS)
    }
    missing = [q for key, q in questions.items() if key not in known]
    searches = (Job(question, judge, _failed) for question in missing)
    try:
        with closing(run_jobs(searches, jobs)) as verdicts:
            for done, verdict in enumerate(verdicts, 1):
                known[verdict.key] = verdict
                on_verdict(done, len(missing))
                if done % _SAVE_EVERY == 0:
                    _write(path, known.values())
    finally:
        _write(path, known.values())
    return [known[key] for key in questions if key in known]


def goal_table(verdicts: Iterable[GoalVerdict]) -> Table | None:
    """Makes the table of goals that can be held, by suite and family.

    Returns:
        The table; None without verdicts.
    """
    groups = defaultdict(list)
    for verdict in verdicts:
        if not verdict.error:
            groups[verdict.suite, verdict.spheres].append(verdict)
    families = sorted({v.family for group in groups.values() for v in group})
    rows = [
        (suite or "–", spheres, f"{1e3 * d:g}", *_rates(group, d, families))
        for (suite, spheres), group in sorted(groups.items())
        for d in CLEARANCES
    ]
    if not rows:
        return None
    return Table(
        "the goal can be held",
        (
            "suite",
            "spheres",
            "clearance [mm]",
            "all [%]",
            *(f"{family} [%]" for family in families),
        ),
        tuple(rows),
        "Scenes in which a search with random restarts over base pose and arm"
        " finds a configuration at the goal with all spheres at that"
        " clearance: about as many as a controller with that stopping"
        " distance can solve at all. A failed search is no proof.",
    )


def _rates(
    group: Sequence[GoalVerdict], clearance: float, families: Sequence[str]
) -> list[str]:
    def rate(chosen: list[GoalVerdict]) -> str:
        held = sum(v.held is not None and v.held >= clearance for v in chosen)
        return format_rate(held, len(chosen))

    of_family = [[v for v in group if v.family == f] for f in families]
    return [rate(list(group)), *(rate(chosen) for chosen in of_family)]


@cache
def _robot(spheres: str) -> RobotModel:
    return load_robot(ROBOT, spheres, FLOOR_HEIGHT)


def _head(question: GoalQuestion) -> GoalVerdict:
    case = question.case
    return GoalVerdict(
        question.key(), case.suite, case.family, case.name, question.spheres
    )


def _failed(question: GoalQuestion, error: str) -> GoalVerdict:
    return dc.replace(_head(question), error=error)


def read_verdicts(path: Path) -> list[GoalVerdict]:
    """Reads the verdicts in a file; none without a file.

    Raises:
        FileError: The file exists but does not hold verdicts.
    """
    try:
        lines = path.read_text().splitlines()
        return [GoalVerdict(**parse_json(line, path)) for line in lines]
    except FileNotFoundError:
        return []
    except (OSError, ValueError, TypeError) as error:
        raise FileError(
            path, f"does not contain verdicts about goals ({error})"
        ) from error


def _write(path: Path, verdicts: Iterable[GoalVerdict]) -> None:
    """Writes verdicts without failures, which are tried again next time."""
    lines = [json.dumps(dc.asdict(v)) + "\n" for v in verdicts if not v.error]
    write_atomically(path, "".join(lines))


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declares the study's flags."""
    parser.add_argument(
        "--scenes",
        type=int,
        default=20,
        metavar="N",
        help="number of scenes of each family (%(default)s)",
    )
    parser.add_argument(
        "--suite",
        default="generated",
        metavar="generated|published:DIR|scan:NAME",
        help="a suite of `remosplat benchmark` (%(default)s)",
    )
    add_output_flag(
        parser,
        "benchmark",
        f"folder of {GOALS}; existing verdicts are not searched again",
    )
    parser.add_argument(
        "--jobs",
        type=int,
        default=len(os.sched_getaffinity(0)),
        metavar="J",
        help="worker processes; 0: none (default: the number of cores)",
    )


def run(arguments: argparse.Namespace) -> int:
    """Searches the missing verdicts and prints the table."""
    check_least("goal_bounds", arguments, scenes=1, jobs=0)
    path = arguments.output / GOALS
    check_writable(path)
    console = Console(stderr=True)
    with console.status("choosing scenes") as status:
        cases = load_cases(arguments.suite, arguments.scenes)
        goal_bounds(
            cases,
            path,
            arguments.jobs,
            lambda done, count: status.update(
                f"searching goals: {done} of {count}"
            ),
        )
    table = goal_table(read_verdicts(path))
    if table is not None:
        print(table.to_markdown())
    console.print(f"{GOALS} is in {arguments.output}")
    return 0


def main(argv: Sequence[str] | None = None) -> int:
    """Runs the study from its command line and returns its exit code."""
    return study_main("goal_bounds", __doc__, add_arguments, run, argv)


if __name__ == "__main__":
    sys.exit(main())
