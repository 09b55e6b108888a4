"""Cutting a mesh into slabs whose convex hulls leave little air.

The hull of a bent or waisted link is much larger than the link. Cut across in
the right places, each slab's hull is close to it.
"""

import numpy as np

from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.robot.fitting.convex_pieces import (
    ConvexPiece,
    below,
    convex_piece,
    hull_volume,
)

DEEPEST = 2
"""Number of cuts on the way to a slab: four slabs at most."""

WORTH = 0.88
"""A cut is made if it leaves at most this fraction of the hull's volume."""

_PLACES = np.linspace(0.15, 0.85, 8)
"""Where cuts are tried, as fractions of the way through."""


def convex_slabs(
    surface: np.ndarray, tolerance: float, depth: int = DEEPEST
) -> list[ConvexPiece]:
    """Covers a surface with the hulls of slabs, one at least.

    A plane across the x, y or z axis cuts where the two hulls are smallest
    together, and cuts the halves likewise, while that is worth it.

    Args:
        surface: Triangles, shape (t, 3, 3) [m].
        tolerance: How far the surface may stand out of the hulls, which saves
            corners [m].
        depth: Number of further cuts on the way to a slab.

    Raises:
        RemoSplatError: The surface is flat.
    """
    whole = hull_volume(surface.reshape(-1, 3))
    best, halves = WORTH * whole, None
    lower, upper = surface.min(axis=(0, 1)), surface.max(axis=(0, 1))
    for axis in range(3) if depth else ():
        normal = np.eye(3)[axis]
        for place in _PLACES:
            offset = (1 - place) * lower[axis] + place * upper[axis]
            cut = (
                below(surface, normal, offset),
                below(surface, -normal, -offset),
            )
            volumes = [hull_volume(half.reshape(-1, 3)) for half in cut]
            if min(volumes) > 0 and sum(volumes) < best:
                best, halves = sum(volumes), cut
    if halves is None:
        return [convex_piece(surface.reshape(-1, 3), tolerance)]
    try:
        return [
            piece
            for half in halves
            for piece in convex_slabs(half, tolerance, depth - 1)
        ]
    except RemoSplatError:
        return [convex_piece(surface.reshape(-1, 3), tolerance)]
