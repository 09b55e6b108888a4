"""`Situation`: a random run in which the robot cannot reach its target."""

import dataclasses as dc
from collections.abc import Callable
from functools import cached_property
from pathlib import Path

import numpy as np
from pydrake.math import RigidTransform, RollPitchYaw

from apps.studies.causes.faults import CLASSES, MODE, SCANNER
from remosplat_drake.app.scenario import Scenario, load_scenario
from remosplat_drake.app.world import World, load_world
from remosplat_drake.cockpit.reach import REACHABLE, find_reach
from remosplat_drake.controller.planning.motion_planner import MotionPlanner
from remosplat_drake.controller.tick.reactive_law import ReactiveLaw
from remosplat_drake.oracle.signed_distance import SignedDistanceField
from remosplat_drake.robot.reach import end_effector_reach, shoulder
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.robot.sphere_model import Spheres
from remosplat_drake.scene.primitive_scene import Box, PrimitiveScene
from remosplat_drake.scene.rmmi import write_rmmi
from remosplat_drake.signals.target import Target

SCENE, UNSEEN, SELF, JOINT, MOVER = (
    "scene",
    "unseen space",
    "the robot itself",
    "a joint limit",
    "a mover",
)
BASE, STOP, LOST, NO_CONFIGURATION, NO_PATH = (
    "the base",
    "the supervisor",
    "localisation",
    "no configuration",
    "no path",
)
KINDS = (
    SCENE,
    UNSEEN,
    SELF,
    JOINT,
    MOVER,
    BASE,
    STOP,
    LOST,
    NO_CONFIGURATION,
    NO_PATH,
)
"""Kinds of causes, in turn by seed."""

PRESS = "a press of STOP"
"""Fault of a run in which the operator presses STOP."""

MOST_DRAWS = 200
"""Largest number of targets that are drawn for a situation."""

LEAVES_AT = 5.0
"""Time at which a mover leaves [s]."""

_FAR = Box(RigidTransform([0.0, 0.0, -9.0]), np.full(3, 0.1), "far away")
_TABLE, _PANDA = "TableGroundTruth", "panda"
_PARKED = (
    "controller: {velocity_limits: {max_forward: 0, max_reverse: 0,"
    " max_yaw_rate: 0}}"
)
_BARE = """
One:
  scene: {truth: scene.json}
  robot: {model: %s}
  oracle: !GroundTruth {}
  control_period: 0.02
  targets:
  - {translation: [0.5, 0.0, 0.5], rpy_deg: [180, 0, 0]}
"""


@dc.dataclass(frozen=True, eq=False)
class Situation:
    """A random run in which the robot cannot reach its target.

    Attributes:
        kind: One of `KINDS`.
        scenario: The scenario, with its target.
        world: The content of its files.
        X_WT: The target, shape (4, 4).
        press_at: Time at which STOP is pressed [s]; infinite for never.
        fault_at: Time at which a fault begins [s]; NaN without one.
        drives: Whether the base may drive.
        fields: Fields of the scenario that were overridden, besides its target.
    """

    kind: str
    scenario: Scenario
    world: World
    X_WT: np.ndarray
    press_at: float = np.inf
    fault_at: float = np.nan
    drives: bool = True
    fields: str = ""

    @cached_property
    def law(self) -> ReactiveLaw:
        """The control law."""
        scenario = self.scenario
        return ReactiveLaw.make(
            scenario.controller, self.world.robot, scenario.control_period
        )

    @property
    def planner(self) -> MotionPlanner:
        """The planner, which finds configurations at targets."""
        config = self.scenario.controller.guidance.planning
        return MotionPlanner(self.world.robot, self.law.self_clearance, config)


def draw_situation(seed: int, folder: Path) -> Situation:
    """Draws a situation; equal seeds give equal ones.

    Args:
        seed: The seed, which also gives the kind.
        folder: An empty folder for scenes.
    """
    kind = KINDS[seed % len(KINDS)]
    rng = np.random.default_rng([42, seed])
    return _DRAWS[kind](rng, folder)


def pose(p_W: np.ndarray, yaw: float = 0.0) -> np.ndarray:
    """Returns the pose of a hand that points down, shape (4, 4).

    Args:
        p_W: Its place in W, shape (3,) [m].
        yaw: Its turn about the vertical [rad].
    """
    turn = RollPitchYaw([np.pi, 0.0, yaw])
    return RigidTransform(turn, p_W).GetAsMatrix4()


def with_target(spec: str, X_WT: np.ndarray, fields: str = "") -> Scenario:
    """Reads a scenario, and replaces its targets.

    Args:
        spec: Name of the scenario, or FILE:NAME.
        X_WT: The target, shape (4, 4).
        fields: Further fields as YAML, without braces.
    """
    rpy = np.degrees(RollPitchYaw(np.ascontiguousarray(X_WT[:3, :3])).vector())
    target = f"translation: {X_WT[:3, 3].tolist()}, rpy_deg: {rpy.tolist()}"
    more = f", {fields}" if fields else ""
    text = f"{{time_limit: 15, targets: [{{{target}}}]{more}}}"
    return load_scenario(spec, text)


