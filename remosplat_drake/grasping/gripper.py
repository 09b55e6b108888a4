"""`ParallelGripper`: geometry and force of a robot's two-finger hand."""

import dataclasses as dc
from functools import cached_property
from typing import NamedTuple

import numpy as np
import scipy
from pydrake.multibody.plant import MultibodyPlant

from remosplat_drake.base.directions import spread_directions
from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.robot.inverse_dynamics import motors
from remosplat_drake.robot.kinematics import PRISMATIC
from remosplat_drake.robot.model_file import add_robot_model
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.robot.self_collision.shapes import (
    ConvexShape,
    read_collision_shapes,
)

GRAVITY = 9.81
"""Acceleration of free fall [m/s^2]."""

PATCH = 0.005
"""Radius of the patch on which a soft pad presses [m]. It is small, since
objects are round or have edges."""

_FLAT = 0.001
"""Vertices of a finger belong to its pad if they are nearer than this to the
pad's plane [m]."""

_DIRECTIONS = 60  # Of the polyhedron around a rounded shape, 6 % larger.


class HandPieces(NamedTuple):
    """The s convex pieces of a hand, as half spaces in E.

    Attributes:
        planes: Planes (a, b) with unit normals a, shape (h, 4): the points x of
            a piece have a'x + b <= 0 for all of its planes.
        first: Row of the first plane of each piece, and the number of planes,
            shape (s + 1,).
        box: Lower and upper corner of the box around all pieces, shape (2, 3)
            [m].
    """

    planes: np.ndarray
    first: np.ndarray
    box: np.ndarray


