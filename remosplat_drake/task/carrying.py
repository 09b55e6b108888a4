"""Makes the payload of a carried object: mass, shape and holding links."""

import numpy as np

from remosplat_drake.robot.fitting.link_spheres import LinkSpheres
from remosplat_drake.robot.hand_links import hand_links
from remosplat_drake.robot.payload import Payload
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.robot.self_collision.shapes import convex_core
from remosplat_drake.scene.objects.drake_shapes import (
    drake_shape,
    object_inertia,
)
from remosplat_drake.scene.objects.scene_object import SceneObject, Solid


def hull_pieces(solid: Solid) -> tuple[np.ndarray, ...]:
    """Returns the vertices of convex pieces that enclose a solid, in its frame.

    Args:
        solid: The solid.
    """
    core = convex_core(drake_shape(solid))
    assert core is not None
    return (core.vertices,)


def make_payload(
    robot: RobotModel,
    thing: SceneObject,
    spheres: LinkSpheres,
    q: np.ndarray,
    effector: int = 0,
) -> Payload:
    """Makes the payload of an object at its present pose in the hand.

    Args:
        robot: The robot, without a payload.
        thing: The object.
        spheres: Spheres around the object, from `object_spheres.fit_object`.
        q: The configuration at which the hand takes the object, shape (n_q,).
        effector: Index of the end effector that takes the object.
    """
    body = int(robot.arrays.values.body_E[effector])
    X_WL, X_WO = robot.body_poses(q)[body], thing.X_WO.GetAsMatrix4()
    mass, inertia = thing.mass or 0.0, object_inertia(thing)
    p_OOcm = inertia.get_com()
    unit = inertia.Shift(p_OOcm).get_unit_inertia().CopyToFullMatrix3()
    return Payload(
        name=thing.name,
        link=robot.tree.names[body],
        X_LO=np.linalg.solve(X_WL, X_WO),
        spheres=spheres,
        pieces=hull_pieces(thing.solid),
        mass=mass,
        p_OOcm=p_OOcm,
        I_OOcm=mass * unit,
        holders=hand_links(robot, effector),
    )
