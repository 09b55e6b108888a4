"""Compares stated causes with the truth."""

import math

import numpy as np

from apps.studies.causes.faults import LASTS
from apps.studies.causes.situations import (
    BASE,
    LOST,
    NO_PATH,
    STOP,
    Situation,
    is_reachable,
)
from remosplat_drake.app.stages.movers import tracks_of
from remosplat_drake.oracle.signed_distance import SignedDistanceField
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.scene.moving.track import movers_at
from remosplat_drake.signals import motion_status as states
from remosplat_drake.signals import thing as things
from remosplat_drake.signals.binding import JOINT_LIMIT, MOVER, SELF_COLLISION
from remosplat_drake.signals.distance_field import DistanceField
from remosplat_drake.signals.motion_status import MotionStatus
from remosplat_drake.signals.near_movers import NearMovers
from remosplat_drake.signals.thing import UNSEEN_SPACE

SLACK = 0.01
"""A constraint counts as active if a distance exceeds its stopping distance by
at most this [m]."""

_BRAKING = 0.1
"""The verification of stopping paths can stop a link whose distance exceeds the
stopping distance by at most this [m]."""

_ANGLE = 0.05
"""A joint limit counts as active if the joint's angle from it exceeds the
stopping angle by less than this [rad]."""

_MOVERS_REACH = 0.5
"""A mover can limit the robot's speed only if it is nearer than this [m]."""


def is_true(
    status: MotionStatus,
    situation: Situation,
    time: float,
    q: np.ndarray,
) -> bool:
    """Returns whether the stated cause truly keeps the robot from its target.

    An object stops a link if their true distance is the link's stopping
    distance.

    Args:
        status: The state.
        situation: The run.
        time: Time of the state [s].
        q: Configuration at that time, shape (n_q,) [m, rad].
    """
    cause, world, law = status.cause, situation.world, situation.law
    stopping = law.collision.stopping
    if cause == states.VERIFICATION and status.thing == UNSEEN_SPACE.name:
        cause = things.UNSEEN
    if cause in (things.SOLID, things.FLOOR, things.MAP, states.VERIFICATION):
        if world.truth is None:
            return False
        truth = SignedDistanceField(world.truth)
        room = _BRAKING if cause == states.VERIFICATION else SLACK
        return _distance(world.robot, q, status.link, truth) < stopping + room
    if cause == things.UNSEEN:
        if world.seen is None:
            return False
        gap = _distance(world.robot, q, status.link, world.seen.field)
        return gap < stopping + SLACK
    if cause == SELF_COLLISION:
        own = law.self_clearance
        return own is not None and (
            _own_distance(own, q, status.link) < own.stopping + SLACK
        )
    if cause == JOINT_LIMIT:
        return is_at_limit(situation, q, status.link)
    if cause == MOVER:
        return _is_near(situation, time, q, status.thing)
    if cause == states.NO_CONFIGURATION:
        return not is_reachable(situation, situation.X_WT)
    if cause == states.NO_PATH:
        return situation.kind == NO_PATH
    return _is_of_the_run(cause, situation, time)


def _is_of_the_run(cause: str, situation: Situation, time: float) -> bool:
    """Whether a cause is the one with which the run was drawn."""
    begin, kind = situation.fault_at, situation.kind
    is_on = begin <= time < begin + LASTS + 2.0
    if cause == states.BASE:
        return kind == BASE and (is_on or not situation.drives)
    of_kinds = {states.SUPERVISOR: STOP, states.LOCALIZATION: LOST}
    return is_on and of_kinds.get(cause) == kind


def _distance(
    robot: RobotModel, q: np.ndarray, link: str, field: DistanceField
) -> float:
    """Distance from a link to the surfaces of a field [m]."""
    spheres = robot.spheres_at(q)
    spheres = spheres.select(np.flatnonzero(robot.spheres.on_links({link})))
    return field.clearances(spheres, 1.0).minimum()


def _own_distance(own, q: np.ndarray, link: str) -> float:
    """Least distance of a link's shapes from other links [m]."""
    distance = own.distances(q)
    of_link = [link in own.pairs.links(i) for i in range(len(distance))]
    return float(distance[of_link].min(initial=math.inf))


def is_at_limit(situation: Situation, q: np.ndarray, link: str) -> bool:
    """Returns whether the joint that moves a link is at its limit.

    Args:
        situation: The run.
        q: Configuration, shape (n_q,) [m, rad].
        link: Name of the link.
    """
    robot, config = situation.world.robot, situation.scenario.controller
    k = int(robot.tree.position[robot.tree.index(link)])
    room = min(q[k] - robot.position_lower[k], robot.position_upper[k] - q[k])
    return k >= 0 and room < math.radians(config.joint_limits.stop) + _ANGLE


def _is_near(
    situation: Situation, time: float, q: np.ndarray, name: str
) -> bool:
    """Whether a mover is near the robot."""
    movers = movers_at(tracks_of(situation.scenario), time)
    spheres = situation.world.robot.spheres_at(q)
    near = NearMovers.find(movers, time, spheres, _MOVERS_REACH)
    return name in {movers.movers[i].name for i in near.mover}
