"""Support function: the lowest vertex of a Minkowski difference along n."""

import numpy as np

from remosplat_drake.base.kernels import helper
from remosplat_drake.base.lanes import (
    WIDTH,
    greatest_of,
    in_all,
    lane_of,
    lanes_from,
    lowest_bit,
    places_of,
    where,
)


@helper
def add_support(hulls, x, y, z, simplex, row):
    """Finds the lowest vertex b - a along a direction, and stores it.

    Args:
        hulls: Hulls A and B, as `hull_distance` takes them.
        x: First entry of the unit vector n in A's frame.
        y: Second entry of n.
        z: Third entry of n.
        simplex: Its row `row` gets b - a, a, and b, shape (3, n, 3) [m].
        row: Index of this row.

    Returns:
        The height n'(b - a) of that vertex [m].
    """
    blocks, a, b, R_AB, p_AB = hulls
    i, k = _highest(blocks, a, x, y, z)
    # The opposite direction in B's frame.
    j, n = _highest(
        blocks,
        b,
        -R_AB[0, 0] * x - R_AB[1, 0] * y - R_AB[2, 0] * z,
        -R_AB[0, 1] * x - R_AB[1, 1] * y - R_AB[2, 1] * z,
        -R_AB[0, 2] * x - R_AB[1, 2] * y - R_AB[2, 2] * z,
    )
    for r in range(3):
        p = p_AB[r]
        for c in range(3):
            p += R_AB[r, c] * blocks[j, c, n]
        simplex[0, row, r] = p - blocks[i, r, k]
        simplex[1, row, r] = blocks[i, r, k]
        simplex[2, row, r] = p
    v = simplex[0, row]
    return x * v[0] + y * v[1] + z * v[2]


@helper
def _highest(blocks, span, x, y, z):
    """Finds the vertex of a hull that is highest along a direction.

    Returns:
        Its block, and its place there.
    """
    top, block = in_all(-np.inf), in_all(1.0 * span[0])
    for i in range(span[0], span[1]):
        at = 3 * WIDTH * i
        height = x * lanes_from(blocks, at) + y * lanes_from(blocks, at + WIDTH)
        height = height + z * lanes_from(blocks, at + 2 * WIDTH)
        is_higher = height > top
        top = where(is_higher, height, top)
        block = where(is_higher, 1.0 * i, block)
    place = lowest_bit(places_of(top >= greatest_of(top)))
    return int(lane_of(block, place)), place
