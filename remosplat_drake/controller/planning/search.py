"""`Search`: corners of a path from a configuration to one of several."""

import dataclasses as dc
from collections.abc import Callable

import numpy as np

from remosplat_drake.controller.planning.free_space import FreeSpace
from remosplat_drake.controller.planning.kernels.rrt_connect import (
    NOT_MET,
    grow,
)
from remosplat_drake.controller.planning.kernels.shortcuts import shortened
from remosplat_drake.controller.planning.kernels.trees import (
    GOAL,
    START,
    Trees,
)

_DRAWS = 32
"""Number of configurations that are drawn at a time, even."""

_CHUNK = 128
"""Number of motions after which it is asked whether to give up."""

_SHORTCUTS = 20
"""Number of shortcuts that are tried."""


@dc.dataclass(frozen=True, eq=False)
class Search:
    """Searches in some of the dimensions of a free space.

    Equal searches find equal paths.

    Attributes:
        space: The free space.
        q: Where paths start, shape (n_q,) [rad, m].
        active: Entries of q that change, shape (n,); the others stay.
        bounds: Bounds between which configurations are drawn, shape (n_q,)
            each [rad, m].
        checks: Number of motions that one search may look at.
        last: Count of the space's checks at which every search ends.
        seed: Seed of the search.
        interrupted: Function that tells whether to give up at once.
    """

    space: FreeSpace
    q: np.ndarray
    active: np.ndarray
    bounds: tuple[np.ndarray, np.ndarray]
    checks: int
    last: int
    seed: int
    interrupted: Callable[[], bool] = lambda: False

    def path_to(self, goals: np.ndarray) -> np.ndarray | None:
        """Searches corners of a path to one of several configurations.

        Args:
            goals: Where it may end, the best first, shape (k, n_q) [rad, m].

        Returns:
            The corners, shape (m, n_q); None if no path was found.
        """
        straight = self.straight_to(goals)
        return self.grown_to(goals) if straight is None else straight

    def straight_to(self, goals: np.ndarray) -> np.ndarray | None:
        """Returns the start and the first configuration straight ahead of it.

        Args:
            goals: Where a motion may end, the best first, shape (k, n_q).

        Returns:
            Both, shape (2, n_q); None if no single motion is free.
        """
        last = self._last()
        for goal in goals:
            if self.space.checks >= last or self.interrupted():
                return None
            if self.space.is_free_between(self.q, goal):
                return np.stack([self.q, goal])
        return None

    def grown_to(self, goals: np.ndarray) -> np.ndarray | None:
        """Searches corners of a path by trees; see `path_to`.

        Args:
            goals: Where it may end, shape (k, n_q) [rad, m].
        """
        space, last = self.space, self._last()
        trees = Trees.rooted(self.q, goals)
        rng = np.random.default_rng(self.seed)
        while space.checks < last and not self.interrupted():
            most = min(_CHUNK, last - space.checks)
            trees = trees.with_room(most)
            with space.calls() as line:
                checks, *met = grow(
                    space.arrays, line, trees.packed, self._draws(rng), most
                )
            space.checks += checks
            if met[START] != NOT_MET:
                there = trees.branch(START, met[START])[::-1]
                onward = trees.branch(GOAL, met[GOAL])[1:]
                return np.concatenate([there, onward])
        return None

    def shortened(self, corners: np.ndarray) -> np.ndarray:
        """Returns a path between the same ends, mostly a quicker one.

        Args:
            corners: Corners of a free path, shape (m, n_q) [rad, m].

        Returns:
            Its corners, those between turn and drive included, shape (p, n_q).
        """
        if len(corners) == 2:
            return corners
        rng = np.random.default_rng(self.seed)
        draws = rng.uniform(size=(_SHORTCUTS, 2))
        with self.space.calls() as line:
            corners, checks = shortened(
                self.space.arrays, line, corners, draws
            )
        self.space.checks += checks
        return corners

    def _last(self) -> int:
        """Returns the count of checks at which a search that starts ends."""
        return min(self.last, self.space.checks + self.checks)

    def _draws(self, rng: np.random.Generator) -> np.ndarray:
        """Draws configurations to grow to, shape (k, n_q)."""
        lower, upper = (bound[self.active] for bound in self.bounds)
        draws = np.tile(self.q, (_DRAWS, 1))
        share = rng.random((_DRAWS, len(self.active)))
        draws[:, self.active] = lower + share * (upper - lower)
        return draws
