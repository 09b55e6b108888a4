"""Finds the seen or unseen voxel of an octree that is nearest to a point.

Nodes are visited depth first, and the nearest child of a node first. A node is
skipped if it contains no voxel of the requested kind, or if it is farther than
the nearest voxel found so far.
"""

import math

import numpy as np

from remosplat_drake.base.kernels import helper, kernel
from remosplat_drake.oracle.voxel_octree import SEEN, UNSEEN, VoxelOctree
from remosplat_drake.signals.compiled_map import register_query


@kernel
def query(grid, spheres, answer):
    """Finds the boundary of unseen space nearest to every sphere's centre.

    Args:
        grid: The grid, a `VoxelOctree`.
        spheres: Queries, shape (n, 6). The columns are the centre p_WS, the
            distance from the centre below which the boundary is searched, and
            the height below which voxels, by their centres, count as seen [m].
            The last column is not used.
        answer: Output, shape (n, 8). The columns are 1 (-1 without a result),
            the signed distance from the centre, p_WC and n_W.
    """
    nx, ny, nz = grid.unseen.shape
    # Each level adds at most seven nodes to the stack.
    nodes = np.empty((8 * len(grid.levels), 4), np.int64)
    squares = np.empty(len(nodes))
    for row in range(len(answer)):
        answer[row, 0] = -1.0
        p = (spheres[row, 0], spheres[row, 1], spheres[row, 2])
        limit = spheres[row, 3]
        first = _first_level(grid, spheres[row, 4])
        i = _level(p[0], grid.lower[0], grid.voxel, nx)
        j = _level(p[1], grid.lower[1], grid.voxel, ny)
        k = _level(p[2], grid.lower[2], grid.voxel, nz)
        if k >= first and grid.unseen[i, j, k]:
            # Space below the floor counts as seen, so the floor is a boundary
            # of unseen space, too.
            start = np.inf, (-1, -1, -1)
            if first > 0:
                start = _square(grid, p, i, j, first - 1), (i, j, first - 1)
            found = _nearest(grid, p, 0, SEEN, start, nodes, squares)
            _write_answer(grid, p, found, -1.0, limit, answer[row])
        elif limit > 0.0:
            start = limit * limit, (-1, -1, -1)
            found = _nearest(grid, p, first, UNSEEN, start, nodes, squares)
            _write_answer(grid, p, found, 1.0, limit, answer[row])


register_query(VoxelOctree, query)


@helper
def _level(x, lower, voxel, count):
    """Returns the index of the voxel at a coordinate, clamped to the grid."""
    return int(min(max(math.floor((x - lower) / voxel), 0.0), count - 1.0))


@helper
def _first_level(grid, floor):
    """Returns the lowest layer whose centres are not below the floor."""
    count = grid.unseen.shape[2]
    level = math.ceil((floor - grid.lower[2]) / grid.voxel - 0.5)
    return int(min(max(level, 0.0), float(count)))


@helper
def _nearest(grid, p, first, kind, best, nodes, squares):
    """Returns the voxel of a kind that is nearest to a point.

    Args:
        grid: The grid.
        p: The point.
        first: Smallest index along z; voxels below it are ignored.
        kind: The kind.
        best: Squared distance below which voxels are searched, and the voxel
            that is returned if there is none.
        nodes: Memory for the nodes to visit, each as a level and three indices.
        squares: Memory for the squared distances to the boxes of these nodes.
    """
    # This value is read before the loop, in which the read would take a third
    # of the time.
    children, levels, voxel = grid.children, grid.levels, grid.voxel
    x, y, z = p[0] - grid.lower[0], p[1] - grid.lower[1], p[2] - grid.lower[2]
    least_z = max(first * voxel - z, 0.0) ** 2
    nearest, found = best
    nodes[0], squares[0] = (len(levels) - 1, 0, 0, 0), 0.0
    left = 1
    while left:
        left -= 1
        if squares[left] >= nearest:
            continue
        level = nodes[left, 0]
        i, j, k = nodes[left, 1], nodes[left, 2], nodes[left, 3]
        place = (i * levels[level, 1] + j) * levels[level, 2] + k
        mask = children[levels[level, 0] + place, kind]
        level, i, j, k = level - 1, 2 * i, 2 * j, 2 * k
        half = voxel * (1 << level)
        a, x0, x1 = _halves(x - i * half, half)
        b, y0, y1 = _halves(y - j * half, half)
        c, z0, z1 = _halves(z - k * half, half)
        z0, z1 = max(z0, least_z), max(z1, least_z)
        # The child nearest to p is pushed last and popped first.
        for turn in range(7, -1, -1):
            square = (x1 if turn & 4 else x0) + (y1 if turn & 2 else y0)
            square += z1 if turn & 1 else z0
            child = turn ^ (4 * a + 2 * b + c)
            if square >= nearest or not mask >> child & 1:
                continue
            u, v, w = i + (child >> 2), j + (child >> 1 & 1), k + (child & 1)
            if (w + 1) << level <= first:
                continue
            if level == 0:
                nearest, found = square, (u, v, w)
                continue
            nodes[left, 0], nodes[left, 1] = level, u
            nodes[left, 2], nodes[left, 3] = v, w
            squares[left] = square
            left += 1
    return found


@helper
def _halves(x, half):
    """Returns the index of the nearer half of [0, 2 half], and two distances.

    The distances are squared; the first is that of the nearer half.
    """
    if x < half:
        return 0, max(-x, 0.0) ** 2, (half - x) ** 2
    return 1, max(x - 2 * half, 0.0) ** 2, (x - half) ** 2


@helper
def _square(grid, p, i, j, k):
    """Returns the squared distance from a point to a voxel; 0 inside."""
    x, y, z = _gap(grid, p, 0, i), _gap(grid, p, 1, j), _gap(grid, p, 2, k)
    return x * x + y * y + z * z


@helper
def _gap(grid, p, axis, index):
    """Returns the distance to a voxel along an axis; 0 inside [m]."""
    low = grid.lower[axis] + index * grid.voxel
    high = grid.lower[axis] + (index + 1) * grid.voxel
    return max(low - p[axis], p[axis] - high, 0.0)


@helper
def _write_answer(grid, p, found, sign, limit, answer):
    """Writes the result of a query: the point of a voxel closest to p.

    If p is on the boundary, the difference of the points is zero, and the
    direction is computed from the voxel's centre.
    """
    if found[0] < 0:
        return
    square = 0.0
    for axis in range(3):
        low = grid.lower[axis] + found[axis] * grid.voxel
        high = grid.lower[axis] + (found[axis] + 1) * grid.voxel
        answer[2 + axis] = min(max(p[axis], low), high)
        square += (answer[2 + axis] - p[axis]) ** 2
    distance = math.sqrt(square)
    if sign * distance >= limit:
        return
    answer[0], answer[1] = 1.0, sign * distance
    length = 0.0
    for axis in range(3):
        aim = answer[2 + axis]
        if distance < 1e-9:
            aim = grid.lower[axis] + (found[axis] + 0.5) * grid.voxel
        answer[5 + axis] = sign * (aim - p[axis])
        length += answer[5 + axis] ** 2
    for axis in range(3):
        answer[5 + axis] /= math.sqrt(length)
