"""Writes a first scenario for a new robot, and tries it in a simulation.

The scene has a post on the floor, and targets on both sides of the post. The
scenario contains only targets that the robot has reached in a trial run.
"""

import dataclasses as dc
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import yaml
from pydrake.math import RigidTransform, RollPitchYaw

from remosplat_drake.app.diagram import build
from remosplat_drake.app.scenario import load_scenario
from remosplat_drake.app.simulation import run
from remosplat_drake.base.atomic_file import write_atomically
from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.generation.primitive_surfels import surfel_splat
from remosplat_drake.oracle.signed_distance import SignedDistanceField
from remosplat_drake.robot.importing.home import keeps_off_itself
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.scene.primitive_scene import Cylinder, PrimitiveScene
from remosplat_drake.scene.rmmi import write_rmmi
from remosplat_drake.splat.formats import write_splat

NAME = "Reach"
"""Name of the scenario."""

TARGETS = 2
"""Number of targets of each end effector."""

TRIES = 6
"""At most this many random scenes are tried."""

TIME_LIMIT = 20.0
"""Time limit of the scenario [s]."""

_ROOM = 0.12
"""Clearance that the robot must have at the start and at the targets [m]."""

_SELF_ROOM = 0.02
"""Distance that the robot's parts must keep from each other at the targets
[m]."""

_MARGIN = 0.2
"""At the targets, joint positions must keep this distance from the joint
limits, expressed as a fraction of the joint's range."""

_IMPATIENT = """{
    time_limit: 10, controller: {guidance: {planning: {enabled: false}}}
}"""
"""Settings of the trial run. Planning is disabled, so that the trial run does
not spend time on a target that the controller alone does not reach."""

_DISCS = 4000
"""Number of discs in the scene's splat."""


@dc.dataclass(frozen=True)
class Tried:
    """Result of the scenario's trial run.

    Attributes:
        reached: Number of targets that were reached.
        time: Simulated time until the last target was reached [s].
        clearance: Least true clearance during the run [m].
    """

    reached: int
    time: float
    clearance: float


def write_first_scenario(
    robot: RobotModel,
    folder: Path,
    on_try: Callable[[int, int], None] = lambda i, n: None,
) -> Tried:
    """Writes `scenario.yaml` with its scene into the robot's folder.

    Args:
        robot: The robot, whose description is in `folder`.
        folder: The folder.
        on_try: Function that is called with the number of scenes tried so far,
            and the number of scenes that are tried at most.

    Raises:
        RemoSplatError: The robot reaches no target in any of the scenes, or its
            start is inside an obstacle in all of them.
    """
    best: tuple[Tried, list[np.ndarray], PrimitiveScene] | None = None
    effectors = len(robot.effectors)
    for i, (scene, goals) in enumerate(_scenes(robot)):
        on_try(i, TRIES)
        _write(folder, goals, scene, robot)
        tried = _try(folder)
        if best is None or tried.reached > best[0].reached:
            best = tried, goals, scene
        if tried.reached == effectors * TARGETS:
            break
    if best is None or best[0].reached < effectors:
        raise RemoSplatError(
            f"{robot.description.name} reached no target; check its spheres"
            " (robot.png) and its home posture"
        )
    tried, goals, scene = best
    kept = tried.reached // effectors
    if kept < TARGETS:
        # A run with fewer targets takes another path, so the scenario runs
        # again with only the targets that it will contain.
        _write(folder, goals[:kept], scene, robot)
        tried = _try(folder)
    return tried


def _scenes(
    robot: RobotModel,
) -> Iterator[tuple[PrimitiveScene, list[np.ndarray]]]:
    """Yields random posts and targets; start and targets are free."""
    made = 0
    for seed in range(10 * TRIES):
        if made == TRIES:
            return
        rng = np.random.default_rng(seed)
        drawn = [_goal(robot, rng) for _ in range(TARGETS)]
        goals = [q for q in drawn if q is not None]
        if len(goals) < TARGETS:
            continue
        states = [robot.q_home, *goals]
        post = _post(robot, states, rng)
        if post is None:
            continue
        made += 1
        yield PrimitiveScene(cylinders=(post,), name="scene"), goals


