"""Finds a compact posture of the arm, to drive through narrow passages.

A search in ten dimensions rarely finds a way through a narrow door. With a
fixed, compact arm posture, only the three dimensions of the base remain.
"""

import numpy as np

from remosplat_drake.controller.planning.free_space import FreeSpace

_DRAWS = 200
"""Number of random arm postures. The most compact free posture is used."""


def tucked_arm(space: FreeSpace, q: np.ndarray, seed: int) -> np.ndarray:
    """Finds a compact arm posture that is free at the robot's base pose.

    Args:
        space: The free space.
        q: Present configuration, shape (n_q,) [rad, m].
        seed: Seed of the random postures.

    Returns:
        The arm's joint positions, shape (n_arm,) [rad, m]; the present
        positions if no other posture is free.
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
    """Measures the arm's largest distance from the base's axis, (k,) [m]."""
    robot = space.robot
    k, n = len(q), len(robot.spheres)
    spheres = robot.spheres_of_all(q)
    away = spheres.p_WS[:, :2] - np.repeat(q[:, :2], n, axis=0)
    return (np.hypot(*away.T) + spheres.radius).reshape(k, n).max(axis=1)
