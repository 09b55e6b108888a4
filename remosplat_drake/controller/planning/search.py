"""Search a path: RRT-Connect of OMPL in our free space.

Kuffner and LaValle 2000. OMPL's random numbers hang on one seed of the whole
process: it is set anew before each search, so that equal searches find equal
paths.
"""

from collections.abc import Callable

import numpy as np
from ompl import base as ob
from ompl import geometric as og
from ompl import util as ou

from remosplat_drake.controller.planning.free_space import FreeSpace

_RANGE = 1.5
"""Longest stretch by which a tree grows [rad, m]."""


class _Motions(ob.MotionValidator):
    """Motions between OMPL's states, judged by a `FreeSpace`."""

    def __init__(self, information: ob.SpaceInformation, space: FreeSpace):
        super().__init__(information)
        self._space = space
        self._n = space.robot.n_q

    def checkMotion(self, first, second, *last_valid) -> bool:
        """Tells whether a motion is free; OMPL's name for it."""
        a, b = _array(first, self._n), _array(second, self._n)
        return self._space.is_free_between(a, b)


def search_path(
    space: FreeSpace,
    q: np.ndarray,
    goals: np.ndarray,
    *,
    checks: int,
    seed: int,
    bounds: tuple[np.ndarray, np.ndarray],
    interrupted: Callable[[], bool] = lambda: False,
) -> np.ndarray | None:
    """Searches corners of a path from a configuration to one of several.

    Args:
        space: The free space.
        q: Where the path starts, shape (n_q,) [rad, m].
        goals: Where it may end, shape (k, n_q) [rad, m].
        checks: Number of configurations and motions that may be looked at.
        seed: Seed of the search, at least 1.
        bounds: Bounds between which configurations are drawn, shape (n_q,)
            each [rad, m].
        interrupted: Function that tells whether to give up at once.

    Returns:
        The corners, shape (m, n_q); None if no path was found.
    """
    ou.setLogLevel(ou.LogLevel.LOG_NONE)
    ou.RNG.setSeed(seed)
    n = len(q)
    states = ob.RealVectorStateSpace(n)
    box = ob.RealVectorBounds(n)
    for j in range(n):
        box.setLow(j, float(bounds[0][j]))
        box.setHigh(j, float(bounds[1][j]))
    states.setBounds(box)
    information = ob.SpaceInformation(states)
    information.setStateValidityChecker(
        lambda state: space.is_free(_array(state, n))
    )
    motions = _Motions(information, space)
    information.setMotionValidator(motions)
    information.setup()
    problem = ob.ProblemDefinition(information)
    problem.addStartState(_state(states, q))
    goal = ob.GoalStates(information)
    for x in goals:
        goal.addState(_state(states, x))
    problem.setGoal(goal)
    planner = og.RRTConnect(information)
    planner.setRange(_RANGE)
    planner.setProblemDefinition(problem)
    planner.setup()
    last = space.checks + checks
    end = ob.PlannerTerminationCondition(
        lambda: space.checks > last or interrupted()
    )
    planner.solve(end)
    if not problem.hasExactSolution():
        return None
    path = problem.getSolutionPath()
    simplifier = og.PathSimplifier(information)
    simplifier.reduceVertices(path)
    simplifier.collapseCloseVertices(path)
    simplifier.partialShortcutPath(path)
    return np.array([_array(state, n) for state in path.getStates()])


def _array(state, n: int) -> np.ndarray:
    return np.array([state[j] for j in range(n)])


def _state(states: ob.RealVectorStateSpace, q: np.ndarray):
    state = states.allocState()
    for j in range(len(q)):
        state[j] = float(q[j])
    return state
