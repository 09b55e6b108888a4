"""Depth images of rounded boxes and cylinders, by casting a ray a pixel."""

import math

from remosplat_drake.base.kernels import helper, kernel
from remosplat_drake.scene.kernels.solid_distance import (
    box_distance,
    cylinder_distance,
)

_STEPS = 1000
"""Most steps along a ray; each goes as far as nothing can be hit. Rays that
pass millimetres beside a face take many."""

_HIT = 2e-4
"""Distance from a surface at which a ray has hit it [m]."""


@helper
def _span(middle, z, radius, center, focal, size):
    """First and last pixel of a row or column that a ball can be seen at."""
    distance = math.sqrt(middle * middle + z * z)
    if distance <= radius:
        return 0, size - 1
    angle, half = math.atan2(middle, z), math.asin(radius / distance)
    low, high = angle - half, angle + half
    edge = 1.55  # Almost at a right angle to where the camera looks.
    if low > edge or high < -edge:
        return 0, -1
    first = 0 if low < -edge else math.floor(focal * math.tan(low) + center)
    last = size - 1
    if high < edge:
        last = math.floor(focal * math.tan(high) + center)
    return max(0, first), min(size - 1, last)


@helper
def _slab(px, dx, half, near, far):
    """Narrows a stretch of a ray to where it is between two planes."""
    if abs(dx) < 1e-12:
        if abs(px) > half:
            return 1.0, 0.0
        return near, far
    a, b = (-half - px) / dx, (half - px) / dx
    return max(near, min(a, b)), min(far, max(a, b))


@helper
def _march(solids, s, o, d, length, near, far):
    """Goes along a ray until it hits a solid; -1 if it does not.

    `o` and `d` are the ray's origin and direction in the solid's frame, and
    `length` is that of the direction.
    """
    size, radius = solids.half_extents[s], solids.radius[s]
    t = near
    for _ in range(_STEPS):
        x, y, z = o[0] + t * d[0], o[1] + t * d[1], o[2] + t * d[2]
        if solids.is_box[s]:
            apart, _, _, _ = box_distance(x, y, z, size)
        else:
            apart, _, _, _ = cylinder_distance(x, y, z, size)
        apart -= radius
        if apart < _HIT:
            return t
        t += apart / length
        if t >= far:
            return -1.0
    return t


@helper
def _hit(solids, s, o, d, length, near, far):
    """Depth at which a ray enters a solid; -1 if it does not."""
    size, radius = solids.half_extents[s], solids.radius[s]
    # The ball around it comes first.
    reach = solids.reach[s]
    along = -(o[0] * d[0] + o[1] * d[1] + o[2] * d[2]) / (length * length)
    x, y, z = o[0] + along * d[0], o[1] + along * d[1], o[2] + along * d[2]
    rest = reach * reach - (x * x + y * y + z * z)
    if rest < 0.0:
        return -1.0
    half = math.sqrt(rest) / length
    near, far = max(near, along - half), min(far, along + half)
    if near >= far:
        return -1.0
    if not solids.is_box[s]:
        return _march(solids, s, o, d, length, near, far)
    if size[0] + size[1] + size[2] == 0.0:
        return near
    first, last = near, far
    for c in range(3):
        first, last = _slab(o[c], d[c], size[c] + radius, first, last)
    if first >= last:
        return -1.0
    if radius == 0.0:
        return first
    return _march(solids, s, o, d, length, first, last)


@kernel
def ray_cast(K, X_WC, solids, first_label, nearest, depth, label) -> None:
    """Draws solids into a depth image.

    Args:
        K: Intrinsic matrix, shape (3, 3) [pixels].
        X_WC: Camera pose, shape (4, 4).
        solids: The `CastSolids`.
        first_label: Label of the first solid; those of the others follow.
        nearest: Least depth that is seen [m].
        depth: Depths of what has been drawn so far, shape (h, w), float32 [m];
            inf for nothing. What is nearer takes its place.
        label: Labels of that, shape (h, w), int32.
    """
    height, width = depth.shape
    for s in range(len(solids.radius)):
        R, p = solids.R_WG[s], solids.p_WG[s]
        ox, oy, oz = p[0] - X_WC[0, 3], p[1] - X_WC[1, 3], p[2] - X_WC[2, 3]
        cx = X_WC[0, 0] * ox + X_WC[1, 0] * oy + X_WC[2, 0] * oz
        cy = X_WC[0, 1] * ox + X_WC[1, 1] * oy + X_WC[2, 1] * oz
        cz = X_WC[0, 2] * ox + X_WC[1, 2] * oy + X_WC[2, 2] * oz
        reach = solids.reach[s]
        if cz + reach <= nearest:
            continue
        left, right = _span(cx, cz, reach, K[0, 2], K[0, 0], width)
        top, bottom = _span(cy, cz, reach, K[1, 2], K[1, 1], height)
        # The camera in the solid's frame.
        o = (
            -(R[0, 0] * ox + R[1, 0] * oy + R[2, 0] * oz),
            -(R[0, 1] * ox + R[1, 1] * oy + R[2, 1] * oz),
            -(R[0, 2] * ox + R[1, 2] * oy + R[2, 2] * oz),
        )
        for row in range(top, bottom + 1):
            y = (row + 0.5 - K[1, 2]) / K[1, 1]
            for column in range(left, right + 1):
                x = (column + 0.5 - K[0, 2]) / K[0, 0]
                wx = X_WC[0, 0] * x + X_WC[0, 1] * y + X_WC[0, 2]
                wy = X_WC[1, 0] * x + X_WC[1, 1] * y + X_WC[1, 2]
                wz = X_WC[2, 0] * x + X_WC[2, 1] * y + X_WC[2, 2]
                d = (
                    R[0, 0] * wx + R[1, 0] * wy + R[2, 0] * wz,
                    R[0, 1] * wx + R[1, 1] * wy + R[2, 1] * wz,
                    R[0, 2] * wx + R[1, 2] * wy + R[2, 2] * wz,
                )
                length = math.sqrt(x * x + y * y + 1.0)
                far = float(depth[row, column])
                z = _hit(solids, s, o, d, length, nearest, far)
                if 0.0 < z < far:
                    depth[row, column] = z
                    label[row, column] = first_label + s
