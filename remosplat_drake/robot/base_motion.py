"""The way of a mobile base from one pose to another: one arc."""

import math

import numpy as np

from remosplat_drake.base.kernels import kernel


@kernel
def base_command(before, after, n_base):
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
    # The chord of an arc is shorter than the arc.
    chord = math.sin(0.5 * turn) / (0.5 * turn) if turn != 0.0 else 1.0
    x, y = (after[0] - before[0]) / chord, (after[1] - before[1]) / chord
    command = np.empty(n_base)
    command[0] = c * x + s * y
    if n_base == 3:
        command[1] = c * y - s * x
    command[n_base - 1] = turn
    return command


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
