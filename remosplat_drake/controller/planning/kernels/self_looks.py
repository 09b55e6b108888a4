"""Whether a robot keeps off itself, at a place or all along a motion.

The distance of two links changes by no more than a known rate. So a motion is
looked at from coarse to fine, for each pair of links by itself: where the rooms
at both ends of a part are together more than the links can near each other on
it, nothing between needs a look.
"""

import numpy as np

from remosplat_drake.base.kernels import helper, kernel
from remosplat_drake.base.kernels.returns import TRUTH
from remosplat_drake.robot.kinematics import advance, body_poses, copy_poses
from remosplat_drake.robot.self_collision.kernels.gjk import make_work
from remosplat_drake.robot.self_collision.kernels.pair_distance import (
    centers_in_world,
    least_distance,
    place_centers,
    shape_distance,
)

_BLINK = 0.01
"""How far two of the robot's own shapes may move between two looks although
they are nearer to what they keep [m]. Verification looks more closely."""

_DEPTH = 12

_MOST = 2 ** (_DEPTH - 2)
"""Most parts into which a motion is cut."""

_KEPT = 16
"""Most looks at a motion that are kept: few are taken, and more memory than the
nearest cache holds costs more than it saves."""

_FINE = 0.05
"""Room above which coarse bounds will do: more looks are cheaper then than more
exact ones [m]."""

_ROUNDING = 1e-9
"""Rounding errors of distances [m]."""


@kernel(returns=TRUTH)
def is_off_itself(space, X_WL):
    """Tells whether all pairs of shapes keep their distances.

    Args:
        space: The `SpaceArrays`.
        X_WL: Poses of all bodies, shape (b, 4, 4).
    """
    pairs = space.own.pairs
    p_WC = centers_in_world(pairs.shapes, X_WL)
    p_WL = centers_in_world(pairs.link_boxes, X_WL)
    work, guess = make_work(), np.zeros((len(pairs.first), 3))
    for link in range(len(pairs.boxes)):
        # Most links are far apart: that is seen without a call.
        if _link_room(space, link, X_WL, p_WL) >= 0.0:
            continue
        at = X_WL, p_WC, p_WL
        if _room(space, link, at, 0.0, guess, work) < -_ROUNDING:
            return False
    return True


@helper
def _link_room(space, link, X_WL, p_WL):
    """Bounds the room between two links by the boxes around them [m].

    Args:
        space: The `SpaceArrays`.
        link: The pair of links.
        X_WL: Poses of all bodies.
        p_WL: Centres of the links' boxes in W.
    """
    pairs = space.own.pairs
    a, b = pairs.boxes[link, 0], pairs.boxes[link, 1]
    apart = least_distance(pairs.link_boxes, X_WL, p_WL, a, b)
    return apart - space.link_level[link]


@kernel(returns=TRUTH)
def keeps_off_itself(space, q, u):
    """Tells whether all pairs of shapes keep their distances on a motion.

    Args:
        space: The `SpaceArrays`.
        q: Configuration at which it starts, shape (n_q,) [rad, m]. It and that
            at the end are free.
        u: The command, which is held for a second, shape (n_u,).
    """
    rate = space.own.rate
    speed = np.zeros(len(rate))
    fastest = 0.0
    for link in range(len(rate)):
        for c in range(len(u)):
            speed[link] += rate[link, c] * abs(u[c])
        fastest = max(fastest, speed[link])
    if fastest == 0.0:
        return True
    count = 1
    while count < _MOST and fastest > _BLINK * count:
        count *= 2
    motion = q, u, space.robot.n_base
    looks = _make_looks(space.own.pairs, space.robot.tree, count)
    guess, work = np.zeros((len(space.own.pairs.first), 3)), make_work()
    X_first, _, p_first = _look(space, motion, looks, 0)
    X_last, _, p_last = _look(space, motion, looks, count)
    for link in range(len(rate)):
        if speed[link] == 0.0:
            continue
        first = _link_room(space, link, X_first, p_first)
        last = _link_room(space, link, X_last, p_last)
        if min(first, last, first + last - speed[link]) >= 0.0:
            continue
        near = link, speed[link] / count, guess, work
        if not _keeps_apart(space, motion, looks, near):
            return False
    return True


