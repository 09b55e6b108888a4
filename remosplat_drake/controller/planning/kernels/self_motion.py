"""Checks for self-collision along a motion.

For each pair of links, the motion is sampled at eight times. First the bounding
boxes of the links are compared, then the bounding boxes of their shapes, and
finally the shapes. A direction that separates two shapes at one sample usually
separates them at other samples, too. Each part between two samples that is
possibly not free is sampled in the same way, for these links only.
"""

import math

from remosplat_drake.base.kernels import helper, kernel
from remosplat_drake.base.kernels.returns import TRUTH
from remosplat_drake.base.lanes import (
    WIDTH,
    in_all,
    lane_of,
    lanes_from,
    lowest_bit,
    places_of,
    write_lanes,
)
from remosplat_drake.controller.planning.kernels.motion_samples import (
    PARTS,
    changes,
    open_parts,
    sample_motion,
)
from remosplat_drake.controller.planning.kernels.part_stack import (
    begin_parts,
    push_parts,
    take_part,
)
from remosplat_drake.controller.planning.kernels.self_checks import (
    ROUNDING,
)
from remosplat_drake.controller.verification.kernels.between_samples import (
    detour,
)
from remosplat_drake.robot.pose_lanes import entry, place_by_lanes, turned_back
from remosplat_drake.robot.self_collision.kernels.pair_distance import (
    center_offsets,
    least_distances,
    shape_distance,
)
from remosplat_drake.robot.self_collision.kernels.separation import separations

_BLINK = 0.01
"""Relative motion of two shapes between the finest samples [m]. Between these
samples, the distance of the shapes may be smaller than required. Verification
samples more finely.
"""

_MEETS = -1
"""Result that replaces a bit mask of parts if two links are too near at a
sample."""


@kernel(returns=TRUTH)
def keeps_off_itself(space, q, u):
    """Returns whether all pairs of shapes keep their distances in a motion.

    Args:
        space: The `SpaceArrays`.
        q: Configuration at the start of the motion, shape (n_q,) [rad, m]. The
            start and the end must be free, and the last call of `is_off_itself`
            must have been for one of them.
        u: The command, which is held for a second, shape (n_u,).
    """
    work = space.self_work.motion
    top = begin_parts(work.parts, _begin(space, u))
    while top > 0:
        start, end, count = take_part(work.parts, top)
        sample_motion(space.robot, space.samples, q, u, start, end)
        _place_centers(space)
        step = (end - start) / PARTS
        for row in range(count):
            parts = _open_parts(space, work.parts.item[row], step)
            if parts == _MEETS:
                return False
            work.parts.open[row] = parts
        top = push_parts(work.parts, top - 1, start, step, count)
        if top < 0:
            return False
    return True


@helper
def _begin(space, u):
    """Lists the pairs of links that may be too near, and returns their number.

    A pair of links is omitted if its margin at one end of the motion exceeds
    the distance by which the links can approach. The function also computes the
    bounds of the links' speeds and accelerations.
    """
    rate, work = space.self_pairs.rate, space.self_work.motion
    count = 0
    for link in range(len(rate)):
        speed = 0.0
        for c in range(len(u)):
            speed += rate[link, c] * abs(u[c])
        work.speed[link] = speed
        if speed > space.self_work.margin[link]:
            work.parts.item[count] = link
            count += 1
    bends = len(work.bend)
    for first in range(0, bends, WIDTH):
        bend = in_all(0.0)
        for i in range(len(u)):
            for j in range(len(u)):
                bound = lanes_from(
                    space.self_bend, (i * len(u) + j) * bends + first
                )
                bend = bend + bound * (abs(u[i]) * abs(u[j]))
        write_lanes(work.bend, first, bend)
    return count


@helper
def _place_centers(space):
    """Places the centres of shapes and boxes at the samples."""
    work, pairs = space.self_work.motion, space.self_pairs.pairs
    X_WL, boxes, shapes = space.samples.X_WL, pairs.link_boxes, pairs.shapes
    place_by_lanes(X_WL, boxes.body, boxes.center, work.p_WL)
    place_by_lanes(X_WL, shapes.body, shapes.center, work.p_WC)


@helper
def _open_parts(space, link, step):
    """Returns the parts in which two links may be too near, as a bit mask.

    Args:
        space: The `SpaceArrays`.
        link: Index of the pair of links.
        step: Time between two samples [s].
    """
    work, pairs = space.self_work.motion, space.self_pairs.pairs
    X_WL, boxes, shapes = space.samples.X_WL, pairs.link_boxes, pairs.shapes
    a, b = pairs.boxes[link, 0], pairs.boxes[link, 1]
    apart = least_distances(boxes, X_WL, work.p_WL, a, b)
    write_lanes(work.margin, 0, apart - space.link_level[link])
    if open_parts(work.margin, in_all(work.speed[link] * step)) == 0:
        return 0
    way, parts = _ways(space, link, step), 0
    sag = 0.125 * work.bend[link] * step * step
    if open_parts(work.margin, way) == 0:
        return 0
    for k in range(pairs.start[link], pairs.start[link + 1]):
        i, j = pairs.first[k], pairs.second[k]
        kept = space.self_level[k] - pairs.allowance[k]
        apart = least_distances(shapes, X_WL, work.p_WC, i, j)
        write_lanes(work.margin, 0, apart - kept)
        found = open_parts(work.margin, way)
        if found != 0:
            found = _exactly_open(space, k, found, way, sag)
        if found == _MEETS:
            return _MEETS
        parts |= found
    return parts


