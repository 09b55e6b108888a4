"""Whether spheres keep off what moves, all along a path to a standstill.

A sphere that moves must be clear of wherever movers can be by then, or move
away from all of it. One that rests may be touched: it is not the robot that
touches. So a path is checked until its end, and spheres that it does not move
are not looked at.
"""

import math

import numpy as np

from remosplat_drake.base.kernels import helper, kernel
from remosplat_drake.controller.verification.kernels.map_sweep import (
    travel_of,
)
from remosplat_drake.controller.verification.kernels.scene_looks import (
    look_along,
)
from remosplat_drake.scene.kernels.mover_reach import (
    core_distance,
    is_retreat,
    place_mover,
    predicted_speed,
    reach,
)


@kernel
def keeps_off_movers(
    robot, path, clock, movers, p_WS, separation, tube, tolerance
):
    """Tells whether all spheres keep off all movers on a path.

    At the path's looks each sphere that moves keeps min(separation, its
    present distance) from wherever a mover can be then, and less a tolerance
    in between; or else it moves, from look to look, away from wherever the
    mover can touch it.

    Args:
        robot: The `RobotArrays`.
        path: The path as `StoppingPath.arrays`.
        clock: `StoppingPath.clock`, shape (k,) [s].
        movers: The `MoverArrays`, whose age is that at the path's start.
        p_WS: Centres of the n spheres in W at the start, shape (n, 3) [m].
        separation: The distance to keep [m].
        tube: By how much spheres may be off the path, shape (n,) [m].
        tolerance: How far below its level a distance may fall between two
            looks [m].
    """
    pair, level = _within_reach(
        robot, path, clock, movers, p_WS, separation, tube
    )
    if len(pair) == 0:
        return True
    sphere = np.empty(len(pair), np.int64)
    for m in range(len(pair)):
        sphere[m] = pair[m, 0]
    start = p_WS[sphere]
    point, _, _, way, _, _ = look_along(
        robot, path, sphere, start, np.zeros(len(pair)), tolerance
    )
    R_WM, p_WM = np.empty((3, 3)), np.empty(3)
    for m in range(len(pair)):
        i, j = pair[m, 0], pair[m, 1]
        since, grown = 0.0, reach(movers, j, 0.0)
        place_mover(movers, j, 0.0, R_WM, p_WM)
        touching = robot.radius[i] + movers.radius[j]
        far, _, _, _ = core_distance(movers, j, R_WM, p_WM, start[m])
        before = far - grown - touching - level[m]
        for k in range(len(clock)):
            if way[k, m] == 0.0:
                continue
            grown_after = reach(movers, j, clock[k])
            place_mover(movers, j, clock[k], R_WM, p_WM)
            far, _, _, _ = core_distance(movers, j, R_WM, p_WM, point[k + 1, m])
            room = far - grown_after - touching - level[m]
            moved = predicted_speed(movers, j) * (clock[k] - since)
            used = way[k, m] + moved + grown_after - grown
            is_clear = room >= 0.0 and room + before - used >= -2.0 * tolerance
            if not is_clear and not (
                _retreats(movers, j, since, grown_after, touching, point, k, m)
                and _retreats(
                    movers, j, clock[k], grown_after, touching, point, k, m
                )
            ):
                return False
            before, since, grown = room, clock[k], grown_after
    return True


@helper
def _within_reach(robot, path, clock, movers, p_WS, separation, tube):
    """Finds the pairs of a sphere and a mover that may come too near.

    Returns:
        The pairs, shape (m, 2), and the level that each keeps, shape (m,) [m].
    """
    n, k, last = len(p_WS), len(movers.radius), clock[-1]
    pair, level = np.empty((n * k, 2), np.int64), np.empty(n * k)
    R_WM, p_WM = np.empty((3, 3)), np.empty(3)
    m = 0
    for i in range(n):
        travel = travel_of(robot, path, i)
        if travel == 0.0:
            continue
        for j in range(k):
            place_mover(movers, j, 0.0, R_WM, p_WM)
            far, _, _, _ = core_distance(movers, j, R_WM, p_WM, p_WS[i])
            grown = reach(movers, j, 0.0)
            found = far - grown - movers.radius[j] - robot.radius[i]
            travels = predicted_speed(movers, j) * last
            travels += reach(movers, j, last) - grown
            if not found - travel - travels >= separation + tube[i]:
                pair[m, 0], pair[m, 1] = i, j
                level[m] = min(separation + tube[i], found)
                m += 1
    return pair[:m], level[:m]


@helper
def _retreats(movers, j, time, grown, touching, point, k, m):
    """Whether a sphere's way before look k leads away from a mover.

    It is seen from where the sphere is at the end of its way that belongs to
    the time.
    """
    R_WM, p_WM = np.empty((3, 3)), np.empty(3)
    place_mover(movers, j, time, R_WM, p_WM)
    deepest, worst_ahead, worst_aside = np.inf, -np.inf, 0.0
    for end in range(2):
        far, nx, ny, nz = core_distance(
            movers, j, R_WM, p_WM, point[k + end, m]
        )
        x = point[k + 1, m, 0] - point[k, m, 0]
        y = point[k + 1, m, 1] - point[k, m, 1]
        z = point[k + 1, m, 2] - point[k, m, 2]
        ahead = nx * x + ny * y + nz * z
        aside = math.sqrt(max(x * x + y * y + z * z - ahead * ahead, 0.0))
        deepest = min(deepest, far - grown)
        worst_ahead = max(worst_ahead, ahead)
        worst_aside = max(worst_aside, aside)
    return is_retreat(deepest, touching, worst_ahead, worst_aside)