@dc.dataclass(frozen=True, eq=False)
class ParallelGripper:
    """Two fingers that close along one axis of the end effector's frame E.

    Attributes:
        robot: The robot.
        close_E: Unit vector from one finger to the other, in E, shape (3,).
        approach_E: Unit vector from the hand to its fingertips, in E, (3,).
        max_width: Greatest opening [m].
        max_force: Greatest force of a finger [N]; infinite if unknown.
    """

    robot: RobotModel
    close_E: np.ndarray
    approach_E: np.ndarray
    max_width: float
    max_force: float

    @staticmethod
    def of(robot: RobotModel) -> "ParallelGripper":
        """Derives the gripper from a robot's model.

        Args:
            robot: A robot with a hand.

        Raises:
            RemoSplatError: The robot has no hand with two sliding fingers.
        """
        robot, hand = robot.as_described, robot.description.hand
        if hand is None or len(hand.joints) != 2:
            raise RemoSplatError(
                "grasps need a hand of two fingers; add it to the description"
                " of the robot"
            )
        plant = MultibodyPlant(0.0)
        add_robot_model(robot.description, plant)
        plant.Finalize()
        joints = [plant.GetJointByName(name) for name in hand.joints]
        tree = robot.tree
        fingers = [tree.index(j.child_body().name()) for j in joints]
        if any(tree.kind[finger] != PRISMATIC for finger in fingers):
            raise RemoSplatError(
                "grasps need fingers that slide; fingers that rotate are not"
                " supported"
            )
        X_WL, X_WE = robot.body_poses(robot.q_home), _tool(robot)
        first = fingers[0]
        X_WF = X_WL[tree.parent[first]] @ tree.X_PF[first]
        close_E = X_WE[:3, :3].T @ X_WF[:3, :3] @ tree.axis_F[first]
        p_WF = np.mean(
            [(X_WL[tree.parent[f]] @ tree.X_PF[f])[:3, 3] for f in fingers],
            axis=0,
        )
        reach = X_WE[:3, :3].T @ (X_WE[:3, 3] - p_WF)
        reach -= (reach @ close_E) * close_E
        if not np.linalg.norm(reach) > 1e-6:
            raise RemoSplatError(
                "the end effector's frame is not between the fingertips; name "
                "a frame between them in the robot description"
            )
        efforts = motors(plant)
        return ParallelGripper(
            robot,
            close_E,
            reach / np.linalg.norm(reach),
            float(sum(j.position_upper_limits()[0] for j in joints)),
            min(float(efforts[name].effort_limit()) for name in hand.joints)
            if set(hand.joints) <= set(efforts)
            else np.inf,
        )

    def pieces(self, width: float) -> HandPieces:
        """Returns the hand's convex pieces at a width.

        Args:
            width: Opening of the fingers [m].
        """
        robot = self.robot.with_hand_width(width)
        X_WL = robot.body_poses(robot.q_home)
        X_EW = np.linalg.inv(_tool(robot))
        found, corners = [], []
        for link, points, equations in self._pieces_L:
            X_EL = X_EW @ X_WL[link]
            a_E = equations[:, :3] @ X_EL[:3, :3].T
            b = equations[:, 3] - a_E @ X_EL[:3, 3]
            found.append(np.column_stack([a_E, b]))
            corners.append(points @ X_EL[:3, :3].T + X_EL[:3, 3])
        first, p_E = np.cumsum([0, *map(len, found)]), np.concatenate(corners)
        box = np.array([p_E.min(axis=0), p_E.max(axis=0)])
        return HandPieces(np.concatenate(found), first, box)

    @cached_property
    def _pieces_L(self) -> list[tuple[int, np.ndarray, np.ndarray]]:
        """The body, vertices and half spaces of each piece of the hand."""
        tree, hand = self.robot.tree, self.robot.description.hand
        assert hand is not None
        palm = int(tree.parent[self.robot.fingers[0]])
        shapes = read_collision_shapes(
            self.robot.description, self.robot.spheres
        )
        found = []
        for name, shape in zip(shapes.links, shapes.shapes, strict=True):
            body = tree.index(name)
            if palm in tree.chain(body):
                points = _vertices(shape)
                planes = scipy.spatial.ConvexHull(points).equations
                found.append((body, points, planes))
        return found

    @cached_property
    def pad(self) -> tuple[np.ndarray, np.ndarray]:
        """Rectangle in which the fingers meet: its lower and upper corner.

        The corners are in (approach_E, side_E), where side_E = close_E x
        approach_E, relative to the end effector, shape (2,) each [m].
        """
        tree, first = self.robot.tree, int(self.robot.fingers[0])
        robot = self.robot.with_hand_width(0.0)
        X_EW = np.linalg.inv(_tool(robot))
        X_EL = X_EW @ robot.body_poses(robot.q_home)
        p_E = np.concatenate(
            [
                points @ X_EL[link, :3, :3].T + X_EL[link, :3, 3]
                for link, points, _ in self._pieces_L
                if first in tree.chain(link)
            ]
        )
        across = p_E @ self.close_E
        inner = across - across[np.abs(across).argmin()]
        met = p_E[np.abs(inner) < _FLAT]
        plane = met @ np.column_stack([self.approach_E, self.side_E])
        return plane.min(axis=0), plane.max(axis=0)

    @property
    def side_E(self) -> np.ndarray:
        """Unit vector along the pads, normal to closing and approach, (3,)."""
        return np.cross(self.close_E, self.approach_E)

    def force(
        self,
        mass: float,
        friction: float,
        lever: float = 0.0,
        factor: float = 2.5,
    ) -> float:
        """Returns the force with which each finger must press [N].

        Two fingers carry the weight by friction. If the centre of mass is
        beside the closing axis, they also prevent the object from rotating
        about it: force and torque of a soft finger lie in an ellipsoid (Howe
        and Cutkosky, "Practical force-motion models for sliding manipulation",
        IJRR 1996). A safety factor covers accelerations and a lower friction
        than assumed.

        Args:
            mass: Mass of the object [kg].
            friction: Coefficient of friction.
            lever: Distance of the object's centre of mass from the closing axis
                [m].
            factor: Safety factor on the weight.

        Raises:
            RemoSplatError: The hand is too weak.
        """
        # This is the friction torque of a round patch under uniform pressure.
        turning = lever / (2.0 / 3.0 * PATCH)
        needed = factor * mass * GRAVITY / (2.0 * friction)
        needed *= float(np.hypot(1.0, turning))
        if needed > self.max_force:
            raise RemoSplatError(
                f"an object of {mass:g} kg needs a force of {needed:.0f} N from"
                f" each finger; the hand has at most {self.max_force:g} N"
            )
        return needed


def _tool(robot: RobotModel) -> np.ndarray:
    """Pose X_WE of the fingers' end effector at the home configuration."""
    effector = robot.effector_that_moves(int(robot.fingers[0]))
    return robot.end_effector_pose(robot.q_home, effector or 0)


def _vertices(shape: ConvexShape) -> np.ndarray:
    points = shape.vertices
    if shape.radius:
        around = 1.06 * shape.radius * spread_directions(_DIRECTIONS)
        points = (points[:, None] + around).reshape(-1, 3)
    return points
