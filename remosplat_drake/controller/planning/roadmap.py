"""`Roadmap`: the corners of earlier paths, for later searches.

Edges are checked only when a path uses them (Bohlin and Kavraki 2000). So the
roadmap remains useful if the map, the target or the stopping distance changes.
"""

import dataclasses as dc
from itertools import pairwise

import numpy as np
import scipy

from remosplat_drake.controller.planning.free_space import FreeSpace

_NEIGHBOURS = 6
"""The start and each goal are connected to this many corners."""

_UNKNOWN = 4.0
"""The cost of a new connection is its length times this factor; that of an edge
of a path is its length."""

_NO_WAY = 1e-9
"""Additional cost of each edge, since SciPy treats a cost of zero as a missing
edge [rad, m]."""

_MOST = 400
"""At most this many corners are stored; the oldest corners are removed."""

_TRIES = 12
"""Number of blocked paths after which the search ends."""


@dc.dataclass(frozen=True, eq=False)
class Roadmap:
    """Corners of earlier paths, and the edges between them.

    Attributes:
        q: The corners, shape (m, n_q) [rad, m]; None if there are no corners.
        edges: Indices of the two corners of each edge, shape (e, 2).
    """

    q: np.ndarray | None = None
    edges: np.ndarray = dc.field(default_factory=lambda: np.zeros((0, 2), int))

    def with_path(self, corners: np.ndarray) -> "Roadmap":
        """Returns the roadmap with an additional path.

        Args:
            corners: Corners of the path, shape (k, n_q) [rad, m].
        """
        k = len(corners)
        path = np.column_stack([np.arange(k - 1), np.arange(1, k)])
        if self.q is None:
            return Roadmap(corners, path)
        q = np.vstack([self.q, corners])
        edges = np.vstack([self.edges, path + len(self.q)])
        dropped = max(len(q) - _MOST, 0)
        edges = edges[(edges >= dropped).all(axis=1)] - dropped
        return Roadmap(q[dropped:], edges)

    def path_between(
        self, space: FreeSpace, q: np.ndarray, goals: np.ndarray
    ) -> np.ndarray | None:
        """Finds a free path along stored corners.

        Args:
            space: The present free space.
            q: Start of the path, shape (n_q,) [rad, m].
            goals: Possible ends of the path, shape (k, n_q) [rad, m].

        Returns:
            The corners, shape (m, n_q); None if the roadmap contains no free
            path.
        """
        if self.q is None:
            return None
        places = np.vstack([q[None], goals, self.q])
        first = 1 + len(goals)
        cost = {}
        for a, b in self.edges + first:
            cost[a, b] = cost[b, a] = _distance(places[a], places[b])
        for place in range(first):
            far = _distance(places[place], self.q)
            for near in np.argsort(far, kind="stable")[:_NEIGHBOURS]:
                tie = (
                    (place, first + near)
                    if place == 0
                    else (first + near, place)
                )
                cost[tie] = _UNKNOWN * far[near]
        for _ in range(_TRIES):
            way = _shortest(cost, len(places), range(1, first))
            if way is None:
                return None
            blocked = _first_blocked(space, places, way)
            if blocked is None:
                return places[way]
            del cost[blocked]
        return None


NO_ROADMAP = Roadmap()
"""The `Roadmap` without corners."""


def _distance(q: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Returns the costs of edges from one configuration to others, (...)."""
    return np.abs(other - q).max(axis=-1) + _NO_WAY


def _shortest(cost: dict, count: int, goals: range) -> list[int] | None:
    """Finds the cheapest path from node 0 to a goal, as node indices."""
    ends = np.array(list(cost), int).reshape(-1, 2)
    graph = scipy.sparse.csr_array(
        (list(cost.values()), (ends[:, 0], ends[:, 1])), (count, count)
    )
    far, before = scipy.sparse.csgraph.dijkstra(
        graph, indices=0, return_predecessors=True
    )
    goal = min(goals, key=lambda k: far[k])
    if not np.isfinite(far[goal]):
        return None
    way = [goal]
    while way[-1] != 0:
        way.append(int(before[way[-1]]))
    return way[::-1]


def _first_blocked(
    space: FreeSpace, places: np.ndarray, way: list[int]
) -> tuple[int, int] | None:
    """Returns a path's first edge that is not free; None if all are free."""
    for a, b in pairwise(way):
        if not space.is_free_between(places[a], places[b]):
            return a, b
    return None
