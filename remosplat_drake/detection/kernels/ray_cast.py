"""Renders depth images of rounded boxes and cylinders by ray casting."""

import math

import numpy as np

from remosplat_drake.base.kernels import helper, kernel
from remosplat_drake.scene.kernels.solid_distance import box_distance

_STEPS = 1000
"""Largest number of steps along a ray (sphere tracing). Rays that pass a face
at a distance of millimetres need many steps.
"""

_HIT = 2e-4
"""Distance from a surface that counts as a hit [m]."""


@helper
def _span(middle, z, radius, center, focal, size):
    """Returns the first and last pixel of a ball in a row or column."""
    distance = math.sqrt(middle * middle + z * z)
    if distance <= radius:
        return 0, size - 1
    angle, half = math.atan2(middle, z), math.asin(radius / distance)
    low, high = angle - half, angle + half
    edge = 1.55  # Almost at a right angle to the optical axis.
    if low > edge or high < -edge:
        return 0, -1
    first = 0 if low < -edge else math.floor(focal * math.tan(low) + center)
    last = size - 1
    if high < edge:
        last = math.floor(focal * math.tan(high) + center)
    return max(0, first), min(size - 1, last)


@helper
def _slab(px, dx, half, near, far):
    """Clips an interval of a ray to the space between two planes."""
    if abs(dx) < 1e-12:
        if abs(px) > half:
            return 1.0, 0.0
        return near, far
    a, b = (-half - px) / dx, (half - px) / dx
    return max(near, min(a, b)), min(far, max(a, b))


@helper
def _between(square, along, rest):
    """Returns the interval in which square t^2 + 2 along t + rest <= 0."""
    if square < 1e-12:
        if rest > 0.0:
            return math.inf, -math.inf
        return -math.inf, math.inf
    root = along * along - square * rest
    if root < 0.0:
        return math.inf, -math.inf
    root = math.sqrt(root)
    return (-along - root) / square, (-along + root) / square


@helper
def _ball(o, d, height, radius):
    """Returns the interval of a ray within a ball around (0, 0, height)."""
    z = o[2] - height
    return _between(
        d[0] * d[0] + d[1] * d[1] + d[2] * d[2],
        o[0] * d[0] + o[1] * d[1] + z * d[2],
        o[0] * o[0] + o[1] * o[1] + z * z - radius * radius,
    )


@helper
def _cylinder(o, d, half_height, radius):
    """Returns the interval of a ray within an upright cylinder."""
    near, far = _between(
        d[0] * d[0] + d[1] * d[1],
        o[0] * d[0] + o[1] * d[1],
        o[0] * o[0] + o[1] * o[1] - radius * radius,
    )
    near, far = _slab(o[2], d[2], half_height, near, far)
    if near > far:
        return math.inf, -math.inf
    return near, far


@helper
def _capsule(o, d, half_height, radius):
    """Returns the interval of a ray within an upright capsule."""
    near, far = _cylinder(o, d, half_height, radius)
    for height in (-half_height, half_height):
        first, last = _ball(o, d, height, radius)
        near, far = min(near, first), max(far, last)
    return near, far


@helper
def _march(size, radius, o, d, length, near, far):
    """Finds by sphere tracing where a ray hits a rounded box; -1 for a miss.

    `o` and `d` are the ray's origin and direction in the solid's frame, and
    `length` is that of the direction.
    """
    t = near
    for _ in range(_STEPS):
        x, y, z = o[0] + t * d[0], o[1] + t * d[1], o[2] + t * d[2]
        apart, _, _, _ = box_distance(x, y, z, size)
        apart -= radius
        if apart < _HIT:
            return t
        t += apart / length
        if t >= far:
            return -1.0
    return t