@helper
def _exactly_open(space, k, parts, way, sag):
    """Returns the parts in which two shapes may be too near, as a bit mask.

    Args:
        space: The `SpaceArrays`.
        k: The pair of shapes.
        parts: The parts to check, as a bit mask.
        way: Bounds of the paths to the next sample, as lanes [m].
        sag: See `_not_separated`.
    """
    kept, result = space.self_level[k] - space.self_pairs.pairs.allowance[k], 0
    _begin_direction(space, k)
    parts = _not_separated(space, k, parts, sag)
    while parts:
        part = lowest_bit(parts)
        bit, travel = 1 << part, lane_of(way, part)
        enough, both = kept + travel, 0.0
        for sample in (part, part + 1):
            if parts & bit:
                margin = _exact_distance(space, k, sample, enough) - kept
                if margin < -ROUNDING:
                    return _MEETS
                both += margin
                parts = _not_separated(space, k, parts, sag)
        if parts & bit:
            parts ^= bit
            if travel > _BLINK and both < travel:
                result |= bit
    return result


@helper
def _begin_direction(space, k):
    """Sets the direction between the centres as the first that is tried."""
    work, pairs = space.self_work.motion, space.self_pairs.pairs
    n_A, X_WL, middle = work.n_A[k], space.samples.X_WL, WIDTH // 2
    if n_A[0] != 0.0 or n_A[1] != 0.0 or n_A[2] != 0.0:
        return
    i, j = pairs.first[k], pairs.second[k]
    A, square = pairs.shapes.body[i], 0.0
    for r in range(3):
        work.n_W[r] = work.p_WC[j, r, middle] - work.p_WC[i, r, middle]
        square += work.n_W[r] ** 2
    if square > 0.0:
        for r in range(3):
            for c in range(3):
                n_A[r] += (
                    X_WL[A, c, r, middle] * work.n_W[c] / math.sqrt(square)
                )


@helper
def _not_separated(space, k, parts, sag):
    """Returns the parts in which the latest direction does not separate.

    Let b be a bound of the acceleration of points of the second link relative
    to the first link, and t the time between two samples. Then a point deviates
    from a straight line by at most `sag` = b t^2 / 8.
    """
    work, pairs = space.self_work.motion, space.self_pairs.pairs
    shapes, X_WL = pairs.shapes, space.samples.X_WL
    kept = space.self_level[k] - pairs.allowance[k]
    pair = pairs.first[k], pairs.second[k]
    gap = separations(shapes, X_WL, pair, work.n_A[k]) - (kept + sag)
    low = ~places_of(gap >= 0.0)
    return parts & (low | (low >> 1))


@helper
def _exact_distance(space, k, sample, enough):
    """Computes the distance of two shapes, and stores the direction [m].

    Args:
        space: The `SpaceArrays`.
        k: The pair of shapes.
        sample: Index of the sample.
        enough: Distance above which a lower bound is sufficient [m].
    """
    work, pairs = space.self_work.motion, space.self_pairs.pairs
    shapes, X_WL = pairs.shapes, space.samples.X_WL
    i, j, n_A = pairs.first[k], pairs.second[k], work.n_A[k]
    A, B = shapes.body[i], shapes.body[j]
    for r in range(3):
        work.n_W[r] = 0.0
        for c in range(4):
            work.X_WA[r, c] = X_WL[A, r, c, sample]
            work.X_WB[r, c] = X_WL[B, r, c, sample]
        for c in range(3):
            work.n_W[r] += work.X_WA[r, c] * n_A[c]
    found, n_A[0], n_A[1], n_A[2] = shape_distance(
        shapes,
        work.X_WA,
        work.X_WB,
        (i, j),
        work.n_W,
        enough,
        space.self_work.gjk,
    )
    return found


@helper
def _ways(space, link, step):
    """Returns bounds of the paths of one link's points in the other's frame.

    Each SIMD lane contains the bound from a sample to the next. A rotation by
    the angle x moves a point by 2 sin(x / 2) times the point's distance from
    the axis. It changes the rotation matrix by 2 sqrt(2) sin(x / 2) in the
    Frobenius norm.
    """
    work, pairs = space.self_work.motion, space.self_pairs.pairs
    X_WL, pose = space.samples.X_WL, work.pose
    boxes = pairs.link_boxes
    a, b = pairs.boxes[link, 0], pairs.boxes[link, 1]
    A, B = boxes.body[a], boxes.body[b]
    for c in range(3):
        column = (
            entry(X_WL, B, 0, c),
            entry(X_WL, B, 1, c),
            entry(X_WL, B, 2, c),
        )
        _write_three(pose, 3 * c, turned_back(X_WL, A, column))
    offset = center_offsets(work.p_WL, a, b)
    _write_three(pose, 9, turned_back(X_WL, A, offset))
    turn, shift = changes(pose, 0, 9), changes(pose, 9, 12)
    moved = shift + turn * (boxes.reach[b] * math.sqrt(0.5))
    return moved + detour(work.bend[link], step)


@helper
def _write_three(memory, first, values):
    """Writes three lanes, one after the other."""
    for k in range(3):
        write_lanes(memory, (first + k) * WIDTH, values[k])
