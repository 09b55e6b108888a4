"""Bend the servo's velocity round what is in the hand's way."""

import math

import numpy as np

from remosplat_drake.base.kernels import helper
from remosplat_drake.base.vectors import dot, norm
from remosplat_drake.controller.guidance.guidance import Guidance
from remosplat_drake.robot.pose_error import PoseError
from remosplat_drake.signals.distance_field import Clearances

NEAR = 0.10
"""Clearance within which an obstacle bends the path, d_c [m]."""

_PASSED = 0.05
"""Depth at which a sphere would stand in the obstacle at the target for the
obstacle to count in full [m]."""


def deflected_velocity(
    v_WE: np.ndarray,
    error: PoseError,
    clearances: Clearances,
    leading: np.ndarray,
    guidance: Guidance,
    stopping: float,
    max_speed: float,
) -> np.ndarray:
    """Bends the servo's translational velocity to the guidance's side.

    An obstacle counts if it is near a leading sphere (w), ahead of it (a)
    and still in its way at the target (b): without b, the table top on which
    the target lies would count as something to go round. The direction then
    turns from straight ahead to along the obstacle, horizontally.

    Args:
        v_WE: Desired velocity of E in W, shape (3,) [m/s].
        error: The pose error from the end effector E to the target T.
        clearances: The oracle's distances and directions at the tick.
        leading: Whether each sphere moves with the hand, shape (n,) bool.
        guidance: How the tick is bent; its side matters here.
        stopping: Stopping distance d_s of this tick [m].
        max_speed: The servo's bound on |v_WE| [m/s].

    Returns:
        The bent velocity of E in W, shape (3,) [m/s].
    """
    speed = math.hypot(*v_WE)
    if guidance.side == 0.0 or speed == 0.0:
        return v_WE
    rows = np.flatnonzero(
        leading[clearances.sphere] & (clearances.distance < NEAR)
    )
    if not len(rows):
        return v_WE
    ahead_W = v_WE / speed
    d = clearances.distance[rows]
    away_W = -clearances.direction_W[rows]
    w = (NEAR - d) / (NEAR - stopping)
    a = (0.1 - away_W @ ahead_W) / 0.4
    b = -(d + away_W @ error.p_ET_W) / _PASSED
    f = np.prod(np.minimum(np.maximum([w, a, b], 0.0), 1.0), axis=0)
    strength = float(f.max())
    if strength == 0.0:
        return v_WE
    mean_W = f**3 @ away_W
    norm = math.hypot(*mean_W)
    if norm == 0.0:
        return v_WE
    n_W = mean_W / norm
    along_W = guidance.side * np.array([n_W[1], -n_W[0], 0.0])  # n x z
    direction = (1.0 - strength) * ahead_W + strength * along_W
    length = math.hypot(*direction)
    if length < 1e-9:
        return v_WE
    return max(speed, 0.6 * strength * max_speed) * direction / length


@helper
def deflection(v_WE, p_ET_W, rows, leading, side, stopping, max_speed):
    """Computes what `deflected_velocity` does, for kernels, shape (3,) [m/s].

    Args:
        v_WE: Desired velocity of E in W, shape (3,) [m/s].
        p_ET_W: Translation from end effector to target, shape (3,) [m].
        rows: Spheres, distances and directions of the m clearances.
        leading: Whether each sphere moves with the hand, shape (n,) bool.
        side: The guidance's side.
        stopping: Stopping distance d_s of this tick [m].
        max_speed: The servo's bound on |v_WE| [m/s].
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
    """x, cut off at 0 and at 1."""
    return min(max(x, 0.0), 1.0)
