"""Checks for self-collision, at a configuration or along a motion.

The rate at which the distance between two links changes is bounded. So a motion
is sampled from coarse to fine, for each pair of links. The room of a pair is
its distance minus the required one. If the rooms at both ends of a part add up
to more than the possible change of the distance on that part, no sample in
between is needed.
"""

import numpy as np

from remosplat_drake.base.kernels import helper, kernel
from remosplat_drake.base.kernels.returns import TRUTH
from remosplat_drake.controller.planning.kernels.own_work import MOST
from remosplat_drake.robot.kinematics import advance, body_poses, copy_poses
from remosplat_drake.robot.self_collision.kernels.pair_distance import (
    least_distance,
    place_centers,
    shape_distance,
)

_BLINK = 0.01
"""Relative motion of two shapes between the finest samples [m]. Between these,
their distance may be smaller than required; verification samples more finely.
"""

_FINE = 0.05
"""Distance of a pair, minus the required one, above which coarse bounds suffice
[m]: there, more samples are cheaper than exact distances."""

_ROUNDING = 1e-9
"""Bound on rounding errors of distances [m]."""


@kernel(returns=TRUTH)
def is_off_itself(space, X_WL):
    """Returns whether all pairs of shapes keep their distances.

    Args:
        space: The `SpaceArrays`.
        X_WL: Poses of all bodies, shape (b, 4, 4).
    """
    space.own_work.guess[:] = 0.0
    _keep_look(space, X_WL, 0)
    for link in range(len(space.own.pairs.boxes)):
        # The boxes show that most links are far apart.
        if _link_room(space, link, 0) >= 0.0:
            continue
        if _room(space, link, 0, 0.0) < -_ROUNDING:
            return False
    return True


@kernel(returns=TRUTH)
def keeps_off_itself(space, q, u):
    """Returns whether all pairs of shapes keep their distances on a motion.

    Args:
        space: The `SpaceArrays`.
        q: Configuration at which it starts, shape (n_q,) [rad, m]. The start
            and the end are free.
        u: The command, which is held for a second, shape (n_u,).
    """
    rate, work = space.own.rate, space.own_work
    fastest = 0.0
    for link in range(len(rate)):
        fastest = max(fastest, _speed(rate, link, u))
    if fastest == 0.0:
        return True
    count = 1
    while count < MOST and fastest > _BLINK * count:
        count *= 2
    work.row[: count + 1] = -1
    work.is_taken[:] = False
    work.guess[:] = 0.0
    first, last = _look(space, q, u, 0, count), _look(space, q, u, count, count)
    for link in range(len(rate)):
        speed = _speed(rate, link, u)
        if speed == 0.0:
            continue
        room = _link_room(space, link, first)
        other = _link_room(space, link, last)
        if min(room, other, room + other - speed) >= 0.0:
            continue
        if not _keeps_apart(space, q, u, link, speed / count, count):
            return False
    return True


@helper
def _speed(rate, link, u):
    """Bounds the approach speed of two links [m/s]."""
    speed = 0.0
    for c in range(len(u)):
        speed += rate[link, c] * abs(u[c])
    return speed


@helper
def _look(space, q, u, i, count):
    """Returns the row of the sample after i of `count` parts of a motion."""
    work = space.own_work
    row = work.row[i]
    if row < 0:
        row, last = 0, len(work.is_taken) - 1
        while row < last and work.is_taken[row]:
            row += 1
        if row < last:
            work.row[i], work.is_taken[row] = row, True
        q_then = advance(q, u, space.robot.n_base, i / count)
        X_WL, _ = body_poses(space.robot.tree, q_then)
        _keep_look(space, X_WL, row)
    return row


@helper
def _keep_look(space, X_WL, row):
    """Writes a sample's poses and positions into a row."""
    work, pairs = space.own_work, space.own.pairs
    copy_poses(X_WL, work.X_WL[row])
    place_centers(pairs.shapes, X_WL, work.p_WC[row])
    place_centers(pairs.link_boxes, X_WL, work.p_WL[row])


