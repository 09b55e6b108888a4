"""`Search`: searches a path from a configuration to one of several goals."""

import dataclasses as dc
from collections.abc import Callable
from functools import lru_cache

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
from remosplat_drake.controller.planning.tucked_arm import tucked_arm

_DRAWS = 32
"""Number of configurations that are drawn together."""

_CHUNK = 128
"""Number of motions between two checks for an interruption."""

_SHORTCUTS = 20
"""Number of shortcuts that are tried to shorten a path."""

_TUCKED = 3
"""Of this number of random configurations, one has a tucked arm."""


@dc.dataclass(frozen=True, eq=False)
class Search:
    """Searches paths in a free space. Equal searches find equal paths.

    Attributes:
        space: The free space.
        q: Start of the paths, shape (n_q,) [rad, m].
        bounds: Bounds within which configurations are drawn, each of shape
            (n_q,) [rad, m].
        checks: A search checks at most this many motions.
        seed: Seed of the search.
        interrupted: Function that returns whether to abort the search.
    """

    space: FreeSpace
    q: np.ndarray
    bounds: tuple[np.ndarray, np.ndarray]
    checks: int
    seed: int
    interrupted: Callable[[], bool] = lambda: False

    def straight_to(self, goals: np.ndarray) -> np.ndarray | None:
        """Returns the path to the first goal that a single motion reaches.

        Args:
            goals: Possible ends of the path, the best first, shape (k, n_q)
                [rad, m].

        Returns:
            The start and the goal, shape (2, n_q); None if no motion is free.
        """
        if self.interrupted():
            return None
        goals = np.ascontiguousarray(goals[: self.checks])
        k = self.space.first_reached(self.q, goals)
        return None if k is None else np.stack([self.q, goals[k]])

    def path_to(self, goals: np.ndarray) -> np.ndarray | None:
        """Searches the corners of a path to one of several configurations.

        Args:
            goals: Possible ends of the path, shape (k, n_q) [rad, m].

        Returns:
            The corners, shape (m, n_q); None if no path was found.
        """
        space, left = self.space, self.checks
        trees = Trees.rooted(self.q, goals)
        packed = trees.packed
        rng = np.random.default_rng(self.seed)
        tucked = self._tucked()
        while left > 0 and not self.interrupted():
            most = min(_CHUNK, left)
            grown = trees.with_capacity(most)
            if grown is not trees:
                trees, packed = grown, grown.packed
            draws = self._draws(rng, tucked)
            with space.calls() as line:
                checks, *met = grow(space.arrays, line, packed, draws, most)
            space.checks, left = space.checks + checks, left - checks
            if met[START] != NOT_MET:
                there = trees.branch(START, met[START])[::-1]
                onward = trees.branch(GOAL, met[GOAL])[1:]
                return np.concatenate([there, onward])
        return None

    def shortened(self, corners: np.ndarray) -> np.ndarray:
        """Returns a path with the same ends, usually a faster one.

        Args:
            corners: Corners of a free path, shape (m, n_q) [rad, m].

        Returns:
            Corners of the returned path, shape (p, n_q).
        """
        if len(corners) == 2:
            return corners
        draws = _shortcuts(self.seed)
        with self.space.calls() as line:
            corners, checks = shortened(self.space.arrays, line, corners, draws)
        self.space.checks += checks
        return corners

    def _tucked(self) -> np.ndarray | None:
        """Returns the joints of a tucked arm; None if no base moves the arm."""
        if not self.space.robot.n_base:
            return None
        return tucked_arm(self.space, self.q, self.seed)

    def _draws(
        self, rng: np.random.Generator, tucked: np.ndarray | None
    ) -> np.ndarray:
        """Draws configurations for the growth of trees, shape (k, n_q)."""
        lower, upper = self.bounds
        share = rng.random((_DRAWS, len(self.q)))
        draws = lower + share * (upper - lower)
        if tucked is not None:
            draws[::_TUCKED, -len(tucked) :] = tucked
        return draws


@lru_cache(maxsize=64)
def _shortcuts(seed: int) -> np.ndarray:
    """Returns the ends of random shortcuts; see `kernels/shortcuts.py`."""
    return np.random.default_rng(seed).random((_SHORTCUTS, 2))
