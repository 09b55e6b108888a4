"""The vertex of two hulls' Minkowski difference that is lowest along n."""

import numpy as np

from remosplat_drake.base.kernels import helper


@helper
def add_support(hulls, x, y, z, simplex, row):
    """Finds the lowest vertex b - a along a direction, and notes it.

    Args:
        hulls: Hulls A and B, as `hull_distance` takes them: the vertices of
            all hulls, the rows of A and of B, and B's pose in A's frame.
        x: The unit vector n in A's frame, with `y` and `z`.
        y: See above.
        z: See above.
        simplex: Its row `row` gets b - a, a, and b, shape (3, n, 3) [m].
        row: Which row.

    Returns:
        The height n'(b - a) of that vertex [m].
    """
    corners, a, b, R_AB, p_AB = hulls
    i, top = a[0], -np.inf
    for k in range(a[0], a[1]):
        height = x * corners[k, 0] + y * corners[k, 1] + z * corners[k, 2]
        if height > top:
            i, top = k, height
    # The same direction in B's frame.
    u = R_AB[0, 0] * x + R_AB[1, 0] * y + R_AB[2, 0] * z
    v = R_AB[0, 1] * x + R_AB[1, 1] * y + R_AB[2, 1] * z
    w = R_AB[0, 2] * x + R_AB[1, 2] * y + R_AB[2, 2] * z
    j, low = b[0], np.inf
    for k in range(b[0], b[1]):
        height = u * corners[k, 0] + v * corners[k, 1] + w * corners[k, 2]
        if height < low:
            j, low = k, height
    for k in range(3):
        p = p_AB[k]
        for c in range(3):
            p += R_AB[k, c] * corners[j, c]
        simplex[0, row, k] = p - corners[i, k]
        simplex[1, row, k] = corners[i, k]
        simplex[2, row, k] = p
    v_W = simplex[0, row]
    return x * v_W[0] + y * v_W[1] + z * v_W[2]
