"""The arm that sticks out least: a base drives where there is little room.

Ten dimensions are many where a door is narrow. With the arm tucked in, the
base's three are left.
"""

import numpy as np

from remosplat_drake.controller.planning.free_space import FreeSpace

_DRAWS = 200
"""Number of arms among which the most slender is taken."""


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
    spheres = robot.spheres_of_all(q)
    away = spheres.p_WS[:, :2] - np.repeat(q[:, :2], n, axis=0)
    return (np.hypot(*away.T) + spheres.radius).reshape(k, n).max(axis=1)
