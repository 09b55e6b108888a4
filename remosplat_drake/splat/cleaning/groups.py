"""Finds groups of splats that touch each other, by a graph of neighbours."""

import dataclasses as dc

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import KDTree

from remosplat_drake.base.threads import blocks, num_threads
from remosplat_drake.splat.gaussian_splat import GaussianSplat

NEIGHBOURS = 12
"""Number of nearest neighbours of a splat for which contact is tested."""

REACH = 3.0
"""Extent of a splat in standard deviations. Two splats touch if their extents
overlap."""

_BLOCK = 1 << 13


@dc.dataclass(frozen=True, eq=False)
class Neighbours:
    """The k nearest neighbours of each of n splats, the nearest first.

    Attributes:
        index: Indices of the neighbours, shape (n, k), int32; n for missing
            neighbours.
        distance: Distances of the neighbours, shape (n, k), single precision;
            inf for missing neighbours.
    """

    index: np.ndarray
    distance: np.ndarray


def find_neighbours(p_GK: np.ndarray, count: int = NEIGHBOURS) -> Neighbours:
    """Finds the nearest neighbours of each point among the other points.

    Args:
        p_GK: The points, shape (n, 3).
        count: Number k of neighbours.
    """
    n = len(p_GK)
    index = np.full((n, count), n, np.int32)
    distance = np.full((n, count), np.inf, np.float32)
    tree, workers = KDTree(p_GK), num_threads()
    for rows in blocks(n, _BLOCK):
        found = tree.query(p_GK[rows], count + 1, workers=workers)
        far, near = map(np.asarray, found)
        # If points coincide, the first result of a point may be another point
        # and not the point itself.
        own = near == np.arange(rows.start, rows.stop)[:, None]
        own[~own.any(axis=1), -1] = True
        index[rows] = near[~own].reshape(-1, count)
        distance[rows] = far[~own].reshape(-1, count)
    return Neighbours(index, distance)


@dc.dataclass(frozen=True, eq=False)
class Groups:
    """Connected groups of splats.

    Attributes:
        label: Number of the group of each splat, shape (n,).
        size: Number of splats in each group, shape (m,).
    """

    label: np.ndarray
    size: np.ndarray

    @property
    def largest(self) -> int:
        """Number of the largest group."""
        return int(self.size.argmax())

    def least(self, values: np.ndarray) -> np.ndarray:
        """Returns the least value of each group's splats, shape (m,)."""
        least = np.full(len(self.size), np.inf)
        np.minimum.at(least, self.label, values)
        return least

    def greatest(self, values: np.ndarray) -> np.ndarray:
        """Returns the greatest value of each group's splats, shape (m,)."""
        return -self.least(-values)


def find_groups(
    splat: GaussianSplat, neighbours: Neighbours | None = None
) -> Groups:
    """Finds the groups of splats that touch, directly or through others.

    Two neighbours touch if their extents along the line between their centres
    overlap. The extent is `REACH` standard deviations. So a needle touches
    splats that are far away along its axis, but not splats that are far away
    across it. A disc counts as a ball, so that a chain of small discs is one
    group for any orientations of the discs.

    Args:
        splat: At least one splat.
        neighbours: The neighbours of the splats; if they are None, this
            function finds them.
    """
    n = len(splat)
    if neighbours is None:
        neighbours = find_neighbours(splat.p_GK)
    firsts, seconds = [], []
    for rows in blocks(n, _BLOCK):
        i, j = _touching(splat, neighbours, rows)
        firsts.append(i)
        seconds.append(j)
    i, j = np.concatenate(firsts), np.concatenate(seconds)
    graph = coo_array((np.ones(len(i), np.bool_), (i, j)), (n, n))
    _, label = connected_components(graph, directed=False)
    return Groups(label, np.bincount(label))


def _touching(
    splat: GaussianSplat, neighbours: Neighbours, rows: slice
) -> tuple[np.ndarray, np.ndarray]:
    """Returns the pairs of some splats and neighbours that touch."""
    j, distance = neighbours.index[rows], neighbours.distance[rows]
    size = np.append(splat.scales.max(axis=1), 0.0)
    reach = REACH * (size[rows, None] + size[j])
    # In any direction, a splat extends no farther than its largest axis.
    row, column = np.nonzero(distance <= reach)
    i, j = rows.start + row, j[row, column]
    d_G = (splat.p_GK[j] - splat.p_GK[i]).astype(float)
    length = np.linalg.norm(d_G, axis=1)
    u_G = d_G / np.maximum(length, np.finfo(float).tiny)[:, None]
    touches = length <= REACH * (
        _extent(splat, i, u_G) + _extent(splat, j, u_G)
    )
    return i[touches].astype(np.int32), j[touches]


def _extent(
    splat: GaussianSplat, index: np.ndarray, u_G: np.ndarray
) -> np.ndarray:
    """Returns one standard deviation of some splats along unit vectors.

    It is at least that of the splat's second axis, since the normals of splats
    on a thin wire are inaccurate.
    """
    chosen = splat.select(index)
    along = np.einsum("nij,ni->nj", chosen.R_GK, u_G)
    scaled = along[:, : chosen.scales.shape[1]] * chosen.scales
    second = np.sort(chosen.scales, axis=1)[:, -2]
    return np.maximum(np.linalg.norm(scaled, axis=1), second)
