"""Exact Euclidean distance transform of a voxel grid.

Meijster, Roerdink, Hesselink (2000): squared distances along one axis are
extended by the other axes. Along a line of voxels, the result is the lower
envelope of parabolas, one for each voxel.
"""

import numpy as np

from remosplat_drake.base.kernels import helper, kernel


@kernel
def squared_distances(marked):
    """Computes the squared distance of each voxel to the nearest marked one.

    Args:
        marked: The marked voxels, shape (nx, ny, nz) bool.

    Returns:
        The squared distances in voxel edges, integers of shape (nx, ny, nz). If
        no voxel is marked, all are larger than in any grid of this shape.
    """
    n_x, n_y, n_z = marked.shape
    far = n_x + n_y + n_z
    squares = np.empty((n_x, n_y, n_z), np.int32)
    longest = max(n_x, n_y)
    line, result = np.empty(longest, np.int64), np.empty(longest, np.int64)
    apex, begin = np.empty(longest, np.int64), np.empty(longest, np.int64)
    for x in range(n_x):
        for y in range(n_y):
            away = far
            for z in range(n_z):
                away = 0 if marked[x, y, z] else min(away + 1, far)
                squares[x, y, z] = away * away
            for z in range(n_z - 1, -1, -1):
                away = 0 if marked[x, y, z] else min(away + 1, far)
                squares[x, y, z] = min(squares[x, y, z], away * away)
        for z in range(n_z):
            for y in range(n_y):
                line[y] = squares[x, y, z]
            _lower_envelope(line, n_y, apex, begin, result)
            for y in range(n_y):
                squares[x, y, z] = result[y]
    for y in range(n_y):
        for z in range(n_z):
            for x in range(n_x):
                line[x] = squares[x, y, z]
            _lower_envelope(line, n_x, apex, begin, result)
            for x in range(n_x):
                squares[x, y, z] = result[x]
    return squares


@helper
def _lower_envelope(line, n, apex, begin, result):
    """Computes the least of line[i] + (k - i)^2 over i for each k below n.

    Args:
        line: The numbers, of which the first n are used.
        n: The number of numbers.
        apex: Working array: the i of each parabola of the envelope.
        begin: Working array: the first k of each parabola.
        result: Receives the least values.
    """
    last = apex[0] = begin[0] = 0
    for i in range(1, n):
        while last >= 0:
            k, j = begin[last], apex[last]
            if (k - j) ** 2 + line[j] <= (k - i) ** 2 + line[i]:
                break
            last -= 1
        if last < 0:
            last, apex[0] = 0, i
            continue
        j = apex[last]
        k = 1 + (i * i - j * j + line[i] - line[j]) // (2 * (i - j))
        if k < n:
            last += 1
            apex[last], begin[last] = i, k
    for k in range(n - 1, -1, -1):
        result[k] = (k - apex[last]) ** 2 + line[apex[last]]
        if k == begin[last]:
            last -= 1
