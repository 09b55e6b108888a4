"""Computes bounds of the motion of one link relative to another.

The motion is that between two samples. Let the core of a shape of link B be a
hull within the radius r of its centre C. Let p be the position of C, and R the
orientation of B, both in A. Relative to A, each point of the hull moves by at
most the motion of C plus r times the angle by which B turns. No distance
between A and B changes by more than this sum.

The bounds of the motion of C and of the angle are those of `between_samples`.
For the angle, the matrix R is treated as a point. The Frobenius norm of its
velocity is sqrt(2) times the angular speed. Its acceleration is at most sqrt(2)
times the square of the sum of all joint speeds between A and B.
"""

import math

import numpy as np

from remosplat_drake.base.kernels import helper


@helper
def relative_bend(lever, turns, speed, offset, reach):
    """Returns a bound of the acceleration of a shape's points [m/s^2].

    It is the argument `bend` of `relative_way`, and includes the motion of the
    centre and the rotation.

    Args:
        lever: The result of `relative_motion.levers` for the two links, shape
            (n_u,) [m].
        turns: Whether each command is that of a revolute joint, shape (n_u,),
            bool.
        speed: Absolute values of the command, shape (n_u,).
        offset: Distance of the shape's centre from its link's origin [m].
        reach: Largest distance of the hull's points from the centre [m].
    """
    total, turn = 0.0, 0.0
    for a in range(len(speed)):
        if lever[a] < 0.0:
            continue
        if turns[a]:
            turn += speed[a]
        for b in range(len(speed)):
            if lever[b] < 0.0:
                continue
            if turns[a] and turns[b]:
                # The joint nearer to A carries the joint nearer to B.
                arm = min(lever[a], lever[b]) + offset
                total += arm * speed[a] * speed[b]
            elif turns[a] or turns[b]:
                total += speed[a] * speed[b]
    return total + reach * turn * turn


@helper
def relative_way(X_WL, Y_WL, a, b, center, reach, bend, time):
    """Bounds the path, relative to A, of any point on a shape of B [m].

    Args:
        X_WL: Poses of all bodies at one sample, shape (n, 4, 4).
        Y_WL: Poses of all bodies at another sample, shape (n, 4, 4).
        a: Body A.
        b: Body B.
        center: Centre of the shape in B, shape (3,) [m].
        reach: Largest distance of the hull's points from the centre [m].
        bend: The result of `relative_bend` [m/s^2].
        time: Time between the samples [s].
    """
    moved, turned = 0.0, 0.0
    for r in range(3):
        step = _center_seen(X_WL, a, b, center, r)
        step -= _center_seen(Y_WL, a, b, center, r)
        moved += step * step
        for c in range(3):
            entry = 0.0
            for k in range(3):
                entry += X_WL[a, k, r] * X_WL[b, k, c]
                entry -= Y_WL[a, k, r] * Y_WL[b, k, c]
            turned += entry * entry
    way = math.sqrt(moved) + reach * math.sqrt(0.5 * turned)
    return way + bend * time * time / 3.0


@helper
def _center_seen(X_WL, a, b, center, r):
    """Returns coordinate r in A of a point of B [m]."""
    seen = 0.0
    for k in range(3):
        p_W = X_WL[b, k, 3] - X_WL[a, k, 3]
        for c in range(3):
            p_W += X_WL[b, k, c] * center[c]
        seen += X_WL[a, k, r] * p_W
    return seen


@helper
def travels(path, rate):
    """Returns bounds of changes of distances up to the ends of s pieces.

    Args:
        path: The `PathArrays`.
        rate: Bounds of the rate of the distance of each pair of links, per
            entry of the command, shape (l, n_u).

    Returns:
        The bounds at the start and at the ends of the pieces, shape (l, s + 1)
        [m].
    """
    rates, since, times = path.rates, path.since, path.times
    travel = np.zeros((len(rate), len(since) + 1))
    for k in range(len(rate)):
        for s in range(len(since)):
            end = since[s + 1] if s + 1 < len(since) else times[-1]
            change = 0.0
            for c in range(rates.shape[1]):
                change += rate[k, c] * abs(rates[s, c]) * (end - since[s])
            travel[k, s + 1] = travel[k, s] + change
    return travel
