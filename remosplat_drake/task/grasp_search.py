"""Finds grasps of an object that a robot can reach where it stands."""

import dataclasses as dc
from collections.abc import Callable

import numpy as np

from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.grasping.grasps import FRICTION, Grasp, plan_grasps
from remosplat_drake.grasping.gripper import ParallelGripper
from remosplat_drake.grasping.hand_spheres import HandSpheres
from remosplat_drake.grasping.surface import surface_of_solid
from remosplat_drake.scene.objects.drake_shapes import object_inertia
from remosplat_drake.scene.objects.scene_object import SceneObject
from remosplat_drake.signals.distance_field import DistanceField

ENOUGH = 3
"""The search ends when it has found this many grasps."""

_LOOKS = 25
"""Number of points of an object at which grasps are searched."""

_TESTED = 40
"""At most this many grasps are tested with the whole robot."""

_DOWN = np.array([0.0, 0.0, -1.0])

_SPACING, _ACROSS = 0.004, 60
"""Points on a small object have this spacing [m]. Across a large object, there
are this many points."""

Reaches = Callable[[np.ndarray], bool]
"""Function that returns whether the robot reaches a grasp, a pose X_OE of the
end effector, shape (4, 4)."""


@dc.dataclass(frozen=True, eq=False)
class FoundGrasp:
    """A grasp that the robot reaches, and the force of the hand.

    Attributes:
        grasp: The grasp.
        force: Force of each finger [N].
    """

    grasp: Grasp
    force: float


def find_grasps(
    thing: SceneObject,
    gripper: ParallelGripper,
    beside: DistanceField,
    stopping: float,
    p_WE: np.ndarray,
    reaches: Reaches,
) -> list[FoundGrasp]:
    """Finds grasps of an object, the best first.

    The function prefers grasps from above, and from the side on which the hand
    is.

    Args:
        thing: The object, with a known mass.
        gripper: The robot's hand.
        beside: The map without the object.
        stopping: Distance that the hand keeps from the map [m].
        p_WE: Position of the hand, shape (3,) [m].
        reaches: Function that returns whether the robot reaches a grasp.

    Returns:
        At least one grasp, and `ENOUGH` at most.

    Raises:
        RemoSplatError: There is no grasp, or the hand is too weak; the text
            states the reason.
    """
    X_WO, name = thing.X_WO.GetAsMatrix4(), thing.name
    way_W = X_WO[:3, 3] - p_WE
    way_W = way_W / max(float(np.linalg.norm(way_W)), 1e-6) + _DOWN
    way_O = X_WO[:3, :3].T @ way_W
    across = float(np.ptp(thing.corners, axis=0).max())
    grasps = plan_grasps(
        surface_of_solid(thing.solid, max(_SPACING, across / _ACROSS)),
        gripper,
        friction=FRICTION,
        approach_O=way_O / max(float(np.linalg.norm(way_O)), 1e-6),
        p_OOcm=object_inertia(thing).get_com(),
        most=_LOOKS,
        rng=np.random.default_rng(0),
    )
    if not grasps:
        raise RemoSplatError(
            f"the hand, which opens to {1e3 * gripper.max_width:.0f} mm, "
            f"cannot grasp the {name}"
        )
    hand = HandSpheres.of(gripper)
    grasps = [x for x in grasps if hand.keeps(beside, X_WO @ x.X_OE, stopping)]
    if not grasps:
        raise RemoSplatError(
            f"the {name} is too close to other objects: at no grasp the "
            f"hand's clearance is {1e3 * stopping:.0f} mm"
        )
    found: list[FoundGrasp] = []
    weak = ""
    for each in grasps[:_TESTED]:
        try:
            force = each.force(gripper, thing.mass or 0.0)
        except RemoSplatError as error:
            weak = weak or str(error)
            continue
        for grasp in (each, each.flipped(gripper)):
            if reaches(grasp.X_OE):
                found.append(FoundGrasp(grasp, force))
                break
        if len(found) == ENOUGH:
            return found
    if not found:
        raise RemoSplatError(
            weak
            or f"the robot cannot reach any grasp of the {name} without "
            "coming too near to itself or the scene"
        )
    return found
