"""Whether pairs of spheres keep apart all along a path.

Coarse before fine: a pair is looked at where the path starts and ends, and
in between only where these two looks do not tell enough.
"""

import numpy as np
from numba import njit

from remosplat_drake.controller.verification.kernels.between_looks import (
    apart,
    bend_of,
    longest_way,
)
from remosplat_drake.controller.verification.kernels.places import (
    peak_speed,
    place,
)
from remosplat_drake.robot.kinematics import body_poses, sphere_points

_HALVINGS = 10
"""How often a tick is halved; what is still unknown then is refused."""


@njit(cache=True)
def pair_distances(p_WS, radius, first, second, allowance):
    """Computes the distances between the surfaces of p pairs of spheres.

    Args:
        p_WS: Centres of all spheres in W, shape (n, 3) [m].
        radius: Radii of all spheres, shape (n,) [m].
        first: Index of one sphere of each pair, shape (p,).
        second: Index of the other sphere, shape (p,).
        allowance: How much nearer than others each pair may come, shape (p,)
            [m].

    Returns:
        The distances plus the allowances, shape (p,) [m].
    """
    distance = np.empty(len(first))
    for k in range(len(first)):
        i, j = first[k], second[k]
        between = apart(p_WS[i], p_WS[j]) - radius[i] - radius[j]
        distance[k] = between + allowance[k]
    return distance


@njit(cache=True)
def pairs_keep_apart(robot, path, pairs, rate, distance, stopping, tolerance):
    """Tells whether all pairs keep min(stopping, present distance) on a path.

    Args:
        robot: The robot as `RobotModel.arrays`.
        path: The path as `StoppingPath.arrays`.
        pairs: The p pairs of spheres as four arrays of shape (p,): first and
            second sphere, number of the pair of links, and the allowance by
            which the distance is counted too large [m].
        rate: Bounds on how fast the distances of each of l pairs of links
            change with each entry of the command, shape (l, n_u).
        distance: Distance of each pair at the start of the path, allowance
            included, shape (p,) [m].
        stopping: Distance that the pairs of each of l pairs of links keep,
            shape (l,) [m].
        tolerance: How far below that a distance may fall between the times of
            the path [m].
    """
    speed, times = peak_speed(path[1]), path[4]
    radius, bend = robot[3], robot[4]
    first, second, link_pair, allowance = pairs
    travel = _travel(path, rate)
    knots = np.zeros(len(times) + 1)
    knots[1:] = times
    p_WS = np.empty((len(knots), len(radius), 3))
    is_placed = np.zeros(len(knots), np.bool_)
    for k in range(len(first)):
        link = link_pair[k]
        room = max(distance[k] - stopping[link], 0.0)
        if travel[link, -1] < room:
            continue
        i, j = first[k], second[k]
        level = min(distance[k], stopping[link]) - allowance[k]
        centres = level + radius[i] + radius[j]
        both = bend_of(bend[i], speed) + bend_of(bend[j], speed)
        pair = i, j, centres, both
        if not _pair_keeps_apart(
            robot,
            path,
            pair,
            knots,
            p_WS,
            is_placed,
            travel[link],
            room,
            tolerance,
        ):
            return False
    return True


@njit(cache=True)
def _travel(path, rate):
    """Bounds how distances have changed by the ends of a path's s pieces.

    The result, for l pairs of links, has the shape (l, s + 1) [m].
    """
    _, rates, since, _, times = path
    travel = np.zeros((len(rate), len(since) + 1))
    for k in range(len(rate)):
        for s in range(len(since)):
            end = since[s + 1] if s + 1 < len(since) else times[-1]
            change = 0.0
            for c in range(rates.shape[1]):
                change += rate[k, c] * abs(rates[s, c]) * (end - since[s])
            travel[k, s + 1] = travel[k, s] + change
    return travel


@njit(cache=True)
def _pair_keeps_apart(
    robot, path, pair, knots, p_WS, is_placed, travel, room, tolerance
):
    """Tells the same of one pair; spheres it places serve other pairs, too."""
    if not is_placed[0]:
        _place(robot, path, 0.0, p_WS[0])
        is_placed[0] = True
    # What lies before `left` is clear; it goes from there to the last of
    # `rights`, which nears it by halves where that is too far.
    left = 0
    rights = np.empty(64, np.int64)
    rights[0] = len(knots) - 1
    height = 1
    while height:
        right = rights[height - 1]
        if not is_placed[right]:
            _place(robot, path, knots[right], p_WS[right])
            is_placed[right] = True
        room_after = _room(p_WS[right], pair)
        if not room_after >= 0.0:
            return False
        time = knots[right] - knots[left]
        if right - left > 1 and len(travel) == len(knots):
            # Velocities jump between the pieces that lie within.
            way = travel[right] - travel[left]
        else:
            way = _way(p_WS[left], p_WS[right], pair, time)
        if not room + room_after - way >= 0.0:
            if right - left > 1:
                rights[height] = (left + right) // 2
                height += 1
                continue
            times = knots[left], knots[right]
            places = p_WS[left], p_WS[right]
            rooms = room, room_after
            if not _keeps_apart_within(
                robot, path, pair, times, places, rooms, tolerance
            ):
                return False
        left, room = right, room_after
        height -= 1
    return True


@njit(cache=True)
def _keeps_apart_within(robot, path, pair, times, places, rooms, tolerance):
    """Tells the same of one pair within one tick, less the tolerance."""
    shortest = 0.5**_HALVINGS * (times[1] - times[0])
    rights = np.empty((_HALVINGS + 2, 2))
    rights_p_WS = np.empty((_HALVINGS + 2, *places[0].shape))
    rights[0] = times[1], rooms[1]
    rights_p_WS[0] = places[1]
    left, room, p_WS = times[0], rooms[0], places[0].copy()
    height = 1
    while height:
        right, room_after = rights[height - 1]
        place = rights_p_WS[height - 1]
        way = _way(p_WS, place, pair, right - left)
        if room + room_after - way >= -2.0 * tolerance:
            left, room, p_WS[:] = right, room_after, place
            height -= 1
            continue
        if right - left <= shortest:
            return False
        middle = 0.5 * (left + right)
        _place(robot, path, middle, rights_p_WS[height])
        rights[height] = middle, _room(rights_p_WS[height], pair)
        if not rights[height, 1] >= -tolerance:
            return False
        height += 1
    return True


@njit(cache=True)
def _place(robot, path, time, p_WS):
    """Places all spheres at a time on the path."""
    tree, body, p_BS = robot[0], robot[1], robot[2]
    q = place(path, time)
    X_WB, _ = body_poses(*tree, q)  # pyright: ignore
    p_WS[:], _ = sphere_points(X_WB, body, p_BS)


@njit(cache=True)
def _room(p_WS, pair):
    """Computes what a pair's distance has above its level [m]."""
    i, j, centres, _ = pair
    return apart(p_WS[i], p_WS[j]) - centres


@njit(cache=True)
def _way(p_WS, q_WS, pair, time):
    """Bounds the way of the vector from one sphere to the other [m]."""
    i, j, _, bend = pair
    x = (p_WS[j, 0] - p_WS[i, 0]) - (q_WS[j, 0] - q_WS[i, 0])
    y = (p_WS[j, 1] - p_WS[i, 1]) - (q_WS[j, 1] - q_WS[i, 1])
    z = (p_WS[j, 2] - p_WS[i, 2]) - (q_WS[j, 2] - q_WS[i, 2])
    return longest_way((x, y, z), (0.0, 0.0, 0.0), bend, time)