@helper
def _make_looks(pairs, tree, count):
    """Makes room for looks at count + 1 times, which are taken as needed.

    Returns:
        For each time the row of its look, -1 where none is kept; and a row for
        each look that is kept, the last for one that is not: its time, the
        poses of all bodies, the centres of all shapes, and of the links' boxes,
        in W.
    """
    b, s, kept = len(tree.parent), len(pairs.shapes.body), min(count + 1, _KEPT)
    return (
        np.full(count + 1, -1),
        np.full(kept + 1, -1),
        np.empty((kept + 1, b, 4, 4)),
        np.empty((kept + 1, s, 3)),
        np.empty((kept + 1, len(pairs.link_boxes.body), 3)),
    )


@helper
def _look(space, motion, looks, i):
    """Returns where everything is at a look."""
    row_of, time_of, X_WL, p_WC, p_WL = looks
    row = row_of[i]
    if row < 0:
        row = 0
        while row < len(time_of) - 1 and time_of[row] >= 0:
            row += 1
        if row < len(time_of) - 1:
            row_of[i], time_of[row] = row, i
        q, u, n_base = motion
        pairs, time = space.own.pairs, i / (len(row_of) - 1)
        X, _ = body_poses(space.robot.tree, advance(q, u, n_base, time))
        copy_poses(X, X_WL[row])
        place_centers(pairs.shapes, X, p_WC[row])
        place_centers(pairs.link_boxes, X, p_WL[row])
    return X_WL[row], p_WC[row], p_WL[row]


@helper
def _keeps_apart(space, motion, looks, near):
    """Tells whether two links keep apart, from coarse looks to fine ones.

    Args:
        space: The `SpaceArrays`.
        motion: Configuration, command and number of base commands.
        looks: What `_make_looks` returns.
        near: The pair of links, by how much it may come nearer from one look
            to the next, guessed directions, and arrays of `make_work`.
    """
    link, step, guess, work = near
    last = len(looks[0]) - 1
    # A stack of looks: the next part is between the topmost two.
    stack, room = np.empty(_DEPTH, np.int64), np.empty(_DEPTH)
    stack[0], stack[1], top = last, 0, 1
    for k in range(2):
        at = _look(space, motion, looks, stack[k])
        enough = 0.5 * last * step
        room[k] = _room(space, link, at, enough, guess, work)
        if room[k] < -_ROUNDING:
            return False
    while top > 0:
        span = stack[top - 1] - stack[top]
        way = span * step
        if span == 1 or room[top] + room[top - 1] >= way:
            top -= 1
            continue
        half = stack[top] + span // 2
        at = _look(space, motion, looks, half)
        found = _room(space, link, at, 0.25 * way, guess, work)
        if found < -_ROUNDING:
            return False
        stack[top + 1], room[top + 1] = stack[top], room[top]
        stack[top], room[top] = half, found
        top += 1
    return True


@helper
def _room(space, link, at, enough, guess, work):
    """Measures what the shapes of two links have above what they keep [m].

    Args:
        space: The `SpaceArrays`.
        link: The pair of links.
        at: Poses of all bodies, and the centres of shapes and links' boxes.
        enough: Beyond this, a lower bound will do [m].
        guess: Directions from the first shape of each pair to the second, in
            the first's link, shape (k, 3): those that were found last.
        work: Arrays of `make_work`.
    """
    pairs, level = space.own.pairs, space.own_level
    first, second, allowance = pairs.first, pairs.second, pairs.allowance
    shapes, body = pairs.shapes, pairs.shapes.body
    X_WL, p_WC, p_WL = at
    a, b = pairs.boxes[link]
    apart, least = least_distance(pairs.link_boxes, X_WL, p_WL, a, b), np.inf
    guess_W = np.empty(3)
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
                shapes, X, X_WL[body[j]], (i, j), guess_W, wanted, work
            )
            guess[k, 0], guess[k, 1], guess[k, 2] = x, y, z
        least = min(least, found - kept)
        if least < -_ROUNDING:
            return least
    return least


@helper
def _guess(X_WL, known_L, p_WA, p_WB, guess_W):
    """Fills in the direction that was found last, or that of the centres."""
    is_known = False
    for r in range(3):
        guess_W[r] = p_WB[r] - p_WA[r]
        is_known |= known_L[r] != 0.0
    if is_known:
        for r in range(3):
            guess_W[r] = 0.0
            for c in range(3):
                guess_W[r] += X_WL[r, c] * known_L[c]
