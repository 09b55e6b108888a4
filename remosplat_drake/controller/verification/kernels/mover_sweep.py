"""Checks that spheres keep away from movers, along a path to a standstill.

At each time, a moving sphere must be clear of all positions that movers may
have reached by this time, or it must move away from all these positions. A
sphere at rest may be touched, since the mover then causes the contact. So the
whole path of the robot is checked, except for spheres that do not move along
it.
"""

import math

import numpy as np

from remosplat_drake.base.kernels import helper, kernel
from remosplat_drake.base.kernels.returns import TRUTH
from remosplat_drake.controller.verification.kernels.between_samples import (
    apart,
)
from remosplat_drake.controller.verification.kernels.map_sweep import (
    travel_of,
)
from remosplat_drake.controller.verification.kernels.path_samples import (
    sample_path,
)
from remosplat_drake.scene.kernels.mover_reach import (
    center_distance,
    core_distance,
    is_retreat,
    place_mover,
    predicted_speed,
    reach,
)


@kernel(returns=TRUTH)
def keeps_off_movers(robot, path, movers, p_WS, separation, tube, tolerance):
    """Returns whether all spheres keep away from all movers on a path.

    At each sampled time of the path, a moving sphere must keep min(separation,
    its present distance) from all possible positions of a mover. Between two
    samples, it must keep this distance minus a tolerance. Alternatively, the
    sphere must move away from all positions at which the mover can touch it. A
    sphere that a mover touches or nearly touches must rest or retreat until the
    contact ends.

    Args:
        robot: The `RobotArrays`.
        path: The `PathArrays`.
        movers: The `MoverArrays`, with the age of the measurements at the
            path's start.
        p_WS: Centres of the n spheres in W at the start, shape (n, 3) [m].
        separation: The distance to keep [m].
        tube: Bounds of spheres' deviations from the path, shape (n,) [m].
        tolerance: Amount by which a distance may fall below its level between
            two samples [m].
    """
    if len(movers.radius) == 0:
        return True
    least = tube + tolerance
    pair, level, margin = _within_reach(
        robot, path, movers, p_WS, separation + tube, least
    )
    if len(pair) == 0:
        return True
    near, place_of = _spheres_of(pair, len(p_WS))
    start = p_WS[near]
    point, _, _, way, _, _ = sample_path(
        robot, path, near, start, np.zeros(len(near)), np.zeros(len(near))
    )
    times = np.zeros(len(path.clock) + 1)
    times[1:] = path.clock
    seen = _sampled_movers(movers, times)
    for m in range(len(pair)):
        i = place_of[pair[m, 0]]
        touching = robot.radius[pair[m, 0]] + movers.radius[pair[m, 1]]
        if not _pair_is_kept(
            movers,
            seen,
            (pair[m, 1], touching, level[m], margin[m]),
            (times, point[:, i], way[:, i]),
            tolerance,
        ):
            return False
    return True


@helper
def _within_reach(robot, path, movers, p_WS, kept, least):
    """Finds the pairs of a sphere and a mover that may come too near.

    Args:
        robot: The `RobotArrays`.
        path: The `PathArrays`.
        movers: The `MoverArrays`.
        p_WS: Centres of the n spheres in W at the start, shape (n, 3) [m].
        kept: The distance to keep, or the present distance if that is smaller,
            shape (n,) [m].
        least: Least required distance, shape (n,) [m].

    Returns:
        The m pairs, shape (m, 2); and the level of each pair and its margin at
        the start, both of shape (m,) [m].
    """
    n, k, last = len(p_WS), len(movers.radius), path.clock[-1]
    pair = np.empty((n * k, 2), np.int64)
    level, margin = np.empty(n * k), np.empty(n * k)
    travel = np.empty(n)
    for i in range(n):
        travel[i] = travel_of(robot, path, i)
    R_WM, p_WM = np.empty((3, 3)), np.empty(3)
    m = 0
    for j in range(k):
        place_mover(movers, j, 0.0, R_WM, p_WM)
        grown = reach(movers, j, 0.0)
        travels = predicted_speed(movers, j) * last
        travels += reach(movers, j, last) - grown
        for i in range(n):
            if travel[i] == 0.0:
                continue
            radii = movers.radius[j] + robot.radius[i]
            taken = grown + radii + travel[i] + travels
            if center_distance(movers, j, p_WM, p_WS[i]) - taken >= kept[i]:
                continue
            far, _, _, _ = core_distance(movers, j, R_WM, p_WM, p_WS[i])
            found = far - grown - radii
            if not found - travel[i] - travels >= kept[i]:
                pair[m, 0], pair[m, 1] = i, j
                level[m] = min(kept[i], max(found, least[i]))
                margin[m] = found - level[m]
                m += 1
    return pair[:m], level[:m], margin[:m]


