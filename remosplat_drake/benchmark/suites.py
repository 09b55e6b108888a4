"""Loads the scenes of benchmarks, as small picklable descriptions."""

import dataclasses as dc
from collections.abc import Sequence
from itertools import chain, groupby, zip_longest
from pathlib import Path

from remosplat_drake.base import resources
from remosplat_drake.base.errors import FileError, RemoSplatError, unknown_name
from remosplat_drake.benchmark import motion_bench_maker
from remosplat_drake.benchmark.drawing import Drawing, no_drawing
from remosplat_drake.benchmark.motion_bench_maker import motion_problems
from remosplat_drake.benchmark.moving_case import MOVING, MovingCase
from remosplat_drake.benchmark.reaching_task import BenchmarkCase
from remosplat_drake.benchmark.robot_suite import SUITE as ROBOTS
from remosplat_drake.benchmark.robot_suite import robot_cases
from remosplat_drake.benchmark.scan_suite import scan_cases
from remosplat_drake.benchmark.scene_case import SceneCase
from remosplat_drake.generation.feasibility import FeasibilityFilter
from remosplat_drake.generation.feasible_scenes import feasible_seeds
from remosplat_drake.generation.scene_generators import (
    FAMILIES,
    GENERATOR_VERSION,
    PUBLISHED_FAMILIES,
    generate,
)
from remosplat_drake.robot.robot_description import shipped_robots

PUBLISHED_FOLDERS = {"table": "table_new", "bookshelf": "bookshelf_cage"}
"""Folders of the published scenes, by family."""


METHODS = "paper,sdf-guided,ellipsoid-guided"
"""Methods that are compared by default: the paper's methods, and guided control
with true distances and with splats."""

ROBOTS_METHOD = "robots-guided"
"""Default method for random targets of any robot."""

MOVING_METHODS = "moving,drake-ik:movers-unknown"
"""Default methods in scenes with movers: this package's method, and Drake's
method, which ignores movers."""

MBM, MBM_GRASP, MBM_CARRY = "mbm", "mbm-grasp", "mbm-carry"
"""Kinds of suites of MotionBenchMaker's problems. In the first kind, the scene
does not contain the object that the hand encloses at the goal. In the second
kind, the scene contains this object, and only the hand may touch it. In the
third kind, the robot also carries the object to the start's pose."""

_MBM = (MBM, MBM_GRASP, MBM_CARRY)


def default_methods(name: str) -> str:
    """Returns the methods that a suite compares by default.

    Args:
        name: Name of the suite.
    """
    if name.partition(":")[0] == ROBOTS:
        return ROBOTS_METHOD
    return MOVING_METHODS if name.partition(":")[0] == MOVING else METHODS


def suite_robots(name: str, robot: str = "") -> list[str]:
    """Returns the names of the robots that a suite drives.

    Args:
        name: Name of the suite.
        robot: Names or files of robots, joined by commas; empty for the suite's
            default robots. An empty name in the result means that each method
            uses its own robot.

    Raises:
        RemoSplatError: The suite permits only one robot.
    """
    kind = name.partition(":")[0]
    if robot and (kind == ROBOTS or "," not in robot):
        return robot.split(",")
    if robot:
        raise RemoSplatError(
            f"--robot: --suite {name} permits only one robot, got {robot}"
        )
    if kind == ROBOTS:
        return shipped_robots()
    is_mbm = kind in _MBM
    return [motion_bench_maker.ROBOT if is_mbm else ""]


def interleave_families(
    cases: Sequence[BenchmarkCase],
) -> list[BenchmarkCase]:
    """Orders cases: first the first case of each family, then the second, etc.

    With this order, an interrupted run has results for equally many scenes of
    each family.
    """
    by_family = [
        list(group) for _, group in groupby(cases, key=lambda c: c.family)
    ]
    turns = chain.from_iterable(zip_longest(*by_family))
    return [case for case in turns if case is not None]


