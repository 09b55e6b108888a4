"""`CastSolids`: solids as arrays for the ray caster."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from remosplat_drake.robot.sphere_model import Spheres
from remosplat_drake.scene.mover import Movers
from remosplat_drake.scene.primitive_scene import Box, PrimitiveScene


class CastSolids(NamedTuple):
    """Arrays of k rounded boxes and cylinders.

    Attributes:
        is_box: Mask of the boxes, shape (k,); the other solids are cylinders.
        half_extents: Half extents of each box, shape (k, 3) [m]. For a
            cylinder, these are its radius (twice) and its half height.
        radius: Radii by which these shapes are rounded, shape (k,) [m].
        R_WG: Orientations, shape (k, 3, 3).
        p_WG: Centres in W, shape (k, 3) [m].
        reach: Radii of bounding balls around the centres, shape (k,) [m].
    """

    is_box: np.ndarray
    half_extents: np.ndarray
    radius: np.ndarray
    R_WG: np.ndarray
    p_WG: np.ndarray
    reach: np.ndarray


def scene_solids(scene: PrimitiveScene) -> CastSolids:
    """Makes solids of a scene's boxes and cylinders."""
    solids = scene.primitives
    size = [
        s.half_extents
        if isinstance(s, Box)
        else np.array([s.radius, s.radius, s.half_height])
        for s in solids
    ]
    reach = [
        float(np.linalg.norm(half if isinstance(s, Box) else half[1:]))
        for s, half in zip(solids, size, strict=True)
    ]
    return _solids(
        [isinstance(s, Box) for s in solids],
        size,
        np.zeros(len(solids)),
        [s.X_WP.rotation().matrix() for s in solids],
        [s.X_WP.translation() for s in solids],
        reach,
    )


def mover_solids(movers: Movers) -> CastSolids:
    """Makes solids of movers at the movers' time stamp."""
    half = [mover.half_extents for mover in movers]
    radius = np.array([mover.radius for mover in movers], float)
    core = [float(np.linalg.norm(extents)) for extents in half]
    return _solids(
        np.ones(len(movers), bool),
        half,
        radius,
        [mover.X_WM.rotation().matrix() for mover in movers],
        [mover.X_WM.translation() for mover in movers],
        radius + np.array(core, float),
    )


def sphere_solids(spheres: Spheres) -> CastSolids:
    """Makes solids of a robot's spheres."""
    n = len(spheres)
    return _solids(
        np.ones(n, bool),
        np.zeros((n, 3)),
        spheres.radius,
        np.tile(np.eye(3), (n, 1, 1)),
        spheres.p_WS,
        spheres.radius,
    )


def _solids(
    is_box: Sequence[bool] | np.ndarray,
    half_extents: Sequence[np.ndarray] | np.ndarray,
    radius: np.ndarray,
    R_WG: Sequence[np.ndarray] | np.ndarray,
    p_WG: Sequence[np.ndarray] | np.ndarray,
    reach: Sequence[float] | np.ndarray,
) -> CastSolids:
    k = len(radius)

    def rows(values, *shape: int) -> np.ndarray:
        return np.array(values, float, order="C").reshape(k, *shape)

    return CastSolids(
        np.array(is_box, bool).reshape(k),
        rows(half_extents, 3),
        rows(radius),
        rows(R_WG, 3, 3),
        rows(p_WG, 3),
        rows(reach),
    )
