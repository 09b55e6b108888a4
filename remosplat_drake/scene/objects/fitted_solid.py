"""`fit_solid`: fits an upright box, a cylinder or a hull around points."""

import math

import numpy as np
import scipy
from pydrake.math import RigidTransform, RollPitchYaw

from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.scene.objects.convex_hull import ConvexHull
from remosplat_drake.scene.objects.scene_object import Solid
from remosplat_drake.scene.primitive_scene import Box, Cylinder

_FILLED = 0.7
"""A box or a cylinder fits points if their convex hull fills at least this
share of its volume. A hull fills 0.79 of a ball's cylinder, and a third of a
cone's."""

_THINNEST = 0.005
"""A solid around points that show more than one side of an object is at least
this thick [m]."""

_MARGIN = 0.001
"""The solid exceeds the points by this [m]. The centre of a flat Gaussian on a
convex surface is slightly inside the object."""

_AROUND = _MARGIN * np.vstack([np.eye(3), -np.eye(3)[:2], np.zeros(3)])
"""Offsets from a point to points that the solid contains, too [m]."""

_FOOT = 0.02
"""Points at most this far above the lowest point show the object's foot [m]."""


def fit_solid(points: np.ndarray, bottom: float, name: str = "") -> Solid:
    """Fits the smallest solid around the points of an object that stands.

    The solid is an upright box or cylinder, whichever has the smaller volume.
    If the convex hull of the points fills less than `_FILLED` of it, the solid
    is this hull. The solid contains all points with a margin of `_MARGIN`, and
    reaches down to `bottom`.

    Args:
        points: Points of the object in W, shape (n, 3), n >= 1 [m].
        bottom: Height of the surface on which the object stands, below all
            points [m].
        name: Name of the solid.

    Raises:
        RemoSplatError: The points show only one side of the object.
    """
    points = (points[:, None, :] + _AROUND).reshape(-1, 3)
    low = points[points[:, 2] <= points[:, 2].min() + _FOOT]
    feet = np.column_stack([low[:, :2], np.full(len(low), bottom)])
    points = np.concatenate([points, feet])
    hull = scipy.spatial.ConvexHull(points)
    rim = points[scipy.spatial.ConvexHull(points[:, :2]).vertices, :2]
    half_height = 0.5 * (points[:, 2].max() - bottom)
    height = bottom + half_height
    box = _box(rim, half_height, height, name)
    if box.half_extents.min() < 0.5 * _THINNEST:
        raise RemoSplatError("the map shows only one side of it")
    cylinder = _cylinder(rim, half_height, height, name)
    solid: Solid = min(box, cylinder, key=_volume)
    if hull.volume >= _FILLED * _volume(solid):
        return solid
    p_WP = solid.X_WP.translation()
    vertices = points[hull.vertices] - p_WP
    return ConvexHull(RigidTransform(p_WP), vertices, name)


def _volume(solid: Box | Cylinder) -> float:
    if isinstance(solid, Box):
        return 8.0 * float(np.prod(solid.half_extents))
    return math.tau * solid.radius**2 * solid.half_height


def _box(rim: np.ndarray, half_height: float, height: float, name: str) -> Box:
    """The smallest box around an outline; one side is along one of its edges.

    Args:
        rim: Vertices of a convex polygon, in order, shape (v, 2) [m].
        half_height: Half the height of the box [m].
        height: Height of its middle in W [m].
        name: Name of the box.
    """
    edges = np.roll(rim, -1, axis=0) - rim
    yaws = np.unique(np.arctan2(edges[:, 1], edges[:, 0]) % (0.5 * math.pi))
    cosine, sine = np.cos(yaws), np.sin(yaws)
    sides = np.array([[cosine, sine], [-sine, cosine]])  # (2, 2, e)
    along = np.einsum("ije,vj->eiv", sides, rim)
    lower, upper = along.min(axis=2), along.max(axis=2)
    best = np.prod(upper - lower, axis=1).argmin()
    middle = 0.5 * (lower + upper)[best] @ sides[:, :, best]
    half = [*(0.5 * (upper - lower)[best]), half_height]
    rotation = RollPitchYaw(0.0, 0.0, yaws[best])
    X_WP = RigidTransform(rotation, [*middle, height])
    return Box(X_WP, np.array(half), name)


def _cylinder(
    rim: np.ndarray, half_height: float, height: float, name: str
) -> Cylinder:
    """The smallest cylinder around an outline; arguments as for `_box`.

    Its centre c minimizes max |p - c|^2 = |c|^2 + max(|p|^2 - 2 p c), which is
    a quadratic program in c and the maximum. The radius is computed from c, so
    the cylinder contains the outline even if c is not exact.
    """
    middle = rim.mean(axis=0)
    size = np.abs(rim - middle).max()
    p = (rim - middle) / size
    square = np.einsum("vi,vi->v", p, p)
    found = scipy.optimize.minimize(
        lambda x: x[:2] @ x[:2] + x[2],
        [0.0, 0.0, square.max()],
        jac=lambda x: np.array([2.0 * x[0], 2.0 * x[1], 1.0]),
        constraints={
            "type": "ineq",
            "fun": lambda x: x[2] - square + 2.0 * p @ x[:2],
            "jac": lambda x: np.column_stack([2.0 * p, np.ones(len(p))]),
        },
        method="SLSQP",
        options={"ftol": 1e-12},
    )
    center = middle + size * found.x[:2]
    radius = float(np.linalg.norm(rim - center, axis=1).max())
    X_WP = RigidTransform([*center, height])
    return Cylinder(X_WP, radius, half_height, name)
