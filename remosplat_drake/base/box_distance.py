"""Computes signed distances of points, scalar or SIMD, from solids."""

from remosplat_drake.base.kernels import helper
from remosplat_drake.base.lanes import greatest, magnitude, root, where


@helper
def distance_to_box(x, y, z, half):
    """Computes the signed distance of a point from a box at the origin [m].

    Args:
        x: x of the point: a number, or a SIMD vector of `lanes` [m].
        y: y of the point, of the same type [m].
        z: z of the point, of the same type [m].
        half: Half edges of the box, shape (3,) [m].
    """
    x, y = magnitude(x) - half[0], magnitude(y) - half[1]
    z = magnitude(z) - half[2]
    inside = greatest(greatest(x, y), z)
    x, y, z = greatest(x, 0.0), greatest(y, 0.0), greatest(z, 0.0)
    return _signed(x * x + y * y + z * z, inside)


@helper
def distance_to_cylinder(x, y, z, size):
    """Computes the signed distance of a point from a cylinder along z [m].

    Args:
        x: x of the point: a number, or a SIMD vector of `lanes` [m].
        y: y of the point, of the same type [m].
        z: z of the point, of the same type [m].
        size: Half edges of the cylinder's bounding box: its radius, its radius,
            and its half height, shape (3,) [m].
    """
    radial, axial = root(x * x + y * y) - size[0], magnitude(z) - size[2]
    inside = greatest(radial, axial)
    radial, axial = greatest(radial, 0.0), greatest(axial, 0.0)
    return _signed(radial * radial + axial * axial, inside)


@helper
def _signed(square, inside):
    """Returns the distance of a point: positive outside, negative inside."""
    return where(square > 0.0, root(square), inside)
