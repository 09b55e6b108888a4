"""How a mobile base comes from one pose to another: along one arc."""

import math

import numpy as np


def base_command(
    before: np.ndarray, after: np.ndarray, n_base: int
) -> np.ndarray:
    """Returns the command that, held for a second, leads to another pose.

    A differential base cannot slip: it gets as near as an arc from its heading
    leads. `kinematics.advance` is the inverse.

    Args:
        before: Pose x, y, yaw to start from, shape (3,) [m, m, rad].
        after: Pose to end at, its yaw not wrapped, shape (3,) [m, m, rad].
        n_base: Number of base commands, 2 or 3.

    Returns:
        Way forward, with three commands the way to the left, and the turn,
        shape (n_base,) [m, rad].
    """
    turn = after[2] - before[2]
    heading = before[2] + 0.5 * turn
    c, s = math.cos(heading), math.sin(heading)
    x, y = (after - before)[:2] / np.sinc(0.5 * turn / math.pi)
    ways = [c * x + s * y, c * y - s * x][: n_base - 1]
    return np.array([*ways, turn])


def base_way(before: np.ndarray, after: np.ndarray, n_base: int) -> np.ndarray:
    """Measures how far a base has come between two poses, shape (n_base,).

    Args:
        before: x, y and yaw, shape (3,) [m, m, rad].
        after: The same a little later, in any turn.
        n_base: Number of base commands, 2 or 3.
    """
    turn = math.remainder(after[2] - before[2], math.tau)
    end = np.array([*after[:2], before[2] + turn])
    return base_command(before, end, n_base)