@helper
def _link_room(space, link, row):
    """Bounds the room between two links by the boxes around them [m]."""
    work, pairs = space.own_work, space.own.pairs
    a, b = pairs.boxes[link, 0], pairs.boxes[link, 1]
    X_WL, p_WL = work.X_WL[row], work.p_WL[row]
    apart = least_distance(pairs.link_boxes, X_WL, p_WL, a, b)
    return apart - space.link_level[link]


@helper
def _keeps_apart(space, q, u, link, step, count):
    """Returns whether two links keep their distance, by coarse checks first.

    Args:
        space: The `SpaceArrays`.
        q: Configuration at which the motion starts, shape (n_q,) [rad, m].
        u: The command, which is held for a second, shape (n_u,).
        link: The pair of links.
        step: Bound on the change of distance from one time to the next [m].
        count: Number of parts between the times of the motion.
    """
    # A stack of samples: the next part is between the topmost two.
    stack, room = space.own_work.stack, space.own_work.room
    stack[0], stack[1], top = count, 0, 1
    for k in range(2):
        row = _look(space, q, u, stack[k], count)
        room[k] = _room(space, link, row, 0.5 * count * step)
        if room[k] < -_ROUNDING:
            return False
    while top > 0:
        span = stack[top - 1] - stack[top]
        way = span * step
        if span == 1 or room[top] + room[top - 1] >= way:
            top -= 1
            continue
        half = stack[top] + span // 2
        row = _look(space, q, u, half, count)
        found = _room(space, link, row, 0.25 * way)
        if found < -_ROUNDING:
            return False
        stack[top + 1], room[top + 1] = stack[top], room[top]
        stack[top], room[top] = half, found
        top += 1
    return True


@helper
def _room(space, link, row, enough):
    """Measures the room between two links: least distance minus required [m].

    Args:
        space: The `SpaceArrays`.
        link: The pair of links.
        row: Row of the sample.
        enough: Above this value, a lower bound suffices [m].
    """
    pairs, level = space.own.pairs, space.own_level
    first, second, allowance = pairs.first, pairs.second, pairs.allowance
    shapes, body = pairs.shapes, pairs.shapes.body
    work = space.own_work
    X_WL, p_WC, p_WL = work.X_WL[row], work.p_WC[row], work.p_WL[row]
    guess, guess_W = work.guess, work.guess_W
    a, b = pairs.boxes[link]
    apart, least = least_distance(pairs.link_boxes, X_WL, p_WL, a, b), np.inf
    for k in range(pairs.start[link], pairs.start[link + 1]):
        kept = level[k] - allowance[k]
        wanted = kept + min(enough, least)
        if apart >= wanted:
            least = min(least, apart - kept)
            continue
        i, j = first[k], second[k]
        found = least_distance(shapes, X_WL, p_WC, i, j)
        if found < wanted and (enough < _FINE or found < kept):
            X = X_WL[body[i]]
            _guess(X, guess[k], p_WC[i], p_WC[j], guess_W)
            found, x, y, z = shape_distance(
                shapes, X, X_WL[body[j]], (i, j), guess_W, wanted, work.gjk
            )
            guess[k, 0], guess[k, 1], guess[k, 2] = x, y, z
        least = min(least, found - kept)
        if least < -_ROUNDING:
            return least
    return least


@helper
def _guess(X_WL, known_L, p_WA, p_WB, guess_W):
    """Writes the latest direction of the pair, or that between the centres."""
    is_known = False
    for r in range(3):
        guess_W[r] = p_WB[r] - p_WA[r]
        is_known |= known_L[r] != 0.0
    if is_known:
        for r in range(3):
            guess_W[r] = 0.0
            for c in range(3):
                guess_W[r] += X_WL[r, c] * known_L[c]
