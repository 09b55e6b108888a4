"""Finds the points of a map or of an image that are on a given object."""

import numpy as np

from remosplat_drake.oracle.object_field import ObjectField
from remosplat_drake.robot.sphere_model import Spheres
from remosplat_drake.scene.objects.scene_object import SceneObject


def own_points(
    p_W: np.ndarray, thing: SceneObject, margin: float, *, stands: bool = True
) -> np.ndarray:
    """Finds the points that are near the surface of an object.

    If the object stands on a support, points at its foot are excluded, since
    they may be on the support.

    Args:
        p_W: Points on surfaces in W, shape (n, 3) [m].
        thing: The object, at its present pose.
        margin: Points on the object are at most this far from its surface [m].
        stands: Whether the object stands on a support.

    Returns:
        Whether each point is on the object, shape (n,).
    """
    distance = ObjectField([thing]).clearances(Spheres.at(p_W)).distance
    own = np.abs(distance) <= margin
    if stands:
        corners = thing.corners
        rows = np.array(list(np.ndindex(2, 2, 2)))
        corners_W = thing.X_WO.multiply(
            np.array([corners[row, range(3)] for row in rows]).T
        )
        own &= p_W[:, 2] > corners_W[2].min() + margin
    return own
