"""Makes a benchmark suite for any robot: random targets in several scenes.

A target is the pose of a hand in a random configuration. In this configuration
the robot keeps distances from the scene, from itself and from joint limits, and
the hand is near the scene or inside a piece of furniture. The robot can
therefore reach and hold every target. If the robot has several hands, each has
its own target.
"""

import dataclasses as dc
from collections.abc import Sequence
from contextlib import closing
from functools import lru_cache
from pathlib import Path

import numpy as np
from pydrake.math import RigidTransform

from remosplat_drake.base import resources
from remosplat_drake.base.errors import RemoSplatError, unknown_name
from remosplat_drake.base.pool import run_all
from remosplat_drake.benchmark.drawing import Drawing, no_drawing
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
from remosplat_drake.generation.furniture import KINDS, Furniture, furniture
from remosplat_drake.generation.primitive_surfels import surfel_splat
from remosplat_drake.oracle.signed_distance import SignedDistanceField
from remosplat_drake.robot.robot_model import RobotModel, load_robot
from remosplat_drake.scene.primitive_scene import PrimitiveScene
from remosplat_drake.scene.rmmi import read_scene
from remosplat_drake.splat.codecs.ply import read_ply
from remosplat_drake.splat.gaussian_splat import GaussianSplat

SUITE = "robots"
"""Kind of the suite, and prefix of its names."""

GENERATED = "clutter"
"""Name of the random scene that is generated for each robot."""

TRAINED_SCENES = {True: "table", False: "workbench"}
"""Names of the shipped scenes with a trained splat: for robots with a mobile
base, and for robots without a mobile base."""

_SHIPPED = "trained"
"""Name that selects the shipped scene suitable for a robot."""

SCENES = (GENERATED, _SHIPPED, *KINDS)
"""Names of all scenes that a suite may contain."""

FLOOR_HEIGHT = 0.03
"""Links that are close to the floor ignore the scene below this height [m], as
in scenarios."""

_SPARE = 0.009
"""Distance from obstacles that a goal keeps in addition to the controller's
stopping distance [m], because of map errors and for the approach."""

_INSIDE = 0.1
"""Distance of a goal's joint positions from joint limits, as a fraction of the
joint's range."""

_NEAR = 0.3
"""At a goal, the distance between hand and scene is less than this [m]."""

_AROUND = 1.2
"""At a goal, the base is at most this far from its start, along each axis
[m]."""

_DRAWS = 20_000
"""A search in a scene tries at most this many random configurations."""

_DRAWS_INSIDE = 50_000
"""At most this many random configurations are tried with one piece of
furniture, before another piece is drawn. The number is large, since the hand is
rarely inside the furniture in a random configuration."""

_PIECES = 40
"""A search draws at most this many pieces of furniture."""

_DISCS = 40_000
"""Number of discs in a generated scene's splat."""


@dc.dataclass(frozen=True)
class RobotCase:
    """One random target for one robot.

    Attributes:
        robot: Name or file of the robot.
        scene: `GENERATED`, one of `KINDS` of furniture, or the name of a
            shipped scene.
        number: Number of the target, from 0 on.
        robot_name: Name of the robot in its description.
        goal: Configuration that reaches the target, n_q numbers [rad, m].
        piece: Seed of the furniture; 0 for other scenes.
    """

    robot: str
    scene: str
    number: int
    robot_name: str
    goal: tuple[float, ...]
    piece: int = 0

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
        """Empty, since a random target has no file."""
        return ""

    def task(self) -> ReachingTask:
        """Returns the target, and the true geometry of the scene."""
        scene, q = self._solids, np.array(self.goal)
        X_WEs = _robot(self.robot).end_effector_poses(q)
        first, *further = map(RigidTransform, X_WEs)
        task = solid_task(dc.replace(scene, X_WE_target=first))
        return dc.replace(task, further_targets=tuple(further))

    def splat_key(self) -> str:
        """Returns a key that identifies the splat's content."""
        if self._is_generated:
            return f"{self._solids.content_hash}-{_DISCS}"
        return self.scene

    def splat(self) -> tuple[GaussianSplat, str]:
        """Returns the map in W, and its origin's name in tables."""
        if self._is_generated:
            return surfel_splat(self._solids, _DISCS), SURFEL
        return read_ply(_folder(self.scene) / "splat.ply"), TRAINED

    @property
    def _is_generated(self) -> bool:
        return self.scene == GENERATED or self.scene in KINDS

    @property
    def _solids(self) -> PrimitiveScene:
        return _scene(self.robot, self.scene, self.piece)


@dc.dataclass(frozen=True)
class _Wish:
    """Description of a target to draw; see `RobotCase`."""

    robot: str
    scene: str
    number: int


