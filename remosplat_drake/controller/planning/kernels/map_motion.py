"""Checks the distances of spheres from a map along a motion.

The motion is sampled at eight times. Balls around several spheres are checked
first. Then the spheres in the balls that are possibly too near are checked.
Each part between two samples in which a sphere is possibly too near is sampled
in the same way, for these spheres only.
"""

from remosplat_drake.base.kernels import helper, kernel
from remosplat_drake.base.kernels.returns import TRUTH
from remosplat_drake.base.lanes import (
    WIDTH,
    greatest,
    lanes_from,
    lowest_bit,
    write_lanes,
)
from remosplat_drake.controller.planning.kernels.map_checks import (
    measure_margins,
)
from remosplat_drake.controller.planning.kernels.motion_samples import (
    ALL_PARTS,
    PARTS,
    changes,
    open_parts,
    sample_motion,
    samples_of,
)
from remosplat_drake.controller.planning.kernels.part_stack import (
    push_parts,
    take_part,
)
from remosplat_drake.controller.verification.kernels.between_samples import (
    TOLERANCE,
    bend_of,
    detour,
)
from remosplat_drake.robot.pose_lanes import place_by_lanes
from remosplat_drake.signals.compiled_map import is_compiled, is_lipschitz

_SHORTEST = 1.0 / 1024
"""Duration below which a part is rejected instead of divided [s]."""


@kernel(returns=TRUTH)
def keeps_off_the_map(space, line, q, u):
    """Returns whether all spheres keep their clearances along a motion.

    Clearances may be smaller by the tolerance of verification. For a map that
    is not 1-Lipschitz, they are checked only at the samples.

    Args:
        space: The `SpaceArrays`.
        line: Number of the `PythonCalls` of the map.
        q: Configuration at the start of the motion, shape (n_q,) [rad, m].
        u: The command, which is held for a second, shape (n_u,).
    """
    work = space.work
    parts = work.parts
    for j in range(len(u)):
        work.speed[j] = abs(u[j])
    work.bend[:] = -1.0
    sample_motion(space.robot, space.samples, q, u, 0.0, 1.0)
    count = _find_open_spheres(space, line)
    if count < 0:
        return False
    top = push_parts(parts, 0, 0.0, 1.0 / PARTS, count)
    while top > 0:
        start, end, count = take_part(parts, top)
        if end - start < _SHORTEST:
            return False
        sample_motion(space.robot, space.samples, q, u, start, end)
        parts.open[:count] = ALL_PARTS
        step = (end - start) / PARTS
        if not _find_open_parts(space, line, 0, count, step):
            return False
        top = push_parts(parts, top - 1, start, step, count)
        if top < 0:
            return False
    return True


@helper
def _find_open_spheres(space, line):
    """Finds the spheres that are possibly too near during the motion.

    Returns:
        The number of these spheres; -1 if a sphere has too small a margin at a
        sample.
    """
    order, parts, step = space.ball_order, space.work.parts, 1.0 / PARTS
    some = 1 if is_compiled(space.map) else len(order)
    count = 0
    for first in range(0, len(order), some):
        for k in range(some):
            parts.item[count + k] = order[first + k]
            parts.open[count + k] = ALL_PARTS
        _find_open_parts(space, line, count, count + some, step)
        last = _open_balls(space, count, count + some)
        if not _find_open_parts(space, line, count, last, step):
            # This ball often collides in the next motion, too.
            order[0], order[first] = order[first], order[0]
            return -1
        for row in range(count, last):
            if parts.open[row] != 0:
                parts.item[count] = parts.item[row]
                parts.open[count] = parts.open[row]
                count += 1
    return count


@helper
def _open_balls(space, first, last):
    """Replaces balls that are possibly too near by their spheres.

    Args:
        space: The `SpaceArrays`.
        first: Row of the first ball.
        last: Row after the last ball.

    Returns:
        The row after the last sphere.
    """
    balls, parts, row = space.balls, space.work.parts, first
    ball, is_open = parts.next_item[0], parts.next_item[1]
    for k in range(first, last):
        ball[k], is_open[k] = parts.item[k], parts.open[k]
    for k in range(first, last):
        if is_open[k] == 0:
            continue
        for place in range(balls.first[ball[k]], balls.first[ball[k] + 1]):
            parts.item[row], parts.open[row] = balls.member[place], is_open[k]
            row += 1
    return row


@helper
def _find_open_parts(space, line, first, last, step):
    """Finds the parts in which balls and spheres are possibly too near.

    Args:
        space: The `SpaceArrays`. Input: `PartStack.open` contains the parts to
            check for each item (ball or sphere). Output: it contains the parts
            in which the item is possibly too near.
        line: Number of the `PythonCalls` of the map.
        first: Row of the first item.
        last: Row after the last item.
        step: Time between two samples [s].

    Returns:
        Whether all spheres have sufficient margins at all samples.
    """
    work, groups, rows = space.work, len(space.balls.first) - 1, 0
    parts, queries = work.parts, work.queries
    for row in range(first, last):
        rows = _add_queries(space, row, step, rows)
    measure_margins(space, line, rows)
    at = 0
    for row in range(first, last):
        is_sphere = parts.item[row] >= groups
        samples = samples_of(parts.open[row])
        work.margin[:] = 0.0
        while samples:
            k = lowest_bit(samples)
            samples &= samples - 1
            work.margin[k] = queries.margin[at]
            if is_sphere and not work.margin[k] >= -TOLERANCE:
                return False
            at += 1
        way = lanes_from(work.way, row * WIDTH) - 2.0 * TOLERANCE
        parts.open[row] &= open_parts(work.margin, way)
        if is_sphere and not is_lipschitz(space.map):
            parts.open[row] = 0
    return True


@helper
def _add_queries(space, row, step, rows):
    """Adds the queries of an item at the samples that its parts need.

    Returns:
        The number of queries.
    """
    balls, work, X_WL = space.balls, space.work, space.samples.X_WL
    queries, i = work.queries, work.parts.item[row]
    body = balls.body[i : i + 1]
    if work.bend[i] < 0.0:
        work.bend[i] = bend_of(balls.hessian_bound[i], work.speed)
    place_by_lanes(X_WL, body, balls.p_LS[i : i + 1], work.p_WS)
    way = changes(work.p_WS, 0, 3) + detour(work.bend[i], step)
    write_lanes(work.way, row * WIDTH, way)
    write_lanes(work.either, 1, way)
    work.either[WIDTH] = 0.0
    longest = greatest(lanes_from(work.either, 0), lanes_from(work.either, 1))
    write_lanes(work.wanted, 0, longest)
    samples = samples_of(work.parts.open[row])
    while samples:
        k = lowest_bit(samples)
        samples &= samples - 1
        queries.item[rows], queries.wanted[rows] = i, work.wanted[k]
        for r in range(3):
            queries.p_WS[rows, r] = work.p_WS[0, r, k]
            if not is_compiled(space.map):
                for c in range(3):
                    queries.R_WL[rows, r, c] = X_WL[body[0], r, c, k]
        rows += 1
    return rows
