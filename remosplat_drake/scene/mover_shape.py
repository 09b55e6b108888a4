"""Converts movers to Drake's shapes."""

from pydrake.geometry import Box, Capsule, Shape, Sphere

from remosplat_drake.scene.mover import Mover


def shape_of(mover: Mover) -> Shape:
    """Returns Drake's shape of a mover, with sharp edges if it is a box.

    Args:
        mover: A sphere, a capsule along z, or a box.
    """
    x, y, z = mover.half_extents
    if x == y == z == 0.0:
        return Sphere(mover.radius)
    if x == y == 0.0:
        return Capsule(mover.radius, 2.0 * z)
    return Box(*(2.0 * (mover.half_extents + mover.radius)))