def robot_cases(
    robots: Sequence[str],
    count: int,
    scenes: str = "",
    jobs: int = 0,
    drawing: Drawing = no_drawing,
) -> list[RobotCase]:
    """Draws random targets for some robots.

    Args:
        robots: Names or files of the robots.
        count: Number of targets in each scene.
        scenes: Names from `SCENES`, joined by commas; empty for a cluttered
            scene and a scene with a trained splat.
        jobs: Number of worker processes; 0 draws in this process. The targets
            do not depend on this number.
        drawing: Callback that reports the number of drawn targets.

    Raises:
        RemoSplatError: A robot cannot be loaded, there is no such scene, or no
            goal is found for a robot in a scene.
    """
    chosen = scenes.split(",") if scenes else [GENERATED, _SHIPPED]
    for scene in chosen:
        if scene not in SCENES:
            problem = unknown_name("scene", scene, SCENES)
            raise RemoSplatError(f"--suite: {SUITE}:{scenes}: {problem}")
    wishes = [
        _Wish(
            name,
            TRAINED_SCENES[_robot(name).n_base > 0]
            if scene == _SHIPPED
            else scene,
            number,
        )
        for name in robots
        for scene in chosen
        for number in range(count)
    ]
    drawn: dict[_Wish, RobotCase] = {}
    with closing(run_all(_draw, wishes, jobs)) as cases:
        for case in cases:
            drawn[_Wish(case.robot, case.scene, case.number)] = case
            drawing("targets", len(drawn), len(wishes))
    return [drawn[wish] for wish in wishes]


def _draw(wish: _Wish) -> RobotCase:
    """Draws a target, and the furniture if the scene is a kind of furniture.

    Raises:
        RemoSplatError: No goal is found that the robot can reach and hold.
    """
    robot = _robot(wish.robot)
    name, scene, number = robot.description.name, wish.scene, wish.number
    rng = np.random.default_rng([*f"{name}/{scene}".encode(), number])
    if scene not in KINDS:
        q = _held(robot, _scene(wish.robot, scene, 0), rng, _DRAWS)
        if q is None:
            raise RemoSplatError(
                f"found no goal in {scene} that {name} can reach"
            )
        return RobotCase(wish.robot, scene, number, name, tuple(q.tolist()))
    for attempt in range(_PIECES):
        piece = number + attempt * 1_000_000
        drawn = furniture(robot, scene, piece)
        q = _held(robot, drawn.scene, rng, _DRAWS_INSIDE, drawn)
        if q is not None:
            goal = tuple(q.tolist())
            return RobotCase(wish.robot, scene, number, name, goal, piece)
    raise RemoSplatError(f"found no goal in a {scene} that {name} can reach")


@lru_cache(maxsize=16)
def _robot(name: str) -> RobotModel:
    return load_robot(name, floor_height=FLOOR_HEIGHT)


def _folder(scene: str) -> Path:
    return resources.models_dir() / "scenes" / scene


@lru_cache(maxsize=16)
def _scene(robot: str, scene: str, piece: int) -> PrimitiveScene:
    """Returns the scene, with a start pose of the robot."""
    if scene in KINDS:
        found = furniture(_robot(robot), scene, piece).scene
    elif scene == GENERATED:
        found = clutter(_robot(robot), 0)
    else:
        found = read_scene(_folder(scene) / "scene.json")
    return dc.replace(found, X_WB_start=found.X_WB_start or (0.0, 0.0, 0.0))


def _goal_space(robot: RobotModel, solids: PrimitiveScene) -> FreeSpace:
    """Makes the check of a goal's distances; they exceed the controller's."""
    law = ReactiveLaw.make(ReactiveControllerConfig(), robot, 0.01)
    planner = MotionPlanner(
        robot, law.self_clearance, ReactiveControllerConfig().guidance.planning
    )
    keep = law.collision.stopping + _SPARE
    start = _start(robot, solids)
    return planner.free_space(start, SignedDistanceField(solids), keep)


def _start(robot: RobotModel, scene: PrimitiveScene) -> np.ndarray:
    q = robot.q_home
    if robot.n_base and scene.X_WB_start is not None:
        q[:3] = scene.X_WB_start
    return q


def _held(
    robot: RobotModel,
    solids: PrimitiveScene,
    rng: np.random.Generator,
    draws: int,
    around: Furniture | None = None,
) -> np.ndarray | None:
    """Draws a configuration that keeps all distances; None if none is found.

    In it, the hand is inside the given piece of furniture, or else near the
    scene.
    """
    space, start = _goal_space(robot, solids), _start(robot, solids)
    # Angles beyond half a turn are equivalent to smaller angles, and would
    # require a needless turn.
    lower = np.maximum(robot.position_lower, -np.pi)
    upper = np.minimum(robot.position_upper, np.pi)
    spread = _INSIDE * (upper - lower)
    lower, upper = lower + spread, upper - spread
    if robot.n_base:
        lower[:2], upper[:2] = start[:2] - _AROUND, start[:2] + _AROUND
    for _ in range(draws):
        q = rng.uniform(lower, upper)
        if around is None:
            is_wanted = _is_near(robot, space, q)
        else:
            is_wanted = around.holds(robot.end_effector_pose(q)[:3, 3])
        if is_wanted and _above_floor(robot, q) and space.is_free(q):
            return q
    return None


def _is_near(robot: RobotModel, space: FreeSpace, q: np.ndarray) -> bool:
    """Whether the hand is near the scene."""
    hand = robot.spheres_at(q).select(robot.leading_spheres)
    return space.field.clearances(hand, 2 * _NEAR).minimum() < _NEAR


def _above_floor(robot: RobotModel, q: np.ndarray) -> bool:
    """Whether all links that the arm moves are above the floor."""
    spheres = robot.spheres_at(q).select(robot.moved_by_arm)
    return bool((spheres.p_WS[:, 2] - spheres.radius > FLOOR_HEIGHT).all())
