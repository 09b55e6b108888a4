"""Steering: computes a motion between two configurations.

The command u of the motion is piecewise constant. An arm without a base moves
on a straight line in joint space. A differential base cannot move sideways, so
it turns towards the goal, drives to the goal, and turns again. An
omnidirectional base drives and turns at the same time, on arcs that are so
short that they are near the straight line. During the motion of a base, the
arm's joints move at constant rates.
"""

import math

import numpy as np

from remosplat_drake.base.kernels import helper, kernel
from remosplat_drake.base.kernels.returns import reals
from remosplat_drake.robot.base_motion import base_command

_NO_WAY = 1e-6
"""Distance below which the base does not drive [m]."""

_ARC = 0.2
"""Largest turn on an arc of an omnidirectional base [rad]. With this turn, an
arc deviates from the straight line by at most a fortieth of its length."""

_NO_MOTION = 1e-12
"""Change of q below which two corners count as one [rad, m]."""


@kernel
def waypoints(a, b, n_base, backing):
    """Returns the corners of the motion from a to b, including a and b.

    Between two corners, the robot moves on a straight line in q, on which a
    differential base either turns or drives.

    Args:
        a: Configuration at the start, shape (n_q,) [rad, m].
        b: Configuration at the end, shape (n_q,) [rad, m].
        n_base: Number of base commands, 3, 2 or 0.
        backing: Longest distance that the base may drive backwards [m].

    Returns:
        The corners, shape (k, n_q).
    """
    if n_base == 0:
        return _straight(a, b, 1)
    end = b.copy()
    end[2] = a[2] + wrapped(b[2] - a[2])
    x, y = b[0] - a[0], b[1] - a[1]
    way = math.hypot(x, y)
    if n_base == 3:
        turn = abs(end[2] - a[2])
        pieces = 1 if way < _NO_WAY else math.ceil(turn / _ARC)
        return _straight(a, end, max(pieces, 1))
    if way < _NO_WAY:
        return _straight(a, end, 1)
    return _turned_and_driven(a, b, x, y, backing)


@helper
def _straight(a, end, pieces):
    """Returns the corners of a straight line, divided into equal pieces."""
    corners = np.empty((pieces + 1, len(a)))
    for k in range(pieces + 1):
        for j in range(len(a)):
            corners[k, j] = a[j] + k / pieces * (end[j] - a[j])
    for j in range(len(a)):
        corners[pieces, j] = end[j]
    return corners


@helper
def _turned_and_driven(a, b, x, y, backing):
    """Returns the corners of a base's motion: turn, drive, turn."""
    way, heading = math.hypot(x, y), math.atan2(y, x)
    h = a[2] + wrapped(heading - a[2])
    if way <= backing:
        back = a[2] + wrapped(heading + math.pi - a[2])
        if _turn(a, b, back) < _turn(a, b, h):
            h = back
    # These are the fractions of the motion at which the three parts end.
    first, last = abs(h - a[2]), abs(wrapped(b[2] - h))
    whole = first + way + last
    corners = np.empty((4, len(a)))
    for j in range(len(a)):
        corners[0, j] = a[j]
        corners[1, j] = a[j] + first / whole * (b[j] - a[j])
        corners[2, j] = a[j] + (first + way) / whole * (b[j] - a[j])
        corners[3, j] = b[j]
    corners[1, 0], corners[1, 1], corners[1, 2] = a[0], a[1], h
    corners[2, 0], corners[2, 1], corners[2, 2] = b[0], b[1], h
    corners[3, 2] = h + wrapped(b[2] - h)
    count = 1
    for k in range(1, 4):
        change = 0.0
        for j in range(len(a)):
            change = max(change, abs(corners[k, j] - corners[k - 1, j]))
        if change > _NO_MOTION:
            for j in range(len(a)):
                corners[count, j] = corners[k, j]
            count += 1
    return corners[:count]


@helper
def _turn(a, b, heading):
    """Returns the total turn of a base that drives along a heading [rad]."""
    return abs(heading - a[2]) + abs(wrapped(b[2] - heading))


@kernel
def segment_command(a, b, n_base):
    """Returns the command u that leads from corner a to b in one second.

    Args:
        a: A corner of a motion, shape (n_q,) [rad, m].
        b: The next corner, shape (n_q,) [rad, m].
        n_base: Number of base commands, 3, 2 or 0.

    Returns:
        The command, shape (n_u,).
    """
    first = 3 if n_base else 0
    u = np.empty(len(a) - first + n_base)
    if n_base:
        base = base_command(a[:3], b[:3], n_base)
        for j in range(n_base):
            u[j] = base[j]
    for j in range(first, len(a)):
        u[n_base + j - first] = b[j] - a[j]
    return u


@kernel(returns=reals(2))
def segment_commands(corners, n_base):
    """Computes `segment_command` from each corner to the next, (k, n_u).

    Args:
        corners: Corners of a motion, shape (k + 1, n_q) [rad, m].
        n_base: Number of base commands, 3, 2 or 0.
    """
    k, n_q = len(corners) - 1, corners.shape[1]
    commands = np.empty((k, n_q - 3 + n_base if n_base else n_q))
    for i in range(k):
        commands[i] = segment_command(corners[i], corners[i + 1], n_base)
    return commands


@kernel(linked=True)
def wrapped(angle):
    """Wraps an angle to [-pi, pi) [rad]."""
    return (angle + math.pi) % (2.0 * math.pi) - math.pi
