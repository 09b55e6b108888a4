"""Searches goal configurations, which reach the target and are free."""

import dataclasses as dc
import math

import numpy as np

from remosplat_drake.base.kernels.packed import Packed
from remosplat_drake.controller.planning.free_space import FreeSpace
from remosplat_drake.controller.planning.kernels.goal_costs import goal_costs
from remosplat_drake.controller.planning.kernels.inverse_kinematics import Arms
from remosplat_drake.controller.planning.kernels.reaching import reaching
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.signals.aim import Aim
from remosplat_drake.signals.target import Target

_ROUND = 20, 100
"""Numbers of groups of random configurations: in the first round, and in each
later round. The search ends as soon as it has found enough configurations."""

_COMPARED = 100
"""If no configuration keeps all distances, at most this many configurations are
compared, and the best of them is reported."""

_GROUP = 4
"""Number of random configurations in a group. The one that is nearest to the
target is a seed of inverse kinematics."""

_PATIENCE = 4
"""For each requested seed, at most this many groups are drawn. Several groups
are needed, since most random poses of a base collide."""

_BASE_DISTANCE = (0.35, 0.95)
"""Least and greatest distance of random base positions from the target [m]."""

_BASE_TURN = 0.8
"""A random base heading differs from the direction to the target by at most
this angle [rad]."""


@dc.dataclass(frozen=True, eq=False)
class GoalConfigurations:
    """The result of a search for goal configurations.

    Attributes:
        q: Goal configurations that keep all distances, the best first, shape
            (k, n_q) [rad, m].
        seeds: Number of seeds that were tried.
        reached: Number of seeds from which inverse kinematics reached the
            target.
        tightest: Index of the sphere whose clearance in `cramped` is farthest
            below the required clearance; -1 if `cramped` is None.
        missing: Amount by which this sphere's clearance is too small [m].
        cramped: If no goal configuration was found, the best configuration that
            reaches the target but does not keep all distances, shape (n_q,)
            [rad, m]; None if there is none.
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
    """Searches configurations that reach a target and keep all distances.

    If the aim contains a configuration, only this configuration is checked. Its
    base yaw is shifted by whole turns, such that it is nearest to the present
    yaw.

    Args:
        space: The free space.
        aim: The targets of the end effectors, as an `Aim`. A `Target` or a pose
            X_WT of shape (4, 4) is also accepted; it is the target of the first
            end effector.
        q: Present configuration, shape (n_q,) [rad, m]. Goals near it are
            preferred.
        seeds: Number of configurations from which inverse kinematics starts.
        most: At most this many goal configurations are returned.
        rng: Random number generator of the seeds.
    """
    aim = Aim.of(aim)
    if aim.q is not None:
        return _named(space, aim.q, q)
    arms = arms_of(space, aim)
    found, is_open, tried = np.empty((0, len(q))), np.empty(0, bool), 0
    left, (round_size, later) = _PATIENCE * seeds, _ROUND
    while tried < seeds and left > 0 and is_open.sum() < most:
        count, round_size = min(round_size, left, seeds), later
        draws = _draws(space, aim, q, count * _GROUP, rng)
        groups = draws.reshape(count, _GROUP, len(q))
        if not tried:
            groups = np.concatenate([_own_groups(space, q), groups])
        missing = most - int(is_open.sum())
        more, more_open, more_tried = _reaching(space, arms, groups, missing)
        found = np.concatenate([found, more])
        is_open = np.concatenate([is_open, more_open])
        tried, left = tried + more_tried, left - count
    if is_open.any():
        best = found[is_open]
        with space.calls() as line:
            costs = goal_costs(space.arrays, line, arms, best, q)
        order = np.argsort(costs, kind="stable")
        return GoalConfigurations(best[order], tried, len(found))
    return _cramped(space, found, tried)


def _own_groups(space: FreeSpace, q: np.ndarray) -> np.ndarray:
    """Returns a group with the present posture, and one with the arms' home."""
    own = np.stack([q, q])
    own[1, -len(space.robot.home) :] = space.robot.home
    own = np.clip(own, space.lower, space.upper)
    return np.repeat(own[:, None], _GROUP, axis=1)


def _named(
    space: FreeSpace, wanted: np.ndarray, q: np.ndarray
) -> GoalConfigurations:
    """Returns the result for an aim that contains a configuration."""
    goal = np.clip(wanted, space.lower, space.upper)
    if space.robot.n_base:
        goal[2] += math.tau * round((q[2] - goal[2]) / math.tau)
    if space.is_free(goal):
        return GoalConfigurations(goal[None], 1, 1)
    return _cramped(space, goal[None], 1)


def _cramped(
    space: FreeSpace, found: np.ndarray, tried: int
) -> GoalConfigurations:
    """Returns the result if no configuration found keeps all distances."""
    if not len(found):
        return GoalConfigurations(found, tried, 0)
    reached, found = len(found), found[:_COMPARED]
    margins = space.margins(found, 0.0)
    best = int(np.argmax(margins.min(axis=1)))
    sphere = int(np.argmin(margins[best]))
    missing = max(-float(margins[best, sphere]), 0.0)
    return GoalConfigurations(
        found[:0], tried, reached, sphere, missing, found[best]
    )


def arms_of(space: FreeSpace, aim: Aim) -> Packed[Arms]:
    """Returns a robot's arms, packed for inverse kinematics.

    Args:
        space: The free space, whose bounds the joints keep.
        aim: The targets of the end effectors.
    """
    chains, bounds = space.robot.chain_arrays, (space.lower, space.upper)
    first = space.robot.n_q - len(space.robot.home)
    return Packed(Arms(chains, aim.arrays, first, *bounds))


def _reaching(
    space: FreeSpace, arms: Packed[Arms], draws: np.ndarray, most: int
) -> tuple[np.ndarray, np.ndarray, int]:
    """Calls `reaching`, and counts its configurations as checks."""
    with space.calls() as line:
        found, is_open, seeds = reaching(space.arrays, line, arms, draws, most)
    space.checks += len(found)
    return found, is_open, seeds


def _draws(
    space: FreeSpace,
    aim: Aim,
    q: np.ndarray,
    count: int,
    rng: np.random.Generator,
) -> np.ndarray:
    """Draws configurations uniformly within the bounds, shape (count, n_q).

    Base poses are drawn around the target, with a heading roughly towards it.
    If the target has free translations, they are drawn around the point of the
    target that is nearest to the hand.
    """
    robot = space.robot
    arm = slice(robot.n_q - len(robot.home), None)
    draws = np.empty((count, len(q)))
    draws[:] = q
    lower, span = space.lower[arm], space.upper[arm] - space.lower[arm]
    draws[:, arm] = lower + span * rng.random((count, len(robot.home)))
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
    """Returns the point of a target that is nearest to the hand, (3,) [m]."""
    if target.weights[3:].all():
        return target.X_WT[:3, 3]
    return target.nearest_pose(robot.end_effector_pose(q, effector))[:3, 3]