def _goal(robot: RobotModel, rng: np.random.Generator) -> np.ndarray | None:
    """Draws a valid configuration away from the home posture; None if none."""
    n = robot.n_q - len(robot.home)
    for _ in range(200):
        q = robot.q_home
        lower, upper = robot.position_lower[n:], robot.position_upper[n:]
        margin = _MARGIN * (upper - lower)
        step = np.where(
            robot.arm_turns, 0.7, 0.3 * np.minimum(upper - lower, 1)
        )
        q[n:] += rng.uniform(-step, step)
        q[n:] = np.clip(q[n:], lower + margin, upper - margin)
        if robot.n_base:
            q[:3] = rng.uniform((0.6, -0.5, -0.5), (1.2, 0.5, 0.5))
        ways = robot.end_effector_poses(q) - robot.end_effector_poses(
            robot.q_home
        )
        way = np.linalg.norm(ways[:, :3, 3], axis=1).min()
        low = _lowest(robot, q) < _lowest(robot, robot.q_home) - 0.1
        if way > 0.15 and not low and keeps_off_itself(robot, q, _SELF_ROOM):
            return q
    return None


def _lowest(robot: RobotModel, q: np.ndarray) -> float:
    """Returns the height of the lowest sphere of the arm's moving links [m]."""
    spheres = robot.spheres_at(q)
    low = (spheres.p_WS[:, 2] - spheres.radius)[robot.moved_by_arm]
    return float(low.min(initial=np.inf))


def _post(
    robot: RobotModel, states: list[np.ndarray], rng: np.random.Generator
) -> Cylinder | None:
    """Makes a post beside the hand's path; the given states do not touch it."""
    ends = np.array([robot.end_effector_poses(q)[:, :3, 3] for q in states])
    for _ in range(100):
        hand = rng.integers(ends.shape[1])
        a, b = ends[rng.permutation(len(ends))[:2], hand]
        foot = a + rng.uniform(0.2, 0.8) * (b - a)
        angle, far = rng.uniform(-np.pi, np.pi), rng.uniform(0.1, 0.5)
        x, y = foot[:2] + far * np.array([np.cos(angle), np.sin(angle)])
        half = 0.5 * max(foot[2] + rng.uniform(-0.1, 0.25), 0.2)
        post = Cylinder(RigidTransform([x, y, half]), 0.04, half)
        field = SignedDistanceField(PrimitiveScene(cylinders=(post,)))
        if all(
            field.clearances(robot.spheres_at(q), 2 * _ROOM).minimum() > _ROOM
            for q in states
        ):
            return post
    return None


def _text(robot: RobotModel, goals: list[np.ndarray]) -> str:
    poses = [robot.end_effector_poses(q) for q in goals]
    entry = {
        NAME: {
            "scene": {"splat": "scene.ply", "truth": "scene.json"},
            "robot": {"model": Path(robot.description.source).name},
            "targets": [
                _target(effector, RigidTransform(X_WT))
                for X_WTs in poses
                for effector, X_WT in zip(robot.effectors, X_WTs, strict=True)
            ],
            "time_limit": TIME_LIMIT,
        }
    }
    return _HEAD + yaml.safe_dump(
        entry, sort_keys=False, default_flow_style=None, width=80
    )


def _target(effector: str, X_WT: RigidTransform) -> dict:
    rpy_deg = np.rad2deg(RollPitchYaw(X_WT.rotation()).vector())
    return {
        **({"effector": effector} if effector else {}),
        "translation": X_WT.translation().round(3).tolist(),
        "rpy_deg": rpy_deg.round(1).tolist(),
    }


_HEAD = """\
# A first scenario, made and tried by `remosplat import-robot`: a post, and
# targets beside it that the robot reached in a trial run.
"""


def _write(
    folder: Path,
    goals: list[np.ndarray],
    scene: PrimitiveScene,
    robot: RobotModel,
) -> None:
    write_rmmi(folder / "scene.json", scene)
    write_splat(folder / "scene.ply", surfel_splat(scene, _DISCS))
    write_atomically(folder / "scenario.yaml", _text(robot, goals))


def _try(folder: Path) -> Tried:
    """Makes a trial run of the scenario in a simulation."""
    scenario = load_scenario(str(folder / "scenario.yaml"), _IMPATIENT)
    result = run(build(scenario)).uninterrupted()
    metrics = result.metrics
    assert metrics.truth_clearance_min is not None
    return Tried(
        result.targets_reached, metrics.duration, metrics.truth_clearance_min
    )
