"""Compiled functions for motions along paths, and their differences.

`base_residual_reference.py` computes the same with arrays.
"""

import math

import numpy as np

from remosplat_drake.base.kernels import helper, kernel


@helper
def _relative(before, after):
    """The pose `after` relative to `before`, with yaw in [-pi, pi)."""
    x, y = after[0] - before[0], after[1] - before[1]
    c, s = math.cos(before[2]), math.sin(before[2])
    yaw = (after[2] - before[2] + math.pi) % (2.0 * math.pi) - math.pi
    return c * x + s * y, c * y - s * x, yaw


@helper
def _pose(rows, held, time):
    """Pose on a path at a time."""
    low, high = 0, len(rows)
    while low < high:
        middle = (low + high) // 2
        if rows[middle, 0] <= time:
            low = middle + 1
        else:
            high = middle
    row = rows[max(low - 1, 0)]
    late = min(max(time - row[0], 0.0), held)
    half = 0.5 * row[6] * late
    share = late
    if half != 0.0:
        share *= math.sin(half) / half
    c, s = share * math.cos(row[3] + half), share * math.sin(row[3] + half)
    return (
        row[1] + row[4] * c - row[5] * s,
        row[2] + row[4] * s + row[5] * c,
        row[3] + 2.0 * half,
    )


@kernel
def path_motions(rows, held, start, end):
    """Computes the same as `ArcPath.motions`."""
    motions = np.empty((len(start), 3))
    for i in range(len(start)):
        before = _pose(rows, held, start[i])
        motions[i] = _relative(before, _pose(rows, held, end[i]))
    return motions


@helper
def _size(motion):
    """Length and angle of a motion."""
    return math.hypot(motion[0], motion[1]), abs(motion[2])


@kernel
def path_residuals(rows, held, start, end, moved, late, slack, share):
    """Computes the same as `ArcPath.residuals`, for given delays `late`."""
    n, k = len(start), len(late)
    fitting, excess = np.empty((n, 3)), np.empty(n)
    told = np.empty((k, 3))
    for i in range(n):
        length, angle = _size(moved[i])
        shift_spread = angle_spread = 0.0
        for j in range(k):
            before = _pose(rows, held, start[i] - late[j])
            told[j] = _relative(before, _pose(rows, held, end[i] - late[j]))
            told_length, told_angle = _size(told[j])
            length, angle = max(length, told_length), max(angle, told_angle)
            if j:
                shift, turn = _size(_relative(told[j - 1], told[j]))
                shift_spread = max(shift_spread, shift)
                angle_spread = max(angle_spread, turn)
        turn_allowed = slack[1] + share * angle + 0.5 * angle_spread
        # An error of the heading rotates the motion.
        shift_allowed = slack[0] + share * length + 0.5 * shift_spread
        shift_allowed += 0.5 * turn_allowed * length
        excess[i] = math.inf
        for j in range(k):
            shift, turn = _size(_relative(told[j], moved[i]))
            value = max(shift / shift_allowed, turn / turn_allowed)
            known = shift == shift and turn == turn
            if not known or value < excess[i]:
                fitting[i] = told[j]
                excess[i] = value if known else math.nan
            if not known:
                break
    return fitting, excess