def _situation(
    kind: str, spec: str, X_WT: np.ndarray, fields: str = "", **known
) -> Situation:
    scenario = with_target(spec, X_WT, fields)
    world = load_world(scenario)
    return Situation(kind, scenario, world, X_WT, fields=fields, **known)


def _unreachable(
    kind: str,
    spec: str,
    draw: Callable[[World], np.ndarray],
    fields: str = "",
) -> Situation:
    """Draws targets until one cannot be reached."""
    start = _situation(kind, spec, pose(np.zeros(3)), fields)
    for _ in range(MOST_DRAWS):
        X_WT = draw(start.world)
        if not is_reachable(start, X_WT):
            return _situation(kind, spec, X_WT, fields)
    raise RuntimeError(f"all of {MOST_DRAWS} targets can be reached")


def is_reachable(situation: Situation, X_WT: np.ndarray) -> bool:
    """Returns whether the planner finds a configuration at a target.

    Args:
        situation: The situation.
        X_WT: The target, shape (4, 4).
    """
    world, config = situation.world, situation.scenario.controller
    stopping = config.collision.stopping
    reach = find_reach(
        situation.planner, world.field, stopping, world.q0, Target(X_WT)
    )
    return reach.verdict == REACHABLE


def _yaw(rng: np.random.Generator) -> float:
    return float(rng.uniform(-np.pi, np.pi))


def _scene(rng: np.random.Generator, folder: Path) -> Situation:
    """Draws a target in the middle of a solid, or too near to the floor."""
    is_floor = rng.random() < 0.4

    def draw(world: World) -> np.ndarray:
        if is_floor:
            p_W = rng.uniform([-0.2, 0.8, -0.1], [0.4, 1.2, 0.0])
            return pose(p_W, _yaw(rng))
        assert world.truth is not None
        boxes = [b for b in world.truth.boxes if b.X_WP.translation()[2] > 0.1]
        box = boxes[int(rng.integers(len(boxes)))]
        inside = rng.uniform(-0.5, 0.5, 3) * box.half_extents
        return pose(box.X_WP.multiply(inside), _yaw(rng))

    return _unreachable(SCENE, _TABLE, draw)


def _unseen(rng: np.random.Generator, folder: Path) -> Situation:
    """Draws a target in free space that the capture's views do not show."""

    def draw(world: World) -> np.ndarray:
        assert world.seen is not None and world.truth is not None
        truth = SignedDistanceField(world.truth)
        while True:
            p_W = rng.uniform([0.4, -1.2, 0.3], [2.0, 1.2, 1.6])
            here = Spheres.at(p_W)
            is_free = truth.clearances(here, 1.0).minimum() > 0.12
            if is_free and world.seen.hides(p_W[None])[0]:
                return pose(p_W, _yaw(rng))

    return _unreachable(
        UNSEEN, "TableReach", draw, "scene: {unknown: obstacle}"
    )


def _bare(folder: Path, model: str, *boxes: Box) -> str:
    """Writes a scenario among a few boxes; returns its FILE:NAME."""
    write_rmmi(folder / "scene.json", PrimitiveScene(boxes=(*boxes, _FAR)))
    (folder / "test.yaml").write_text(_BARE % model)
    return f"{folder}/test.yaml:One"


def _itself(rng: np.random.Generator, folder: Path) -> Situation:
    """Draws a target inside the robot's own column."""

    def draw(world: World) -> np.ndarray:
        p_W = rng.uniform([-0.12, -0.12, 0.1], [0.12, 0.12, 0.5])
        return pose(p_W, _yaw(rng))

    return _unreachable(SELF, _bare(folder, _PANDA), draw)


def _joint(rng: np.random.Generator, folder: Path) -> Situation:
    """Draws a target that only a joint beyond its limit could reach."""

    def draw(world: World) -> np.ndarray:
        robot = world.robot
        lower, upper = robot.position_lower, robot.position_upper
        middle = 0.5 * (lower + upper)
        q = middle + rng.uniform(-0.6, 0.6, len(middle)) * (upper - middle)
        k, beyond = int(rng.integers(robot.n_q)), rng.uniform(0.2, 0.6)
        q[k] = upper[k] + beyond if rng.random() < 0.5 else lower[k] - beyond
        return robot.end_effector_pose(q)

    return _unreachable(JOINT, _bare(folder, _PANDA), draw)


def _mover(rng: np.random.Generator, folder: Path) -> Situation:
    """Draws a run with a person's forearm at the target for some seconds."""
    start = _situation(MOVER, _TABLE, pose(np.array([1.0, 0.0, 0.9])))
    while True:
        X_WT = pose(rng.uniform([0.8, -0.6, 0.75], [1.2, 0.6, 1.1]), _yaw(rng))
        if is_reachable(start, X_WT):
            break
    x, y, z = (X_WT[:3, 3] + rng.uniform(-0.05, 0.05, 3)).tolist()
    turn = f"rpy_deg: [90, 0, {rng.uniform(0, 180):.0f}]"
    points = ", ".join(
        f"{{time: {time}, translation: [{x}, {y}, {z + up}], {turn}}}"
        for time, up in (*_stays(LEAVES_AT), (LEAVES_AT + 2.0, 1.2))
    )
    mover = (
        "movers: [{name: Ada, half_extents: [0, 0, 0.15], radius: 0.05,"
        f" max_speed: 2.0, max_acceleration: 4.0, waypoints: [{points}]}}]"
    )
    return _situation(MOVER, _TABLE, X_WT, mover)


