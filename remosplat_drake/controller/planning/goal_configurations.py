"""Goal configurations: what reaches the target and keeps its distances."""

import dataclasses as dc
import math

import numpy as np

from remosplat_drake.controller.planning.free_space import FreeSpace
from remosplat_drake.controller.planning.kernels.inverse_kinematics import (
    reach_from,
)
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.signals.aim import Aim
from remosplat_drake.signals.target import Target

TOLERANCE = 2e-3
"""Largest pose error of a goal configuration, angles weighed by 0.3 m [m].
Only joint limits leave more than a hundredth of it."""

_STEPS = 15
"""Most steps of the inverse kinematics from a seed."""

_ROUND = 50
"""Number of seeds in a round; the search ends when it has found enough."""

_ENOUGH = 0.06
"""Room beyond which more is no better [m]."""

_DRAWS = 4
"""Number of draws for a seed; those nearest to the target are taken."""

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
        cramped: That best one, shape (n_q,) [rad, m]; None if none reached or
            all did.
    """

    q: np.ndarray
    seeds: int
    reached: int
    tightest: int = -1
    missing: float = 0.0
    cramped: np.ndarray | None = None


def goal_configurations(
    space: FreeSpace,
    aim: Aim | Target | np.ndarray,
    q: np.ndarray,
    *,
    seeds: int,
    most: int,
    rng: np.random.Generator,
) -> GoalConfigurations:
    """Searches configurations that reach a target and keep their distances.

    Args:
        space: The free space.
        aim: What the end effectors shall reach: an `Aim`, or for the first of
            them a `Target` or the pose X_WT of a plain one, shape (4, 4).
        q: Where the robot is, shape (n_q,) [rad, m]; the nearer to it the
            better.
        seeds: Number of configurations to start from.
        most: Largest number of goal configurations.
        rng: Source of the seeds.
    """
    aim = Aim.of(aim)
    found, free = np.zeros((0, len(q))), np.zeros(0, bool)
    tried = 0
    while tried < seeds and free.sum() < most:
        count = min(_ROUND, seeds - tried)
        more = _reaching(space, aim, q, count, rng, with_own=not tried)
        found = np.concatenate([found, more])
        free = np.concatenate([free, [space.is_free(x) for x in more]])
        free = free.astype(bool)
        tried += count
    if free.any():
        best = found[free]
        least = space.rooms(best, _ENOUGH).min(axis=1)
        order = np.argsort(_price(space, aim, best, least, q), kind="stable")
        return GoalConfigurations(best[order[:most]], tried, len(found))
    if not len(found):
        return GoalConfigurations(found, tried, 0)
    rooms = space.rooms(found, _ENOUGH)
    best = int(np.argmax(rooms.min(axis=1)))
    sphere = int(np.argmin(rooms[best]))
    missing = max(-float(rooms[best, sphere]), 0.0)
    return GoalConfigurations(
        found[:0], tried, len(found), sphere, missing, found[best]
    )


def _reaching(
    space: FreeSpace,
    aim: Aim,
    q: np.ndarray,
    count: int,
    rng: np.random.Generator,
    *,
    with_own: bool,
) -> np.ndarray:
    """Draws seeds and returns what they lead to at the target, (k, n_q).

    The arm's home and its present configuration are seeds if `with_own`.
    """
    bounds = space.lower, space.upper
    draws = _draws(space, aim, q, _DRAWS * count, rng)
    _, error = reach(space.robot, aim, draws, bounds, steps=0)
    seeds = draws[np.argsort(error, kind="stable")[:count]]
    if with_own:
        own = np.stack([q, q])
        own[1, -len(space.robot.home) :] = space.robot.home
        seeds = np.concatenate([np.clip(own, *bounds), seeds])
    found, error = reach(space.robot, aim, seeds, bounds)
    return found[error < TOLERANCE]


def reach(
    robot: RobotModel,
    aim: Aim,
    seeds: np.ndarray,
    bounds: tuple[np.ndarray, np.ndarray],
    steps: int = _STEPS,
) -> tuple[np.ndarray, np.ndarray]:
    """Solves the arm's inverse kinematics from many seeds; the base stays.

    Args:
        robot: The robot.
        aim: What the end effectors shall reach.
        seeds: Configurations to start from, shape (k, n_q) [rad, m].
        bounds: Lower and upper bounds of q, shape (n_q,) each [rad, m].
        steps: Largest number of steps from a seed.

    Returns:
        Where each seed has led to, shape (k, n_q), and how far that is from
        the target, angles weighed by 0.3 m, shape (k,) [m].
    """
    return reach_from(
        robot.chains,
        aim.arrays,
        robot.n_q - len(robot.home),
        *bounds,
        seeds,
        steps,
        0.01 * TOLERANCE,
    )


def _draws(
    space: FreeSpace,
    aim: Aim,
    q: np.ndarray,
    count: int,
    rng: np.random.Generator,
) -> np.ndarray:
    """Draws configurations all over the bounds, shape (count, n_q).

    Bases are drawn around the target, more or less turned towards it; where
    ways along it are free, around its place that is nearest to the hand.
    """
    robot = space.robot
    arm = slice(robot.n_q - len(robot.home), None)
    draws = np.tile(q, (count, 1))
    draws[:, arm] = rng.uniform(
        space.lower[arm], space.upper[arm], (count, len(robot.home))
    )
    if robot.n_base:
        p_WN = np.mean([_place(robot, q, *item) for item in aim.items], axis=0)
        away = rng.uniform(*_BASE_DISTANCE, count)
        bearing = rng.uniform(-math.pi, math.pi, count)
        draws[:, 0] = p_WN[0] - away * np.cos(bearing)
        draws[:, 1] = p_WN[1] - away * np.sin(bearing)
        draws[:, 2] = bearing + rng.uniform(-_BASE_TURN, _BASE_TURN, count)
    return draws


def _place(
    robot: RobotModel, q: np.ndarray, effector: int, target: Target
) -> np.ndarray:
    """Returns the place of a target that is nearest to the hand, (3,)."""
    if target.weights[3:].all():
        return target.X_WT[:3, 3]
    return target.nearest_pose(robot.end_effector_pose(q, effector))[:3, 3]


def _price(
    space: FreeSpace,
    aim: Aim,
    found: np.ndarray,
    room: np.ndarray,
    q: np.ndarray,
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
    singular = np.array([_singularity(robot, aim, x) for x in found])
    return far + 2.0 * cramped + at_limit + singular


def _singularity(robot: RobotModel, aim: Aim, q: np.ndarray) -> float:
    """Tells how near an arm is to a singularity, between 0 and 1."""
    state, most = robot.state(q), 0.0
    for effector, _ in aim.items:
        J = state.J_WE(effector)[:, robot.n_base :]
        m = math.sqrt(max(np.linalg.det(J @ J.T), 0.0)) if len(J.T) > 5 else 1.0
        most = max(most, math.exp(-m / 0.02))
    return most
