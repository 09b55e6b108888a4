"""`lost_load`: turns an object that has left the hand into an obstacle."""

import dataclasses as dc

import numpy as np
from pydrake.math import RigidTransform

from remosplat_drake.oracle.contact_rules import ContactRule
from remosplat_drake.robot.hand_links import hand_links
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.scene.objects.convex_hull import ConvexHull
from remosplat_drake.scene.objects.scene_object import SceneObject
from remosplat_drake.task.advance_task import with_held_object
from remosplat_drake.task.carrying import hull_pieces
from remosplat_drake.task.task import TaskState

_FLOOR = 0.0
"""Height of the floor in W [m]."""


def lost_load(robot: RobotModel, state: TaskState, q: np.ndarray) -> TaskState:
    """Returns the state of a task after its carried object has slipped out.

    The object's place is then unknown: the object may stick between the
    fingers, or stand or lie below. An obstacle therefore replaces the object:
    the space from its latest place in the hand down to the floor. The hand may
    touch this obstacle, so that it can move away. The map does not contain an
    object that rolls farther away.

    Args:
        robot: The robot, without a payload.
        state: The state of the task, with a carried object.
        q: The configuration, shape (n_q,) [rad, m].
    """
    state = with_held_object(state, robot.end_effector_poses(q))
    name = state.held
    objects = tuple(
        _column(each) if each.name == name else each for each in state.objects
    )
    links = hand_links(robot, state.holder)
    return dc.replace(
        state.emptied,
        objects=objects,
        rules=(ContactRule(name, links),),
        lost=state.lost | {name},
    )


def _column(thing: SceneObject) -> SceneObject:
    """The space between an object and the floor below it."""
    vertices = np.concatenate(hull_pieces(thing.solid))
    above = thing.X_WO.multiply(vertices.T).T
    below = above - [0.0, 0.0, max(above[:, 2].min() - _FLOOR, 0.0)]
    middle = above.mean(axis=0)
    corners = np.concatenate([above, below]) - middle
    hull = ConvexHull(RigidTransform(middle), corners, thing.name)
    return dc.replace(thing, solid=hull)
