"""Any robot, at random targets in a generated and in a trained scene.

Targets are poses of goals that the robot can hold: configurations drawn at
random that keep off the scene, off the robot itself and off its joint limits,
with a hand near something. Of several hands each has its target.
"""

import dataclasses as dc
from collections.abc import Sequence
from functools import lru_cache
from pathlib import Path

import numpy as np
from pydrake.math import RigidTransform

from remosplat_drake.base import resources
from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.benchmark.reaching_task import (
    SURFEL,
    TRAINED,
    ReachingTask,
    solid_task,
)
from remosplat_drake.controller.controller_config import (
    ReactiveControllerConfig,
)
from remosplat_drake.controller.planning.free_space import FreeSpace
from remosplat_drake.controller.planning.motion_planner import MotionPlanner
from remosplat_drake.controller.tick.reactive_law import ReactiveLaw
from remosplat_drake.generation.clutter import clutter
from remosplat_drake.generation.primitive_surfels import surfel_splat
from remosplat_drake.oracle.signed_distance import SignedDistanceField
from remosplat_drake.robot.robot_model import RobotModel, load_robot
from remosplat_drake.scene.primitive_scene import PrimitiveScene
from remosplat_drake.scene.rmmi import read_scene
from remosplat_drake.splat.codecs.ply import read_ply
from remosplat_drake.splat.gaussian_splat import GaussianSplat

SUITE = "robots"
"""Kind of the suite, and what its names begin with."""

GENERATED = "clutter"
"""Name of the generated scene, which is made for each robot."""

TRAINED_SCENES = {True: "table", False: "workbench"}
"""Shipped scenes with a trained splat, for robots with a base and without."""

FLOOR_HEIGHT = 0.03
"""Height below which floor links see nothing, as in scenarios [m]."""

_SPARE = 0.009
"""What goals keep beyond the controller's stopping distance: the map errs, and
there must be room to arrive [m]."""

_INSIDE = 0.1
"""What goals keep from joint limits, as a share of the range."""

_NEAR = 0.3
"""How near to the scene the hand is at a goal, at most [m]."""

_AROUND = 1.2
"""How far a mobile robot's goals are from where it starts, each way [m]."""

_DRAWS = 20_000
"""Number of configurations after which a scene counts as hopeless."""

_DISCS = 40_000
"""Number of discs of a generated scene's splat."""


@dc.dataclass(frozen=True)
class RobotCase:
    """One random target for one robot.

    Attributes:
        robot: Name or file of the robot.
        scene: `GENERATED`, or the name of a shipped scene.
        number: Number of the target, from 0 on.
        robot_name: What the robot is called.
    """

    robot: str
    scene: str
    number: int
    robot_name: str

    @property
    def name(self) -> str:
        """Name of the case in tables."""
        return f"{self.robot_name}_{self.scene}_{self.number:04d}"

    @property
    def family(self) -> str:
        """Family of the case: the robot and the scene."""
        return f"{self.robot_name}, {self.scene}"

    @property
    def suite(self) -> str:
        """Name of the suite in titles of tables."""
        return SUITE

    @property
    def file(self) -> str:
        """Nothing: no file says where a random target is from."""
        return ""

    def task(self) -> ReachingTask:
        """Returns the target, and the truth about the scene.

        Raises:
            RemoSplatError: No goal can be held there.
        """
        scene = _scene(self.robot, self.scene)
        q = _goal(self.robot, self.scene, self.number)
        X_WEs = _robot(self.robot).end_effector_poses(q)
        first, *further = map(RigidTransform, X_WEs)
        task = solid_task(dc.replace(scene, X_WE_target=first))
        return dc.replace(task, further_targets=tuple(further))

    def splat_key(self) -> str:
        """Returns a key of the splat's content."""
        if self.scene == GENERATED:
            return f"{_scene(self.robot, self.scene).content_hash}-{_DISCS}"
        return self.scene

    def splat(self) -> tuple[GaussianSplat, str]:
        """Returns the map in W, and its origin as tables name it."""
        if self.scene == GENERATED:
            scene = _scene(self.robot, self.scene)
            return surfel_splat(scene, _DISCS), SURFEL
        return read_ply(_folder(self.scene) / "splat.ply"), TRAINED


