"""Finds clusters of points that may belong to one object."""

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import KDTree

_SHARE = 0.4
"""Edge length of the cells into which points are sorted, as a fraction of
`link`. All points in a cell are in one cluster. The search is faster, since
there are fewer cells than points.
"""


def clustered(p_W: np.ndarray, link: float) -> np.ndarray:
    """Divides points into clusters, with near points in one cluster.

    Args:
        p_W: Points, shape (n, 3) [m].
        link: Points within this distance of each other are in one cluster [m].
            The distance is accurate to the size of a cell.

    Returns:
        Index of each point's cluster, from 0, shape (n,).
    """
    if not len(p_W):
        return np.zeros(0, int)
    cell = np.floor(p_W / (_SHARE * link)).astype(np.int64)
    cell -= cell.min(axis=0)
    size = cell.max(axis=0) + 1
    key = (cell[:, 0] * size[1] + cell[:, 1]) * size[2] + cell[:, 2]
    _, inverse, count = np.unique(key, return_inverse=True, return_counts=True)
    center = np.stack(
        [np.bincount(inverse, p_W[:, axis]) for axis in range(3)], axis=1
    )
    center /= count[:, None]
    pairs = KDTree(center).query_pairs(link, output_type="ndarray")
    ones = np.ones(len(pairs), bool)
    graph = coo_array(
        (ones, (pairs[:, 0], pairs[:, 1])), shape=(len(count),) * 2
    )
    _, label = connected_components(graph, directed=False)
    return label[inverse]
