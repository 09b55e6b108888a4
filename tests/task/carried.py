"""A can, a board and a block, and a robot that may carry the can."""

import numpy as np
from pydrake.math import RigidTransform

from remosplat_drake.robot.fitting.link_spheres import LinkSpheres
from remosplat_drake.robot.payload import Payload
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.scene.objects.scene_object import SceneObject
from remosplat_drake.scene.primitive_scene import Box, Cylinder
from remosplat_drake.task.carrying import make_payload

RADIUS, HALF_HEIGHT = 0.03, 0.06


def can_at(X_WO: np.ndarray | RigidTransform) -> SceneObject:
    """An upright can, or one with any pose."""
    pose = RigidTransform(X_WO)
    return SceneObject("can", Cylinder(pose, RADIUS, HALF_HEIGHT), 0.3)


def board(top: float) -> SceneObject:
    """A board whose upper side is at a height."""
    half = np.array([0.5, 0.5, 0.02])
    X_WO = RigidTransform([0.8, 0.0, top - 0.02])
    return SceneObject("board", Box(X_WO, half))


def around_can() -> LinkSpheres:
    """Three spheres in a row that enclose the can.

    Each covers a third of its height: its radius is that of the rim's circles
    around its centre.
    """
    step = 2.0 * HALF_HEIGHT / 3.0
    radius = np.hypot(RADIUS, step / 2.0)
    p_OS = np.array([[0.0, 0.0, k * step] for k in (-1, 0, 1)])
    return LinkSpheres(p_OS, np.full(3, radius))


def can_in_hand(robot: RobotModel, q: np.ndarray) -> Payload:
    """The can as a payload, its centre at the end effector."""
    can = can_at(robot.end_effector_pose(q))
    return make_payload(robot, can, around_can(), q)