def load_cases(
    name: str,
    count: int,
    splat_folders: tuple[Path, ...] = (),
    trained_only: bool = False,
    robot: str = "",
    jobs: int = 0,
    drawing: Drawing = no_drawing,
) -> Sequence[BenchmarkCase]:
    """Returns the cases of any suite.

    Args:
        name: "robots" or "robots:SCENE,..." for random targets (`robot_cases`),
            "scan:NAME" for scanned scenes (`scan_cases`), "mbm:DIR",
            "mbm-grasp:DIR" or "mbm-carry:DIR" for MotionBenchMaker's problems
            (`motion_problems`), or a name that `load_suite` takes. "moving" and
            "moving:NAME" add movers to the generated scenes, or to the scenes
            of a name for `load_suite`.
        count: Number of scenes of each family. For scanned scenes it is
            ignored, and all are used.
        splat_folders: Folders of trained splats. Scanned scenes ignore them,
            since their suite names the splats.
        trained_only: Whether scenes without a trained splat are left out.
            MotionBenchMaker's problems ignore it.
        robot: Name or file of the robot. If it is empty, each method uses its
            own robot.
        jobs: Number of processes that draw scenes; 0 uses this process.
        drawing: Function that is called with the number of drawn scenes.

    Raises:
        RemoSplatError: The suite does not exist or cannot be used.
    """
    kind, _, place = name.partition(":")
    if kind == ROBOTS:
        return robot_cases([robot], count, place, jobs, drawing)
    if kind == "scan":
        return scan_cases(place)
    if kind == MOVING:
        cases = load_suite(
            place or "generated",
            count,
            splat_folders,
            trained_only,
            jobs,
            drawing,
        )
        return [MovingCase.of(case) for case in cases]
    if kind in _MBM and place:
        robot = robot or motion_bench_maker.ROBOT
        problems = motion_problems(Path(place), count, robot)
        folders = tuple(str(folder) for folder in splat_folders)
        if kind != MBM:
            carried = kind == MBM_CARRY
            problems = [problem.grasping(carried) for problem in problems]
        return [dc.replace(p, splat_folders=folders) for p in problems]
    return load_suite(name, count, splat_folders, trained_only, jobs, drawing)


def load_suite(
    name: str,
    count: int,
    splat_folders: tuple[Path, ...] = (),
    trained_only: bool = False,
    jobs: int = 0,
    drawing: Drawing = no_drawing,
) -> list[SceneCase]:
    """Returns the first scenes of each family of a suite.

    Args:
        name: "generated" for the published families, "generated:FAMILY,..." for
            chosen families, or "published:DIR" with the folders of
            `PUBLISHED_FOLDERS` in DIR.
        count: Number of scenes of each family.
        splat_folders: Folders in which trained splats are searched.
        trained_only: Whether scenes without a trained splat are left out.
        jobs: Number of processes that draw scenes; 0 uses this process.
        drawing: Function that is called with the number of drawn scenes.

    Raises:
        RemoSplatError: The suite does not exist, or it has no scenes.
    """
    kind, _, folder = name.partition(":")
    if kind == "published" and folder:
        cases = _published(Path(folder))
    elif kind == "generated":
        families = folder.split(",") if folder else PUBLISHED_FAMILIES
        cases = _generated(count, families, jobs, drawing)
    else:
        raise RemoSplatError(
            f"--suite: unknown suite {name!r}; valid: generated,"
            " generated:FAMILY,..., published:DIR, moving[:SUITE], mbm:DIR,"
            " mbm-grasp:DIR, mbm-carry:DIR, scan:NAME[:DATA],"
            " robots[:SCENE,...]"
        )
    folders = tuple(str(folder) for folder in splat_folders)
    chosen = []
    for family in FAMILIES:
        found = [
            dc.replace(case, splat_folders=folders)
            for case in cases
            if case.family == family
        ]
        if trained_only:
            found = [c for c in found if c.trained_splat(c.truth())]
        chosen += found[:count]
    if not chosen:
        raise RemoSplatError(f"--suite: {name} has no scenes to run")
    return chosen


def _published(folder: Path) -> list[SceneCase]:
    cases = []
    for family, stem in PUBLISHED_FOLDERS.items():
        files = sorted((folder / stem).glob(f"{stem}_*.json"))
        if not files:
            raise FileError(folder / stem, f"holds no {stem}_*.json")
        cases += [
            SceneCase(f.stem, family, "published scenes", str(f)) for f in files
        ]
    return cases


def _generated(
    count: int, families: Sequence[str], jobs: int, drawing: Drawing
) -> list[SceneCase]:
    for family in families:
        if family not in FAMILIES:
            problem = unknown_name("scene family", family, FAMILIES)
            raise RemoSplatError(f"--suite: {problem}")
    criteria = FeasibilityFilter()
    suite = f"generated scenes v{GENERATOR_VERSION}, {criteria.name}"
    return [
        SceneCase(generate(family, seed).name, family, suite, seed=seed)
        for family in families
        for seed in feasible_seeds(
            family,
            count,
            criteria,
            resources.cache_dir(),
            jobs,
            lambda found, family=family: drawing(
                f"scenes, {family}", found, count
            ),
        )
    ]
