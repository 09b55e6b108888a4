"""`Roadmap`: the corners of earlier paths, for searches that come after.

Its edges count as free until a path uses them; only then are they checked
(Bohlin and Kavraki 2000). So it outlives maps, targets and stopping distances.
"""

import dataclasses as dc
from itertools import pairwise

import numpy as np
import scipy

from remosplat_drake.controller.planning.free_space import FreeSpace

_NEIGHBOURS = 6
"""Number of corners to which start and goals are tied."""

_UNKNOWN = 4.0
"""How much dearer a tie is than an edge that a path has had."""

_NO_WAY = 1e-9
"""Additional cost of an edge: SciPy treats a zero as no edge [rad, m]."""

_MOST = 400
"""Largest number of corners that are remembered, the latest."""

_TRIES = 12
"""Number of blocked paths after which nothing more is tried."""


@dc.dataclass(frozen=True, eq=False)
class Roadmap:
    """Configurations, and between which of them a robot has driven or may.

    Attributes:
        q: Corners, shape (m, n_q) [rad, m]; None if there is none.
        edges: Pairs of corners that followed each other, shape (e, 2).
    """

    q: np.ndarray | None = None
    edges: np.ndarray = dc.field(default_factory=lambda: np.zeros((0, 2), int))

    def with_path(self, corners: np.ndarray) -> "Roadmap":
        """Returns the roadmap with another path.

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
        """Finds a free path along remembered corners.

        Args:
            space: The present free space.
            q: Where the path starts, shape (n_q,) [rad, m].
            goals: Where it may end, shape (k, n_q) [rad, m].

        Returns:
            The corners, shape (m, n_q); None if the roadmap holds none.
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
"""Nothing is remembered."""


def _distance(q: np.ndarray, other: np.ndarray) -> np.ndarray:
    """How far configurations (..., n_q) are from one, (...) [rad, m]."""
    return np.abs(other - q).max(axis=-1) + _NO_WAY


def _shortest(cost: dict, count: int, goals: range) -> list[int] | None:
    """Finds the cheapest way from place 0 to a goal, as places."""
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
    """The first step of a way that is not free; None if all are."""
    for a, b in pairwise(way):
        if not space.is_free_between(places[a], places[b]):
            return a, b
    return None
