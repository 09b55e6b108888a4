"""Search a path: RRT-Connect of OMPL in our free space.

Kuffner and LaValle 2000. OMPL's random numbers hang on one seed of the whole
process: it is set anew before each search, so that equal searches find equal
paths.
"""

import dataclasses as dc
from collections.abc import Callable
from typing import Any

import numpy as np
from ompl import base as ob
from ompl import geometric as og
from ompl import util as ou

from remosplat_drake.controller.planning.free_space import FreeSpace

_RANGE = 1.5
"""Longest stretch by which a tree grows [rad, m]."""


class _Motions(ob.MotionValidator):
    """Motions between OMPL's states, judged by a `FreeSpace`."""

    def __init__(self, information: ob.SpaceInformation, search: "Search"):
        super().__init__(information)
        self._search = search

    def checkMotion(self, first, second, *last_valid) -> bool:
        """Tells whether a motion is free; OMPL's name for it."""
        a, b = self._search.array(first), self._search.array(second)
        return self._search.space.is_free_between(a, b)


@dc.dataclass(frozen=True, eq=False)
class Search:
    """Searches in some of the dimensions of a free space.

    Attributes:
        space: The free space.
        q: Where paths start, shape (n_q,) [rad, m].
        active: Entries of q that change, shape (n,); the others stay.
        bounds: Bounds between which configurations are drawn, shape (n_q,)
            each [rad, m].
        checks: Number of configurations and motions that one search may look
            at.
        last: Count of the space's checks at which every search ends.
        seed: Seed of the search, at least 1.
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

    def array(self, state) -> np.ndarray:
        """Returns the configuration of one of OMPL's states, shape (n_q,).

        Args:
            state: The state.
        """
        q = self.q.copy()
        for k, j in enumerate(self.active):
            q[j] = state[k]
        return q

    def path_to(self, goals: np.ndarray) -> np.ndarray | None:
        """Searches corners of a path to one of several configurations.

        Args:
            goals: Where it may end, shape (k, n_q) [rad, m].

        Returns:
            The corners, shape (m, n_q); None if no path was found.
        """
        information = self._information()
        problem = ob.ProblemDefinition(information)
        problem.addStartState(self._state(information, self.q))
        goal = ob.GoalStates(information)
        for x in goals:
            goal.addState(self._state(information, x))
        problem.setGoal(goal)
        planner = og.RRTConnect(information)
        planner.setRange(_RANGE)
        planner.setProblemDefinition(problem)
        planner.setup()
        last = min(self.last, self.space.checks + self.checks)
        end = ob.PlannerTerminationCondition(
            lambda: self.space.checks > last or self.interrupted()
        )
        planner.solve(end)
        if not problem.hasExactSolution():
            return None
        return self._corners(problem.getSolutionPath())

    def shortened(self, corners: np.ndarray) -> np.ndarray:
        """Returns a path between the same ends, mostly a shorter one.

        Args:
            corners: Corners of a free path, shape (m, n_q) [rad, m].
        """
        information = self._information()
        path = og.PathGeometric(information)
        for q in corners:
            path.append(self._state(information, q))
        simplifier = og.PathSimplifier(information)
        simplifier.reduceVertices(path)
        simplifier.collapseCloseVertices(path)
        simplifier.partialShortcutPath(path)
        return self._corners(path)

    def _information(self) -> ob.SpaceInformation:
        """Makes what OMPL knows of the space, and sets its random numbers."""
        ou.setLogLevel(ou.LogLevel.LOG_NONE)
        ou.RNG.setSeed(self.seed)
        n = len(self.active)
        states = ob.RealVectorStateSpace(n)
        box = ob.RealVectorBounds(n)
        for k, j in enumerate(self.active):
            box.setLow(k, float(self.bounds[0][j]))
            box.setHigh(k, float(self.bounds[1][j]))
        states.setBounds(box)
        information = ob.SpaceInformation(states)
        information.setStateValidityChecker(
            lambda state: self.space.is_free(self.array(state))
        )
        information.setMotionValidator(_Motions(information, self))
        information.setup()
        return information

    def _state(self, information: ob.SpaceInformation, q: np.ndarray):
        state: Any = information.allocState()
        for k, j in enumerate(self.active):
            state[k] = float(q[j])
        return state

    def _corners(self, path) -> np.ndarray:
        return np.array([self.array(state) for state in path.getStates()])
