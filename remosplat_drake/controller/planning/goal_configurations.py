"""Goal configurations: what reaches the target and keeps its distances."""

import dataclasses as dc
import math

import numpy as np

from remosplat_drake.controller.planning.free_space import FreeSpace
from remosplat_drake.controller.planning.kernels.inverse_kinematics import (
    reach_from,
)
from remosplat_drake.robot.robot_model import RobotModel

TOLERANCE = 1e-4
"""Pose error of a goal configuration, angles weighed by 0.3 m [m]."""

_STEPS = 40
"""Most steps of the inverse kinematics from a seed."""

_BASE_DISTANCE = (0.35, 0.95)
"""Least and greatest distance of guessed bases from the target [m]."""

_BASE_TURN = 0.8
"""Largest turn of a guessed base away from the target [rad]."""


@dc.dataclass(frozen=True, eq=False)
class GoalConfigurations:
    """What was found at a target.

    Attributes:
        q: Goal configurations that keep all distances, the best first, shape
            (k, n_q) [rad, m].
        seeds: Number of seeds that were tried.
        reached: Number of seeds from which the target was reached at all.
        tightest: Index of the sphere that had too little room in the best of
            those that keep too little distance; -1 if none reached or all did.
        missing: How much room that sphere lacked [m].
    """

    q: np.ndarray
    seeds: int
    reached: int
    tightest: int = -1
    missing: float = 0.0


def goal_configurations(
    space: FreeSpace,
    X_WT: np.ndarray,
    q: np.ndarray,
    *,
    seeds: int,
    most: int,
    rng: np.random.Generator,
) -> GoalConfigurations:
    """Searches configurations that reach a target and keep their distances.

    Args:
        space: The free space.
        X_WT: Pose of the target T in the world W, shape (4, 4).
        q: Where the robot is, shape (n_q,) [rad, m]; the nearer to it the
            better.
        seeds: Number of configurations to start from.
        most: Largest number of goal configurations.
        rng: Source of the seeds.
    """
    robot = space.robot
    found, solved = reach(
        robot,
        X_WT,
        _seeds(space, X_WT, q, seeds, rng),
        (space.lower, space.upper),
    )
    found = found[solved]
    if not len(found):
        return GoalConfigurations(found, seeds, 0)
    rooms = space.rooms(found)
    least = rooms.min(axis=1)
    free = least >= 0.0
    for i in np.flatnonzero(free):
        free[i] = bool((space.own_rooms(found[i]) >= 0.0).all())
    if not free.any():
        best = int(np.argmax(least))
        sphere = int(np.argmin(rooms[best]))
        return GoalConfigurations(
            found[:0], seeds, len(found), sphere, max(-least[best], 0.0)
        )
    price = _price(space, found[free], least[free], q)
    order = np.argsort(price, kind="stable")[:most]
    return GoalConfigurations(found[free][order], seeds, len(found))


def reach(
    robot: RobotModel,
    X_WT: np.ndarray,
    seeds: np.ndarray,
    bounds: tuple[np.ndarray, np.ndarray],
) -> tuple[np.ndarray, np.ndarray]:
    """Solves the arm's inverse kinematics from many seeds; the base stays.

    Args:
        robot: The robot.
        X_WT: Pose of the target T in the world W, shape (4, 4).
        seeds: Configurations to start from, shape (k, n_q) [rad, m].
        bounds: Lower and upper bounds of q, shape (n_q,) each [rad, m].

    Returns:
        Where each seed has led to, shape (k, n_q), and whether the target is
        reached there, shape (k,) bool.
    """
    tree, body_E, X_LE, joints = robot.arm_arrays
    return reach_from(
        tree,
        body_E,
        X_LE,
        np.ascontiguousarray(X_WT),
        joints,
        *bounds,
        seeds,
        _STEPS,
        TOLERANCE,
    )


def _seeds(
    space: FreeSpace,
    X_WT: np.ndarray,
    q: np.ndarray,
    count: int,
    rng: np.random.Generator,
) -> np.ndarray:
    """Draws seeds all over the bounds, shape (count, n_q).

    The arm's home and its present configuration are among them.
    """
    robot = space.robot
    arm = slice(robot.n_q - len(robot.home), None)
    seeds = np.tile(q, (count, 1))
    seeds[:, arm] = rng.uniform(
        space.lower[arm], space.upper[arm], (count, len(robot.home))
    )
    seeds[0] = q
    seeds[1 % count, arm] = robot.home
    seeds = np.clip(seeds, space.lower, space.upper)
    if robot.n_base:
        away = rng.uniform(*_BASE_DISTANCE, count)
        bearing = rng.uniform(-math.pi, math.pi, count)
        seeds[:, 0] = X_WT[0, 3] - away * np.cos(bearing)
        seeds[:, 1] = X_WT[1, 3] - away * np.sin(bearing)
        seeds[:, 2] = bearing + rng.uniform(-_BASE_TURN, _BASE_TURN, count)
        seeds[0, :3] = q[:3]
    return seeds


def _price(
    space: FreeSpace, found: np.ndarray, room: np.ndarray, q: np.ndarray
) -> np.ndarray:
    """Prices goal configurations: far, cramped or at a limit is dear, (k,).

    Roughly the time to get there [s].
    """
    robot = space.robot
    arm = slice(robot.n_q - len(robot.home), None)
    speed = robot.velocity_limit[robot.n_base :]
    far = (np.abs(found[:, arm] - q[arm]) / speed).max(axis=1)
    if robot.n_base:
        way = np.hypot(*(found[:, :2] - q[:2]).T)
        far = np.maximum(far, way / robot.velocity_limit[0])
    cramped = np.exp(-room / 0.02)
    inside = np.minimum(found - space.lower, space.upper - found)[:, arm]
    at_limit = np.exp(-inside / 0.2).max(axis=1)
    singular = np.array([_singularity(robot, x) for x in found])
    return far + 2.0 * cramped + at_limit + singular


def _singularity(robot: RobotModel, q: np.ndarray) -> float:
    """Tells how near the arm is to a singularity, between 0 and 1."""
    state = robot.state(q)
    J = np.vstack([state.Jw_WE, state.Jv_WE])[:, robot.n_base :]
    m = math.sqrt(max(np.linalg.det(J @ J.T), 0.0)) if len(J.T) > 5 else 1.0
    return math.exp(-m / 0.02)
