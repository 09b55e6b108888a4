"""Fits spheres around objects, with the functions of `robot/fitting`."""

from functools import lru_cache

import numpy as np

from remosplat_drake.robot.fitting.link_spheres import LinkSpheres
from remosplat_drake.robot.fitting.link_surface import sample_shape
from remosplat_drake.robot.fitting.sphere_fitting import (
    POINTS_PER_VOXEL,
    fit_spheres,
    make_link_surface,
    voxel_pitch,
)
from remosplat_drake.scene.objects.drake_shapes import drake_shape
from remosplat_drake.scene.objects.scene_object import SceneObject
from remosplat_drake.task.carrying import hull_pieces

BULGE = 0.005
"""Distance by which the spheres of a carried object may exceed its surface
[m]."""

MOST_SPHERES = 24
"""A carried object has at most this many spheres. If these do not suffice, the
spheres exceed the object's surface by more than `BULGE`."""


def fit_object(thing: SceneObject) -> LinkSpheres:
    """Fits spheres around an object; caches the result for equal solids.

    Args:
        thing: The object.

    Returns:
        The spheres in its frame O.
    """
    rng = np.random.default_rng(0)
    spacing = voxel_pitch(np.ptp(thing.corners, axis=0)) / POINTS_PER_VOXEL
    points = np.concatenate(
        [
            sample_shape(drake_shape(thing.solid), spacing, rng),
            *hull_pieces(thing.solid),
        ]
    )
    return _fit_points(points.tobytes())


@lru_cache(maxsize=32)
def _fit_points(points: bytes) -> LinkSpheres:
    """Fits spheres around points of a surface, the bytes of an (n, 3) array."""
    p = np.frombuffer(points).reshape(-1, 3).copy()
    found = fit_spheres(
        {"": make_link_surface(p)},
        tolerance=BULGE,
        most=MOST_SPHERES,
        restarts=1,
    )
    return found[""].grown_over(p, 1e-4)


def overhang(thing: SceneObject, spheres: LinkSpheres) -> float:
    """Returns the distance by which spheres exceed an object's box [m].

    Args:
        thing: The object.
        spheres: Spheres in its frame.
    """
    lower, upper = thing.corners
    below = lower - (spheres.p_LS - spheres.radius[:, None])
    above = spheres.p_LS + spheres.radius[:, None] - upper
    return float(max(below.max(), above.max(), 0.0))