@helper
def _spheres_of(pair, n):
    """Lists the spheres of pairs, each once; and their indices in the list."""
    near, place_of = np.empty(n, np.int64), np.full(n, -1)
    count = 0
    for m in range(len(pair)):
        i = pair[m, 0]
        if place_of[i] < 0:
            near[count], place_of[i] = i, count
            count += 1
    return near[:count], place_of


@helper
def _sampled_movers(movers, times):
    """Predicts all k movers at the times of all s samples of a path.

    Returns:
        The movers' orientations, shape (k, s, 3, 3), origins, shape (k, s, 3)
        [m], and reaches, shape (k, s) [m], and bounds of their predicted
        speeds, shape (k,) [m/s].
    """
    k, s = len(movers.radius), len(times)
    R_WM, p_WM = np.empty((k, s, 3, 3)), np.empty((k, s, 3))
    grown, speed = np.empty((k, s)), np.empty(k)
    for j in range(k):
        speed[j] = predicted_speed(movers, j)
        for i in range(s):
            place_mover(movers, j, times[i], R_WM[j, i], p_WM[j, i])
            grown[j, i] = reach(movers, j, times[i])
    return R_WM, p_WM, grown, speed


@helper
def _pair_is_kept(movers, seen, pair, sphere, tolerance):
    """Returns whether one sphere keeps away from one mover.

    The motions of sphere and mover since the start bound the decrease of their
    distance. The distance is computed only if this bound is not sufficient.

    Args:
        movers: The `MoverArrays`.
        seen: The result of `_sampled_movers`.
        pair: The mover, the sum of the radii of sphere and mover, the level,
            and the margin at the start.
        sphere: The times of the s samples, the sphere's centres at these times,
            shape (s, 3), and bounds of the lengths of its paths from sample to
            sample, shape (s - 1,) [m].
        tolerance: Amount by which a distance may fall below its level between
            two samples [m].
    """
    R_WM, p_WM, grown, speed = seen
    j, touching, level, at_start = pair
    times, point, way = sphere
    last, before, is_exact = 0, at_start, True
    for k in range(1, len(times)):
        if way[k - 1] == 0.0:
            continue
        used = way[k - 1] + speed[j] * (times[k] - times[last])
        used += grown[j, k] - grown[j, last]
        lost = apart(point[0], point[k]) + speed[j] * times[k]
        lost += grown[j, k] - grown[j, 0]
        margin = at_start - lost
        knows = margin >= 0.0 and margin + before - used >= -2.0 * tolerance
        if not knows:
            taken = touching + level
            if not is_exact:
                far, _, _, _ = core_distance(
                    movers, j, R_WM[j, last], p_WM[j, last], point[last]
                )
                before = far - grown[j, last] - taken
            far, _, _, _ = core_distance(
                movers, j, R_WM[j, k], p_WM[j, k], point[k]
            )
            margin = far - grown[j, k] - taken
            is_clear = (
                margin >= 0.0 and margin + before - used >= -2.0 * tolerance
            )
            if not is_clear and not (
                _retreats(movers, seen, j, last, k, point, way, touching)
                and _retreats(movers, seen, j, k, k, point, way, touching)
            ):
                return False
        last, before, is_exact = k, margin, not knows
    return True


@helper
def _retreats(movers, seen, j, then, k, point, way, touching):
    """Whether a sphere moves away from a mover before sample k.

    The mover is at its position at the sample `then`, and the sphere is
    examined at both ends of its path. Let x be the chord between the ends.
    Along the chord, the direction n to a convex core turns away from x, so the
    ends are the worst cases. The sphere itself moves on an arc. Let a be a
    bound of its acceleration. In a time t, the sphere deviates by at most a t^2
    / 8 from the chord, and its velocity by at most a t / 2 from x / t. At the
    depth h, n turns by at most the deviation from the chord divided by h.
    """
    R_WM, p_WM, grown, _ = seen
    x = point[k, 0] - point[k - 1, 0]
    y = point[k, 1] - point[k - 1, 1]
    z = point[k, 2] - point[k - 1, 2]
    chord = math.sqrt(x * x + y * y + z * z)
    bent = 3.0 * (way[k - 1] - chord)  # a t^2, see `between_samples`.
    deepest, worst_ahead, worst_aside = np.inf, -np.inf, 0.0
    for end in range(k - 1, k + 1):
        far, nx, ny, nz = core_distance(
            movers, j, R_WM[j, then], p_WM[j, then], point[end]
        )
        ahead = nx * x + ny * y + nz * z
        aside = math.sqrt(max(chord * chord - ahead * ahead, 0.0))
        deepest = min(deepest, far - grown[j, k] - bent / 8.0)
        worst_ahead = max(worst_ahead, ahead)
        worst_aside = max(worst_aside, aside)
    if deepest <= 0.0:
        return False
    turned = bent / 8.0 / deepest
    slack = bent / 2.0 + turned * (chord + bent / 2.0)
    return is_retreat(
        deepest, touching, worst_ahead + slack, worst_aside + slack
    )
