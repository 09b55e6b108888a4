"""Deflects the servo's velocity around obstacles near the hand."""

import numpy as np

from remosplat_drake.base.kernels import helper
from remosplat_drake.base.vectors import dot, norm

NEAR = 0.10
"""Clearance d_c below which an obstacle deflects the velocity [m]."""

_PASSED = 0.05
"""Depth from which on an obstacle has its full weight [m]. The depth is the
distance by which a sphere of the hand would enter the obstacle if the end
effector moved straight to the target.
"""


@helper
def deflection(v_WE, p_ET_W, rows, leading, side, stopping, max_speed):
    """Deflects the servo's translational velocity to the side of guidance.

    The weight of an obstacle is the product of three factors from 0 to 1. The
    factor w is large if the obstacle is near a sphere of the hand, a if the
    obstacle is ahead of this sphere, and b if the straight way to the target
    leads into the obstacle. Without b, the robot would try to go around a table
    top on which the target is. With increasing weight, the direction of motion
    is rotated horizontally, from the direction of the target to a direction
    along the obstacle.

    Args:
        v_WE: Desired velocity of E in W, shape (3,) [m/s].
        p_ET_W: Translation from end effector to target, shape (3,) [m].
        rows: Spheres, distances and directions of the m clearances.
        leading: Whether each sphere moves with the hand, shape (n,), bool.
        side: The side on which guidance passes obstacles: 1 for left, -1 for
            right, or 0 for neither.
        stopping: Stopping distance d_s of this tick [m].
        max_speed: The servo's bound on |v_WE| [m/s].

    Returns:
        The deflected velocity of E in W, shape (3,) [m/s].
    """
    sphere, distance, direction_W = rows
    speed = norm(v_WE)
    if side == 0.0 or speed == 0.0:
        return v_WE
    strength, mean_W = 0.0, np.zeros(3)
    for i in range(len(sphere)):
        d = distance[i]
        if not (leading[sphere[i]] and d < NEAR):
            continue
        w = (NEAR - d) / (NEAR - stopping)
        a = (0.1 + dot(direction_W[i], v_WE) / speed) / 0.4
        b = (dot(direction_W[i], p_ET_W) - d) / _PASSED
        f = _share(w) * _share(a) * _share(b)
        strength = max(strength, f)
        for c in range(3):
            mean_W[c] -= f**3 * direction_W[i, c]
    if strength == 0.0 or norm(mean_W) == 0.0:
        return v_WE
    turn = side * strength / norm(mean_W)
    along = (turn * mean_W[1], -turn * mean_W[0], 0.0)  # n x z
    bent_W = np.empty(3)
    for c in range(3):
        bent_W[c] = (1.0 - strength) * v_WE[c] / speed + along[c]
    length = norm(bent_W)
    if length < 1e-9:
        return v_WE
    for c in range(3):
        bent_W[c] *= max(speed, 0.6 * strength * max_speed) / length
    return bent_W


@helper
def _share(x):
    """Returns x, clamped to [0, 1]."""
    return min(max(x, 0.0), 1.0)
