"""Makes payloads of objects: their links, pieces and masses."""

import numpy as np
import scipy

from remosplat_drake.robot import kinematics as kin
from remosplat_drake.robot.fitting.link_spheres import LinkSpheres
from remosplat_drake.robot.payload import Payload
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.scene.objects.scene_object import SceneObject, Solid
from remosplat_drake.scene.primitive_scene import Box, Cylinder

_SIDES = 32
"""Sides of the prism around a cylinder, which is 0.5 % wider."""


def hull_pieces(solid: Solid) -> tuple[np.ndarray, ...]:
    """Returns the vertices of convex pieces around a solid, in its frame.

    Args:
        solid: The solid.
    """
    if isinstance(solid, Box):
        signs = np.array(list(np.ndindex(2, 2, 2))) * 2.0 - 1.0
        return (signs * solid.half_extents,)
    if isinstance(solid, Cylinder):
        angle = 2.0 * np.pi * np.arange(_SIDES) / _SIDES
        radius = solid.radius / np.cos(np.pi / _SIDES)
        rim = radius * np.column_stack([np.cos(angle), np.sin(angle)])
        ends = (-solid.half_height, solid.half_height)
        return (np.vstack([np.insert(rim, 2, z, axis=1) for z in ends]),)
    return (solid.vertices,)


def make_payload(
    robot: RobotModel,
    thing: SceneObject,
    spheres: LinkSpheres,
    q: np.ndarray,
    effector: int = 0,
) -> Payload:
    """Makes a payload of an object, where it is now relative to the hand.

    Args:
        robot: The robot, without a payload.
        thing: The object.
        spheres: Spheres around it, as `object_spheres.fit_object` fits them.
        q: The configuration in which the hand takes it, shape (n_q,).
        effector: Index of the end effector that takes it.
    """
    body = int(robot.arrays.values.body_E[effector])
    X_WL, X_WO = robot.body_poses(q)[body], thing.X_WO.GetAsMatrix4()
    mass = thing.mass or 0.0
    center, inertia = _unit_inertia(thing.solid)
    return Payload(
        name=thing.name,
        link=robot.tree.names[body],
        X_LO=np.linalg.solve(X_WL, X_WO),
        spheres=spheres,
        pieces=hull_pieces(thing.solid),
        mass=mass,
        p_OOcm=center,
        I_OOcm=mass * inertia,
        holders=hand_links(robot, effector),
    )


def hand_links(robot: RobotModel, effector: int = 0) -> frozenset[str]:
    """Returns the names of the links of a hand: its fingers and its palm.

    Fingers are the bodies at joints that no command moves, beyond the last
    joint of the arm. A robot without any touches with the link of its end
    effector.

    Args:
        robot: The robot.
        effector: Index of the end effector.
    """
    tree = robot.tree
    end = int(robot.arrays.values.body_E[effector])
    moved = [b for b in tree.chain(end) if tree.position[b] >= 0]
    fingers = [
        body
        for body in range(len(tree.names))
        if tree.kind[body] != kin.FIXED
        and tree.position[body] < 0
        and moved[-1] in tree.chain(body)
    ]
    links = {*fingers, *(int(tree.parent[body]) for body in fingers)} or {end}
    return frozenset(tree.names[body] for body in links)


def _unit_inertia(solid: Solid) -> tuple[np.ndarray, np.ndarray]:
    """Centre of mass in O [m], and inertia about it per mass [m^2]."""
    if isinstance(solid, Cylinder):
        r2, h2 = solid.radius**2, (2.0 * solid.half_height) ** 2
        across = (3.0 * r2 + h2) / 12.0
        return np.zeros(3), np.diag([across, across, r2 / 2.0])
    if isinstance(solid, Box):
        center, sides = np.zeros(3), 2.0 * solid.half_extents
    else:
        # Of equal mass at every corner: no more than a box around them.
        hull = scipy.spatial.ConvexHull(solid.vertices)
        center = solid.vertices[hull.vertices].mean(axis=0)
        sides = np.ptp(solid.vertices, axis=0)
    squares = sides**2
    return center, np.diag(squares.sum() - squares) / 12.0
