"""`find_reach`: finds a configuration of the robot that reaches a target."""

import dataclasses as dc

import numpy as np

from remosplat_drake.controller.planning.goal_configurations import (
    GoalConfigurations,
    goal_configurations,
)
from remosplat_drake.controller.planning.motion_planner import MotionPlanner
from remosplat_drake.signals.aim import Aim
from remosplat_drake.signals.distance_field import DistanceField
from remosplat_drake.signals.target import Target
from remosplat_drake.signals.thing import UNSEEN

REACHABLE = "reachable"
"""Verdict: a configuration reaches the target and keeps all distances."""
BLOCKED = "blocked"
"""Verdict: configurations reach the target, but all of them are too near to
obstacles."""
UNSEEN_THERE = "unseen"
"""Verdict: the best configuration at the target is too near to unseen space."""
OUT_OF_REACH = "out of reach"
"""Verdict: no configuration was found that reaches the target."""

_SEEDS = 150
"""Number of initial guesses of the inverse kinematics. All of them together
take some milliseconds."""


@dc.dataclass(frozen=True, eq=False)
class Reach:
    """Result of a search for a configuration that reaches a target.

    Attributes:
        verdict: REACHABLE, BLOCKED, UNSEEN_THERE or OUT_OF_REACH.
        text: A sentence that states the verdict and the obstacle's name.
        q: The best configuration at the target, shape (n_q,); None if none
            was found.
        p_W: Point of the obstacle, shape (3,) [m]; None without an obstacle.
    """

    verdict: str
    text: str
    q: np.ndarray | None = None
    p_W: np.ndarray | None = None


def find_reach(
    planner: MotionPlanner,
    field: DistanceField,
    stopping: float,
    q: np.ndarray,
    aim: Aim | Target,
) -> Reach:
    """Searches for a configuration that reaches a target; deterministic.

    A path to this configuration may not exist; see `is_within_reach`.

    Args:
        planner: The planner, which contains the robot and its self-distances.
        field: The map.
        stopping: Distance that the robot keeps from the scene [m].
        q: The robot's present configuration, shape (n_q,) [rad, m].
        aim: The targets of the end effectors; a single `Target` is for the
            first end effector.
    """
    space = planner.free_space(q, field, stopping)
    goals = goal_configurations(
        space,
        aim,
        np.clip(q, space.lower, space.upper),
        seeds=_SEEDS,
        most=1,
        rng=np.random.default_rng(1),
    )
    if len(goals.q):
        return Reach(
            REACHABLE,
            "the robot reaches the target in the posture of the ghost",
            goals.q[0],
        )
    if goals.cramped is None:
        return Reach(
            OUT_OF_REACH,
            "no posture that reaches the target was found; move the base or "
            "the target",
        )
    return _blocked(planner, field, stopping, goals, goals.cramped)


def is_within_reach(
    planner: MotionPlanner,
    field: DistanceField,
    stopping: float,
    q: np.ndarray,
    aim: Aim | Target,
) -> bool:
    """Returns whether the planner finds a path to a target.

    Args:
        planner: The planner, which contains the robot and its self-distances.
        field: The map.
        stopping: Distance that the robot keeps from the scene [m].
        q: The robot's present configuration, shape (n_q,) [rad, m].
        aim: The targets of the end effectors; a single `Target` is for the
            first end effector.
    """
    if find_reach(planner, field, stopping, q, aim).verdict != REACHABLE:
        return False
    return planner.plan(q, aim, field, stopping).path is not None


def _blocked(
    planner: MotionPlanner,
    field: DistanceField,
    stopping: float,
    goals: GoalConfigurations,
    q: np.ndarray,
) -> Reach:
    """Names the obstacle of a configuration at the target."""
    if not goals.missing:
        return Reach(BLOCKED, "the robot would be too near to itself", q)
    name = planner.robot.spheres.links[goals.tightest]
    link = planner.robot.description.called(name)
    sphere = planner.robot.spheres_at(q).select(np.array([goals.tightest]))
    near = field.clearances(sphere, stopping)
    if not len(near):
        return Reach(BLOCKED, f"{link} is too near to an obstacle", q)
    p_W = near.p_WC[near.distance.argmin()]
    thing = field.thing_at(p_W)
    verdict = UNSEEN_THERE if thing.kind == UNSEEN else BLOCKED
    lack = f"{1e3 * goals.missing:.0f} mm"
    text = f"{link} would be {lack} too near to {thing.name}"
    return Reach(verdict, text, q, p_W)
