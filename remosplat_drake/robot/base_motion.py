"""The motion of a mobile base between two poses, along one arc."""

import math

import numpy as np

from remosplat_drake.base.kernels import kernel


@kernel
def base_command(before, after, n_base):
    """Returns the command that drives the base to a pose in one second.

    A differential base cannot slip sideways, so it may end beside the pose, at
    the end of an arc that starts along its heading. `kinematics.advance` is the
    inverse function.

    Args:
        before: Pose x, y, yaw to start from, shape (3,) [m, m, rad].
        after: Pose to drive to, with yaw not wrapped, shape (3,) [m, m, rad].
        n_base: Number of base commands, 2 or 3.

    Returns:
        Distance forward, distance to the left if n_base is 3, and angle of the
        turn, shape (n_base,) [m, rad].
    """
    turn = after[2] - before[2]
    heading = before[2] + 0.5 * turn
    c, s = math.cos(heading), math.sin(heading)
    # Converts from the chord to the arc, which is longer.
    chord = math.sin(0.5 * turn) / (0.5 * turn) if turn != 0.0 else 1.0
    x, y = (after[0] - before[0]) / chord, (after[1] - before[1]) / chord
    command = np.empty(n_base)
    command[0] = c * x + s * y
    if n_base == 3:
        command[1] = c * y - s * x
    command[n_base - 1] = turn
    return command


def base_way(before: np.ndarray, after: np.ndarray, n_base: int) -> np.ndarray:
    """Computes a base's motion between two poses, shape (n_base,) [m, rad].

    Args:
        before: x, y and yaw, shape (3,) [m, m, rad].
        after: x, y and yaw shortly afterwards; yaw may be wrapped, shape (3,)
            [m, m, rad].
        n_base: Number of base commands, 2 or 3.
    """
    turn = math.remainder(after[2] - before[2], math.tau)
    end = np.array([*after[:2], before[2] + turn])
    return base_command(before, end, n_base)
