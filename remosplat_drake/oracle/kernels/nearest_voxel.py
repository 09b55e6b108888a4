"""Nearest voxel of a wanted kind to many points: rings of columns.

A column of voxels knows, at every level, where its next voxel of the other
kind is, upwards and downwards. So the nearest one of a column takes two
look-ups, and columns are tried in growing square rings around the point until
a ring is farther away than what was found.
"""

import math
from typing import NamedTuple

import numpy as np
from numba import njit

_kernel = njit(cache=True, nogil=True)

_HALF_DIAGONAL = 0.8661
"""Half the diagonal of a voxel, rounded up [voxels]."""


class VoxelColumns(NamedTuple):
    """A grid of unseen and seen voxels, of which the outermost are unseen.

    Attributes:
        unseen: Which voxels are unseen, shape (nx, ny, nz), bool.
        up: Level of the next voxel above that is of the other kind, nz without
            one, shape (nx, ny, nz), int16.
        down: Level of the next voxel below that is of the other kind, -1
            without one, shape (nx, ny, nz), int16.
        apart: Distance between the centres of a voxel and of the nearest unseen
            one that is not in the lowest level [voxels], shape (nx, ny, nz),
            float32. Spheres that stand on the floor do not see that level.
        lower: Lower corner of the grid, shape (3,) [m].
        voxel: Edge length of a voxel [m].
    """

    unseen: np.ndarray
    up: np.ndarray
    down: np.ndarray
    apart: np.ndarray
    lower: np.ndarray
    voxel: float


@_kernel
def query(grid, spheres, answer):
    """Finds the boundary of unseen space nearest to every sphere's centre.

    Args:
        grid: The grid, a `VoxelColumns`.
        spheres: (n, 5): centre p_WS, the distance from the centre that an
            answer must undercut, the height below which voxels with their
            centres there are seen.
        answer: (n, 8), filled: 1 or, for none, -1; signed distance from the
            centre, p_WC, n_W.
    """
    nx, ny, nz = grid.unseen.shape
    for row in range(len(answer)):
        answer[row, 0] = -1.0
        p = (spheres[row, 0], spheres[row, 1], spheres[row, 2])
        limit = spheres[row, 3]
        first = _first_level(grid, spheres[row, 4])
        cell = (
            _level(p[0], grid.lower[0], grid.voxel, nx),
            _level(p[1], grid.lower[1], grid.voxel, ny),
            _level(p[2], grid.lower[2], grid.voxel, nz),
        )
        if cell[2] >= first and grid.unseen[cell]:
            found = _nearest(grid, p, cell, first, False, np.inf)
            _write_answer(grid, p, found, -1.0, limit, answer[row])
            continue
        least, most = _bounds(grid, p, cell, first)
        if limit > max(least, 0.0):
            found = _nearest(grid, p, cell, first, True, min(limit, most))
            _write_answer(grid, p, found, 1.0, limit, answer[row])


@_kernel
def _bounds(grid, p, cell, first):
    """Between what the distance to unseen space is, from that of centres."""
    apart = grid.apart[cell] * grid.voxel
    least = apart - 2 * _HALF_DIAGONAL * grid.voxel
    if first > 0:
        return least, np.inf
    height = p[2] - grid.lower[2] - grid.voxel
    most = apart + _HALF_DIAGONAL * grid.voxel
    return min(least, height), min(most, height + _HALF_DIAGONAL * grid.voxel)


@_kernel
def _level(x, lower, voxel, count):
    """The voxel of a coordinate along an axis; outside, the outermost."""
    return int(min(max(math.floor((x - lower) / voxel), 0.0), count - 1.0))


@_kernel
def _first_level(grid, floor):
    """The lowest level whose centres are not below the floor."""
    count = grid.unseen.shape[2]
    level = math.ceil((floor - grid.lower[2]) / grid.voxel - 0.5)
    return int(min(max(level, 0.0), float(count)))


@_kernel
def _nearest(grid, p, cell, first, unseen, limit):
    """The nearest voxel of a kind that is nearer than a limit, or (-1, ...).

    Levels below the first one are seen.
    """
    nx, ny, _ = grid.unseen.shape
    best = limit * limit, (-1, -1, -1)
    for ring in range(max(nx, ny)):
        gap = max(ring - 1, 0) * grid.voxel
        if gap * gap >= best[0]:
            break
        for i in range(max(cell[0] - ring, 0), min(cell[0] + ring + 1, nx)):
            # Inside a ring's first and last row there are only its ends.
            step = 1 if abs(i - cell[0]) == ring else 2 * ring
            for j in range(cell[1] - ring, cell[1] + ring + 1, max(step, 1)):
                if 0 <= j < ny:
                    column = (i, j, cell[2])
                    best = _nearer(grid, p, column, first, unseen, best)
    return best[1]


@_kernel
def _nearer(grid, p, column, first, unseen, best):
    """The better of `best` = (squared distance, voxel) and a column's."""
    i, j, level = column
    x, y = _gap(grid, p, 0, i), _gap(grid, p, 1, j)
    apart = x * x + y * y
    if apart >= best[0]:
        return best
    above, below = _around(grid, i, j, level, first, unseen)
    for k in (below, above):
        if 0 <= k < grid.unseen.shape[2]:
            z = _gap(grid, p, 2, k)
            square = apart + z * z
            if square < best[0]:
                best = square, (i, j, k)
    return best


@_kernel
def _around(grid, i, j, level, first, unseen):
    """Next levels of a kind at or above a level, and at or below it.

    Outside the grid where there is none. What is sought from an unseen
    voxel is seen, and then the level is not below the first one.
    """
    count = grid.unseen.shape[2]
    if not unseen:
        if not grid.unseen[i, j, level]:
            return level, level
        return grid.up[i, j, level], max(grid.down[i, j, level], first - 1)
    start = max(level, first)
    above = count
    if start < count:
        is_there = grid.unseen[i, j, start]
        above = start if is_there else int(grid.up[i, j, start])
    is_here = grid.unseen[i, j, level]
    below = level if is_here else int(grid.down[i, j, level])
    return above, below if below >= first else -1


@_kernel
def _gap(grid, p, axis, index):
    """From a coordinate to a voxel along an axis, 0 inside it [m]."""
    low = grid.lower[axis] + index * grid.voxel
    high = grid.lower[axis] + (index + 1) * grid.voxel
    return max(low - p[axis], p[axis] - high, 0.0)


@_kernel
def _write_answer(grid, p, found, sign, limit, answer):
    """Writes the point of a voxel that is nearest to p.

    On the boundary itself, where a direction is not defined, the voxel's
    centre tells it.
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