def _stays(until: float) -> list[tuple[float, float]]:
    """Times of waypoints that keep a mover in place: its track is a spline."""
    return [(float(time), 0.0) for time in np.arange(0.0, until + 0.1, 0.5)]


def _base(rng: np.random.Generator, folder: Path) -> Situation:
    """Draws a run with a base that is disabled, fenced in, or stopped.

    From the pose of the base, the target is out of the arm's reach.
    """
    which = int(rng.integers(3))
    far = pose(
        np.array([*rng.uniform([1.8, -0.6], [2.6, 0.6]), rng.uniform(0.4, 0.9)])
    )
    if which == 0:
        spec = _bare(folder, "frankie")
        return _situation(BASE, spec, far, _PARKED, drives=False)
    if which == 1:
        fence = _walls(1.0, float(rng.uniform(0.1, 0.3)))
        return _situation(BASE, _bare(folder, "frankie", *fence), far)
    return _stopped(BASE, rng, SCANNER)


def _walls(at: float, height: float) -> list[Box]:
    """Four walls around the robot's start."""
    thin, half = 0.03, 0.5 * height
    return [
        Box(RigidTransform([x, y, half]), np.array([a, b, half]), "wall")
        for x, y, a, b in (
            (at, 0.0, thin, at),
            (-at, 0.0, thin, at),
            (0.0, at, at, thin),
            (0.0, -at, at, thin),
        )
    ]


def _stopped(kind: str, rng: np.random.Generator, fault: str) -> Situation:
    """Draws a run to a target behind the robot, during which a fault begins."""
    begin = float(rng.uniform(0.3, 1.0))
    p_W = rng.uniform([-2.6, -1.0, 0.6], [-1.8, 1.0, 1.0])
    spec, X_WT = _TABLE, pose(p_W, _yaw(rng))
    if fault == PRESS:
        return _situation(kind, spec, X_WT, press_at=begin, fault_at=begin)
    fields = (
        "station: !apps.studies.causes.faults:FaultyStation"
        f" {{fault: {fault}, begin: {begin:.3f}}}"
    )
    return _situation(kind, spec, X_WT, fields, fault_at=begin)


def _supervisor(rng: np.random.Generator, folder: Path) -> Situation:
    faults = (PRESS, *CLASSES[MODE])
    return _stopped(STOP, rng, str(rng.choice(faults)))


def _lost(rng: np.random.Generator, folder: Path) -> Situation:
    return _stopped(LOST, rng, str(rng.choice(CLASSES[LOST])))


def _no_configuration(rng: np.random.Generator, folder: Path) -> Situation:
    """Draws a target above a mobile arm's reach, or around a fixed one's."""
    if rng.random() < 0.5:
        X_WT = pose(rng.uniform([0.6, -0.4, 2.2], [1.2, 0.4, 3.0]), _yaw(rng))
        return _situation(NO_CONFIGURATION, _TABLE, X_WT)

    def draw(world: World) -> np.ndarray:
        robot, q = world.robot, world.q0
        return pose(_around(robot, q, rng), _yaw(rng))

    return _unreachable(NO_CONFIGURATION, _bare(folder, _PANDA), draw)


def _around(
    robot: RobotModel, q: np.ndarray, rng: np.random.Generator
) -> np.ndarray:
    """Draws a place beyond or at the end of an arm's reach, shape (3,) [m]."""
    way = rng.normal(size=3)
    way[2] = abs(way[2])
    length = end_effector_reach(robot) * rng.uniform(0.95, 1.5)
    return shoulder(robot, q) + length * way / np.linalg.norm(way)


def _no_path(rng: np.random.Generator, folder: Path) -> Situation:
    """Draws a target behind the wall of a room without a door."""
    at = float(rng.uniform(1.1, 1.5))
    spec = _bare(folder, "frankie", *_walls(at, 3.0))
    angle = float(rng.choice([0.0, 0.5 * np.pi, -0.5 * np.pi]))
    angle += rng.uniform(-0.3, 0.3)
    way = np.array([np.cos(angle), np.sin(angle)])
    x, y = rng.uniform(at + 0.9, at + 1.8) * way
    p_W = np.array([x, y, rng.uniform(0.4, 1.0)])
    return _situation(NO_PATH, spec, pose(p_W, _yaw(rng)))


_DRAWS = {
    SCENE: _scene,
    UNSEEN: _unseen,
    SELF: _itself,
    JOINT: _joint,
    MOVER: _mover,
    BASE: _base,
    STOP: _supervisor,
    LOST: _lost,
    NO_CONFIGURATION: _no_configuration,
    NO_PATH: _no_path,
}
