"""Steering: the motion between two configurations, in stretches of held u.

An arm moves on the straight line between its joints. A differential base
cannot slip sideways: it turns towards the place, drives there, and turns. An
omnidirectional one drives and turns at once, on arcs so short that they stay
beside the straight line. The arm's joints move along, evenly over the whole
way.
"""

import math

import numpy as np

from remosplat_drake.robot.base_motion import base_command
from remosplat_drake.robot.robot_model import RobotModel

_NO_WAY = 1e-6
"""Distance below which the base need not drive [m]."""

_ARC = 0.2
"""Largest turn on an arc of an omnidirectional base: it is off the straight
line by at most a fortieth of its length [rad]."""


def waypoints(
    robot: RobotModel, a: np.ndarray, b: np.ndarray, backing: float = 0.0
) -> np.ndarray:
    """Returns the corners of the motion from a to b, both ends included.

    Between two corners the robot moves on a straight line through q, on which
    a differential base either turns or drives.

    Args:
        robot: The robot.
        a: Configuration to start from, shape (n_q,) [rad, m].
        b: Configuration to end at, shape (n_q,) [rad, m].
        backing: Longest way that the base may drive backwards [m].

    Returns:
        The corners, shape (k, n_q).
    """
    if not robot.n_base:
        return np.stack([a, b])
    x, y = b[0] - a[0], b[1] - a[1]
    way = math.hypot(x, y)
    last = a[2] + wrapped(b[2] - a[2])
    if robot.is_omnidirectional:
        pieces = 1 if way < _NO_WAY else math.ceil(abs(last - a[2]) / _ARC)
        end = b.copy()
        end[2] = last
        return np.linspace(a, end, max(pieces, 1) + 1)
    if way < _NO_WAY:
        end = b.copy()
        end[2] = last
        return np.stack([a, end])
    heading = math.atan2(y, x)
    forward = a[2] + wrapped(heading - a[2])
    headings = [forward]
    if way <= backing:
        headings.append(a[2] + wrapped(heading + math.pi - a[2]))
    turns = [abs(h - a[2]) + abs(wrapped(b[2] - h)) for h in headings]
    h = headings[int(np.argmin(turns))]
    last = h + wrapped(b[2] - h)
    # The share of the whole at which each of the three parts ends.
    parts = np.array([abs(h - a[2]), way, abs(last - h)])
    share = np.cumsum(parts) / parts.sum()
    corners = np.empty((4, len(a)))
    corners[0] = a
    for k in range(3):
        corners[k + 1] = a + share[k] * (b - a)
    corners[1, :3] = a[0], a[1], h
    corners[2, :3] = b[0], b[1], h
    corners[3] = b
    corners[3, 2] = last
    moved = np.abs(np.diff(corners, axis=0)).max(axis=1) > 1e-12
    return corners[np.concatenate([[True], moved])]


def held_command(robot: RobotModel, a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Returns the u that, held for one second, leads from corner a to b.

    Args:
        robot: The robot.
        a: A corner of a motion, shape (n_q,) [rad, m].
        b: The next corner, shape (n_q,) [rad, m].

    Returns:
        The command, shape (n_u,).
    """
    if not robot.n_base:
        return b - a
    base = base_command(a[:3], b[:3], robot.n_base)
    return np.concatenate([base, b[3:] - a[3:]])


def wrapped(angle: float) -> float:
    """Returns the angle in [-pi, pi) that points the same way [rad]."""
    return (angle + math.pi) % (2.0 * math.pi) - math.pi