@helper
def _enter(solids, s, o, d, length, near, far):
    """Returns the depth where a ray enters a solid in an interval, or -1."""
    size, radius = solids.half_extents[s], solids.radius[s]
    first, last = near, far
    if not solids.is_box[s]:
        first, last = _cylinder(o, d, size[2], size[0])
    elif size[0] + size[1] == 0.0:
        first, last = _capsule(o, d, size[2], radius)
    else:
        for c in range(3):
            first, last = _slab(o[c], d[c], size[c] + radius, first, last)
    first, last = max(first, near), min(last, far)
    if first >= last:
        return -1.0
    if radius == 0.0 or size[0] + size[1] == 0.0:
        return first
    return _march(size, radius, o, d, length, first, last)


@kernel
def ray_cast(K, X_WC, solids, first_label, nearest, depth, label) -> None:
    """Draws solids into a depth image.

    Args:
        K: Intrinsic matrix, shape (3, 3) [pixels].
        X_WC: Camera pose, shape (4, 4).
        solids: The `CastSolids`.
        first_label: Label of the first solid; the next solids have the next
            integers.
        nearest: Least depth of the camera's range [m].
        depth: Depths drawn so far, shape (h, w), float32 [m]; inf where no
            surface is. Nearer surfaces of the solids replace them.
        label: Labels drawn so far, shape (h, w), int32.
    """
    height, width = depth.shape
    R_WG, R_GC = solids.R_WG, np.empty((3, 3))
    p_CG = np.empty((len(solids.radius), 3))
    for s in range(len(solids.radius)):
        x = solids.p_WG[s, 0] - X_WC[0, 3]
        y = solids.p_WG[s, 1] - X_WC[1, 3]
        z = solids.p_WG[s, 2] - X_WC[2, 3]
        for c in range(3):
            p_CG[s, c] = X_WC[0, c] * x + X_WC[1, c] * y + X_WC[2, c] * z
    # The nearest solids first, since they hide pixels of the others.
    for s in np.argsort(p_CG[:, 2] - solids.reach):
        cx, cy, cz = p_CG[s]
        reach = solids.reach[s]
        if cz + reach <= nearest:
            continue
        left, right = _span(cx, cz, reach, K[0, 2], K[0, 0], width)
        top, bottom = _span(cy, cz, reach, K[1, 2], K[1, 1], height)
        offset = reach * reach - (cx * cx + cy * cy + cz * cz)
        half = solids.half_extents[s]
        is_ball = solids.is_box[s] and half[0] + half[1] + half[2] == 0.0
        for i in range(3):
            for j in range(3):
                R_GC[i, j] = (
                    R_WG[s, 0, i] * X_WC[0, j]
                    + R_WG[s, 1, i] * X_WC[1, j]
                    + R_WG[s, 2, i] * X_WC[2, j]
                )
        # The camera in the solid's frame.
        o = (
            -(R_GC[0, 0] * cx + R_GC[0, 1] * cy + R_GC[0, 2] * cz),
            -(R_GC[1, 0] * cx + R_GC[1, 1] * cy + R_GC[1, 2] * cz),
            -(R_GC[2, 0] * cx + R_GC[2, 1] * cy + R_GC[2, 2] * cz),
        )
        for row in range(top, bottom + 1):
            y = (row + 0.5 - K[1, 2]) / K[1, 1]
            for column in range(left, right + 1):
                far = float(depth[row, column])
                if far <= cz - reach:
                    continue
                # The ball around the solid is tested first.
                x = (column + 0.5 - K[0, 2]) / K[0, 0]
                square = x * x + y * y + 1.0
                along = (cx * x + cy * y + cz) / square
                rest = offset / square + along * along
                if rest < 0.0:
                    continue
                chord = math.sqrt(rest)
                z = max(nearest, along - chord)
                end = min(far, along + chord)
                if z >= end:
                    continue
                if not is_ball:
                    d = (
                        R_GC[0, 0] * x + R_GC[0, 1] * y + R_GC[0, 2],
                        R_GC[1, 0] * x + R_GC[1, 1] * y + R_GC[1, 2],
                        R_GC[2, 0] * x + R_GC[2, 1] * y + R_GC[2, 2],
                    )
                    z = _enter(solids, s, o, d, math.sqrt(square), z, end)
                if 0.0 < z < far:
                    depth[row, column] = z
                    label[row, column] = first_label + s
