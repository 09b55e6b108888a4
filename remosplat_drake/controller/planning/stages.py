"""A path with a mobile base, in stages: tuck the arm, drive, reach out.

Ten dimensions are many where a door is narrow. With the arm tucked in, the
base's three are left; what is found so is shortened in all ten together.
"""

import dataclasses as dc

import numpy as np

from remosplat_drake.controller.planning.free_space import FreeSpace
from remosplat_drake.controller.planning.search import Search

_SHARE = 3
"""Share of the budget that a single stage may spend, as its divisor."""

_DRAWS = 200
"""Number of arms among which the most slender is taken."""


def staged_path(search: Search, goals: np.ndarray) -> np.ndarray | None:
    """Searches corners of a path on which the base drives with a tucked arm.

    Args:
        search: The search in all dimensions.
        goals: Where it may end, the best first, shape (k, n_q) [rad, m].

    Returns:
        The corners, shape (m, n_q); None if no path was found.
    """
    space, start = search.space, search.q
    # What is hopeless shall leave something to the others.
    search = dc.replace(search, checks=search.checks // _SHARE)
    base = space.robot.n_q - len(space.robot.home)
    drive, reach = np.arange(base), np.arange(base, space.robot.n_q)
    arm = tucked_arm(space, start, search.seed)
    tucked = np.concatenate([start[:base], arm])
    tucked_goals = np.array([[*goal[:base], *arm] for goal in goals])
    open_goals = [space.is_free(q) for q in tucked_goals]
    if not any(open_goals):
        return None
    first = dc.replace(search, active=reach).path_to(tucked[None])
    if first is None:
        return None
    for k in np.flatnonzero(open_goals):
        # Backwards: at the target there is little room.
        last = dc.replace(search, q=tucked_goals[k], active=reach).path_to(
            goals[k][None]
        )
        if last is None:
            continue
        way = dc.replace(search, q=tucked, active=drive).path_to(
            tucked_goals[k][None]
        )
        if way is not None:
            return np.concatenate([first, way[1:], last[1:]])
    return None


def tucked_arm(space: FreeSpace, q: np.ndarray, seed: int) -> np.ndarray:
    """Finds an arm that sticks out little, free where the robot stands.

    Args:
        space: The free space.
        q: Where the robot is, shape (n_q,) [rad, m].
        seed: Seed of the arms that are drawn.

    Returns:
        The arm's joints, shape (n_arm,) [rad, m]; the present ones if none
        other is free.
    """
    robot = space.robot
    arm = slice(robot.n_q - len(robot.home), None)
    rng = np.random.default_rng(seed)
    draws = np.tile(q, (_DRAWS, 1))
    draws[:, arm] = rng.uniform(
        space.lower[arm], space.upper[arm], (_DRAWS, len(robot.home))
    )
    draws[0, arm] = robot.home
    out = _stick_out(space, draws)
    for k in np.argsort(out, kind="stable"):
        if space.is_free(draws[k]):
            return draws[k, arm]
    return q[arm]


def _stick_out(space: FreeSpace, q: np.ndarray) -> np.ndarray:
    """Measures how far spheres are from the base's vertical axis, (k,) [m]."""
    robot = space.robot
    k, n = len(q), len(robot.spheres)
    spheres = robot.place_spheres(
        q, np.repeat(np.arange(k), n), np.tile(np.arange(n), k)
    )
    away = spheres.p_WS[:, :2] - np.repeat(q[:, :2], n, axis=0)
    return (np.hypot(*away.T) + spheres.radius).reshape(k, n).max(axis=1)