def robot_cases(robots: Sequence[str], count: int) -> list[RobotCase]:
    """Returns random targets for some robots, in two scenes each.

    Args:
        robots: Their names or files.
        count: Number of targets in each scene.

    Raises:
        RemoSplatError: A robot cannot be loaded.
    """
    cases = []
    for name in robots:
        robot = _robot(name)
        trained = TRAINED_SCENES[robot.n_base > 0]
        cases += [
            RobotCase(name, scene, number, robot.description.name)
            for scene in (GENERATED, trained)
            for number in range(count)
        ]
    return cases


@lru_cache(maxsize=16)
def _robot(name: str) -> RobotModel:
    return load_robot(name, floor_height=FLOOR_HEIGHT)


def _folder(scene: str) -> Path:
    return resources.models_dir() / "scenes" / scene


@lru_cache(maxsize=16)
def _scene(robot: str, scene: str) -> PrimitiveScene:
    """The scene, with a place for the robot to start from."""
    if scene == GENERATED:
        found = clutter(_robot(robot), 0)
    else:
        found = read_scene(_folder(scene) / "scene.json")
    return dc.replace(found, X_WB_start=found.X_WB_start or (0.0, 0.0, 0.0))


@lru_cache(maxsize=16)
def _goal_space(robot: str, scene: str) -> FreeSpace:
    """What a goal must keep: more than the controller does."""
    model, solids = _robot(robot), _scene(robot, scene)
    law = ReactiveLaw.make(ReactiveControllerConfig(), model, 0.01)
    planner = MotionPlanner(
        model, law.self_clearance, ReactiveControllerConfig().guidance.planning
    )
    keep = law.collision.stopping + _SPARE
    start = _start(model, solids)
    return planner.free_space(start, SignedDistanceField(solids), keep)


def _start(robot: RobotModel, scene: PrimitiveScene) -> np.ndarray:
    q = robot.q_home
    if robot.n_base:
        q[:3] = scene.X_WB_start
    return q


@lru_cache(maxsize=4096)
def _goal(robot: str, scene: str, number: int) -> np.ndarray:
    """Draws a configuration that the robot can hold, shape (n_q,)."""
    model, space = _robot(robot), _goal_space(robot, scene)
    solids = _scene(robot, scene)
    start = _start(model, solids)
    # More than half a turn from zero is a turn too many.
    lower = np.maximum(model.position_lower, -np.pi)
    upper = np.minimum(model.position_upper, np.pi)
    spread = _INSIDE * (upper - lower)
    lower, upper = lower + spread, upper - spread
    if model.n_base:
        lower[:2], upper[:2] = start[:2] - _AROUND, start[:2] + _AROUND
    field = SignedDistanceField(solids)
    name = model.description.name
    rng = np.random.default_rng([*f"{name}/{scene}".encode(), number])
    for _ in range(_DRAWS):
        q = rng.uniform(lower, upper)
        spheres = model.spheres_at(q)
        hand = spheres.select(model.leading_spheres)
        near = field.clearances(hand, 2 * _NEAR).minimum() < _NEAR
        if near and _above_floor(model, q) and space.is_free(q):
            return q
    raise RemoSplatError(f"{name} can hold no goal in {scene}")


def _above_floor(robot: RobotModel, q: np.ndarray) -> bool:
    """Whether all that the arm moves is above the floor that it stands on."""
    spheres = robot.spheres_at(q).select(robot.moved_by_arm)
    return bool((spheres.p_WS[:, 2] - spheres.radius > FLOOR_HEIGHT).all())
