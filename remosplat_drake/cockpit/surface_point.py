"""Finds the surface point that an operator clicks, and a target there."""

import dataclasses as dc
from collections.abc import Sequence

import numpy as np

from remosplat_drake.oracle.object_field import ObjectField
from remosplat_drake.robot.sphere_model import Spheres
from remosplat_drake.scene.objects.scene_object import SceneObject
from remosplat_drake.signals.distance_field import DistanceField

FARTHEST = 20.0
"""A surface is found only if it is within this distance along the ray [m]."""

_CLOSE = 1e-3
"""The ray has reached a surface if the surface is nearer than this [m]."""

_STEPS = 200
"""A ray is followed for at most this many steps. A ray that is almost parallel
to a surface takes many steps."""

_BEHIND = 0.02
"""A click hits an object if the object's surface is at most this far behind the
map's surface [m]. The map's surface may be in front of it because of the map's
errors."""

_SAFE = 0.98
"""Length of a step along the ray, as a fraction of the distance to the nearest
surface. It is less than 1 because of rounding errors."""


@dc.dataclass(frozen=True, eq=False)
class SurfacePoint:
    """A point of a surface.

    Attributes:
        p_W: The point in W, shape (3,) [m].
        normal_W: Unit normal, from the surface towards the viewer, shape (3,).
    """

    p_W: np.ndarray
    normal_W: np.ndarray


def find_surface(
    field: DistanceField, p_W: np.ndarray, direction_W: np.ndarray
) -> SurfacePoint | None:
    """Follows a ray to the first surface that it meets.

    Each step along the ray is as long as the distance to the nearest surface,
    so the ray cannot pass through a surface (Hart, "Sphere tracing", 1996).

    Args:
        field: The map, whose distances are 1-Lipschitz.
        p_W: Start of the ray in W, shape (3,) [m].
        direction_W: Direction of the ray in W, shape (3,), of any length.

    Returns:
        The point; None if there is no surface within `FARTHEST`, or if the
        ray has no direction.
    """
    length = float(np.linalg.norm(direction_W))
    if not (np.isfinite(p_W).all() and np.isfinite(length) and length > 0):
        return None
    along = np.asarray(direction_W, float) / length
    p_W, way = np.array(p_W, float), 0.0
    for _ in range(_STEPS):
        found = field.clearances(Spheres.at(p_W), FARTHEST)
        if not len(found):
            return None
        row = int(found.distance.argmin())
        distance = float(found.distance[row])
        if distance < _CLOSE:
            normal = -found.direction_W[row]
            if normal @ along > 0:
                normal = -normal
            return SurfacePoint(found.p_WC[row].copy(), normal)
        way += _SAFE * distance
        if way > FARTHEST:
            return None
        p_W = p_W + _SAFE * distance * along
    return None


def clicked_object(
    field: DistanceField,
    objects: Sequence[SceneObject],
    p_W: np.ndarray,
    direction_W: np.ndarray,
) -> tuple[str, np.ndarray] | None:
    """Returns the object that a ray meets first, and the point on it.

    Args:
        field: The map.
        objects: The objects at their present poses.
        p_W: Start of the ray in W, shape (3,) [m].
        direction_W: Direction of the ray in W, shape (3,), of any length.

    Returns:
        Name of the object and the point, shape (3,) [m]; None if the ray meets
        no object, or meets the map before an object.
    """
    found = find_surface(ObjectField(objects), p_W, direction_W)
    if found is None:
        return None
    distances = {
        each.name: abs(
            ObjectField([each]).clearances(Spheres.at(found.p_W)).minimum()
        )
        for each in objects
    }
    ahead = None
    if field.surfaces is not None:
        ahead = find_surface(field.surfaces, p_W, direction_W)
    if ahead is not None:
        way, way_ahead = (
            float(np.linalg.norm(p - p_W)) for p in (found.p_W, ahead.p_W)
        )
        if way_ahead < way - _BEHIND:
            return None
    return min(distances, key=distances.__getitem__), found.p_W


def target_before(
    surface: SurfacePoint, X_WE: np.ndarray, standoff: float
) -> np.ndarray:
    """Returns a target whose z axis points at a surface, along its normal.

    Args:
        surface: A point of the surface.
        X_WE: Pose of the end effector, whose z axis points forward, shape (4,
            4). The target's x axis is this pose's x axis, projected onto the
            surface.
        standoff: Distance of the target from the surface [m].

    Returns:
        The pose X_WT, shape (4, 4).
    """
    z_W = -surface.normal_W
    x_W = X_WE[:3, 0] - (X_WE[:3, 0] @ z_W) * z_W
    if np.linalg.norm(x_W) < 1e-3:
        x_W = X_WE[:3, 1] - (X_WE[:3, 1] @ z_W) * z_W
    x_W /= np.linalg.norm(x_W)
    X_WT = np.eye(4)
    X_WT[:3, :3] = np.stack([x_W, np.cross(z_W, x_W), z_W], axis=1)
    X_WT[:3, 3] = surface.p_W + standoff * surface.normal_W
    return X_WT
