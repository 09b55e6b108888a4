"""Picks and places random objects, and counts the causes of failures.

Each problem is a line of `problems.jsonl` in the output's folder; problems that
have one are not run again. `--library` takes the folder
`pybullet_data/random_urdfs` of PyBullet's unpacked wheel.
"""

import argparse
import sys
from collections import Counter
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from pydrake.math import RigidTransform
from rich.console import Console
from rich.table import Table

from apps.studies.command_line import (
    add_trial_flags,
    check_least,
    study_main,
)
from apps.studies.kept_trials import run_missing
from apps.studies.pick_and_place.problem_run import COMPLETE, Outcome
from apps.studies.pick_and_place.trial import (
    Trial,
    failed,
    restored,
    run_trial,
)
from remosplat_drake.base.pool import Job
from remosplat_drake.generation.object_library import (
    read_mesh_library,
    standing,
)
from remosplat_drake.generation.pick_and_place import FAMILIES
from remosplat_drake.grasping.grasps import plan_grasps
from remosplat_drake.grasping.gripper import ParallelGripper
from remosplat_drake.grasping.surface import surface_of_solid
from remosplat_drake.robot.robot_model import load_robot
from remosplat_drake.scene.objects.convex_hull import ConvexHull

PROBLEMS = "problems.jsonl"
"""Name of the file with a line for each problem."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declares the study's flags."""
    parser.add_argument(
        "--families",
        nargs="+",
        choices=list(FAMILIES),
        default=list(FAMILIES),
        help="families of problems (all)",
    )
    parser.add_argument(
        "--library",
        type=Path,
        metavar="DIR",
        help="folder of folders with a URDF file and a mesh each, for half of"
        " the objects",
    )
    parser.add_argument(
        "--fit",
        action="store_true",
        help="only count the meshes of --library that fit the Panda's hand",
    )
    add_trial_flags(parser, "pick_and_place", 5, "seeds of each family")


def run(arguments: argparse.Namespace) -> int:
    """Runs the problems that have no line yet, and prints the table."""
    check_least("pick_and_place", arguments, count=1, first=0, jobs=0)
    console, library = Console(), arguments.library
    if library and arguments.fit:
        meshes = read_mesh_library(library)
        for name, count in fits(meshes.hulls).items():
            console.print(f"{name}: {count}")
        console.print(f"unreadable: {len(meshes.refused)}")
        return 0
    seeds = range(arguments.first, arguments.first + arguments.count)
    trials = [
        Trial(f, seed, library) for f in arguments.families for seed in seeds
    ]
    outcomes = run_missing(
        [Job(trial, run_trial, failed) for trial in trials],
        arguments.output / PROBLEMS,
        restored,
        arguments.jobs,
        "picking and placing",
    )
    console.print(table_of(outcomes))
    drawn = sum(outcome.draws for outcome in outcomes)
    console.print(f"{len(outcomes)} problems, of {drawn} that were drawn")
    return 0


def fits(hulls: dict[str, np.ndarray]) -> Counter[str]:
    """Counts the hulls that the Panda's hand can grasp while they stand.

    Args:
        hulls: Vertices by name, shape (v, 3) each [m].
    """
    gripper = ParallelGripper.of(load_robot("panda"))
    counts: Counter[str] = Counter()
    for vertices in hulls.values():
        stood = standing(vertices)
        if stood is None:
            counts["does not stand"] += 1
            continue
        rng = np.random.default_rng(0)
        surface = surface_of_solid(ConvexHull(RigidTransform(), stood))
        floor = np.stack(np.meshgrid(*[np.linspace(-0.2, 0.2, 20)] * 2), -1)
        z = np.full((400, 1), stood[:, 2].min())
        around = np.hstack([floor.reshape(-1, 2), z])
        found = plan_grasps(surface, gripper, around=around, most=25, rng=rng)
        counts["fits" if found else "does not fit the hand"] += 1
    return counts


def table_of(outcomes: Sequence[Outcome]) -> Table:
    """Makes a table of the causes by family.

    Args:
        outcomes: The outcomes.
    """
    table = Table("family", "cause", "problems", "share [%]")
    families = Counter(each.key.partition("-")[0] for each in outcomes)
    for family, total in families.items():
        causes = Counter(
            each.cause
            for each in outcomes
            if each.key.partition("-")[0] == family
        )
        order = sorted(causes, key=lambda x: (x != COMPLETE, -causes[x]))
        for cause in order:
            count = causes[cause]
            share = f"{100 * count / total:.0f}"
            table.add_row(family, cause, f"{count} of {total}", share)
    return table


def main(argv: Sequence[str] | None = None) -> int:
    """Runs the study from its command line."""
    return study_main("pick_and_place", __doc__, add_arguments, run, argv)


if __name__ == "__main__":
    sys.exit(main())
