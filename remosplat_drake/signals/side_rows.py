"""Adds rows to `Clearances` for further surfaces near a sphere.

A sphere has one row, with a distance and its direction, for the nearest point
of a map. In a corner, a sphere that moves away from the nearest surface may
approach another surface, which has no row. Verification rejects such a command.
So a sphere needs rows for both surfaces in order to leave a corner. To find the
second surface, the map is queried at points slightly beside the sphere's
centre.
"""

import numpy as np

from remosplat_drake.base.kernels import helper, kernel
from remosplat_drake.base.kernels.packed import Packed
from remosplat_drake.base.kernels.returns import reals, several, wholes
from remosplat_drake.base.vectors import across, dot
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.signals.compiled_map import query_map
from remosplat_drake.signals.distance_field import Clearances, DistanceField
from remosplat_drake.signals.row_arrays import row_arrays

_STEP = 0.005
"""Offset of the additional query points from the sphere's centre [m]. It
exceeds the motion of a robot in one tick while the robot slowly leaves an
obstacle."""

_ALIKE = 0.99
"""Cosine of the angle below which two directions count as equal."""

_SIDES = 4
"""Number of query points beside the centre of a sphere."""

_ROWS = several(wholes(1), reals(1), reals(2), reals(2))


def with_side_rows(
    near: Clearances,
    field: DistanceField,
    robot: RobotModel,
    q: np.ndarray,
    below: float,
) -> Clearances:
    """Adds rows for further surfaces to spheres that are too near to a map.

    Args:
        near: The clearances in the configuration q.
        field: The map. If only Python can query it, no row is added.
        robot: The robot.
        q: Configuration, shape (n_q,) [rad, m].
        below: Spheres nearer to the map than this distance get further rows
            [m].

    Returns:
        The clearances, followed by the new rows.
    """
    maps, is_near = field.compiled_rows, (near.distance < below).any()
    if maps is None or not (is_near and np.isfinite(q).all()):
        return near
    spheres = robot.spheres_at(q)
    sphere, distance, direction_W, p_WC = side_rows(
        maps,
        Packed(row_arrays(near)),
        np.array(spheres.p_WS),
        np.array(spheres.radius),
        np.array(spheres.ignore_below),
        np.array(spheres.index, np.int64),
        float(below),
    )
    return Clearances(sphere, distance, direction_W, p_WC, near.revision)


@kernel(returns=_ROWS)
def side_rows(maps, rows, p_WS, radius, ignore_below, index, below):
    """Adds rows for further surfaces to spheres near a map, in a kernel.

    For each such sphere, the map is also queried at points beside the centre.
    The distance to a convex obstacle is a convex function. So its tangent plane
    at such a point gives a lower bound of the distance from the centre. The
    distance of a new row is this bound, or the distance of the sphere's nearest
    row if that is greater.

    Args:
        maps: The maps, in the form of `DistanceField.compiled_rows`.
        rows: The `RowArrays`.
        p_WS: Centres of the n spheres in W, shape (n, 3) [m].
        radius: Radii of the spheres, shape (n,) [m].
        ignore_below: Heights below which the spheres ignore the map, shape (n,)
            [m].
        index: Indices of the spheres among the robot's spheres, shape (n,); -1
            for other spheres.
        below: Spheres nearer to the map than this distance get further rows
            [m].

    Returns:
        The arrays of the `RowArrays`: first the given rows, then the new rows.
    """
    m = len(rows.sphere)
    sphere = np.empty((1 + _SIDES) * m, np.int64)
    distance = np.empty((1 + _SIDES) * m)
    direction_W = np.empty(((1 + _SIDES) * m, 3))
    p_WC = np.empty(((1 + _SIDES) * m, 3))
    sphere[:m], distance[:m] = rows.sphere, rows.distance
    direction_W[:m], p_WC[:m] = rows.direction_W, rows.p_WC
    count = m
    queries = np.empty((1 + _SIDES, 6))
    answer = np.empty((1 + _SIDES, 8))
    for row in range(m):
        if not rows.distance[row] < below:
            continue
        i = rows.sphere[row]
        axes = across(rows.direction_W[row], 0.0)
        for side in range(1 + _SIDES):
            step = 0.0
            if side:
                step = _STEP if side % 2 else -_STEP
            for c in range(3):
                queries[side, c] = p_WS[i, c] + step * axes[(side - 1) // 2, c]
            queries[side, 3] = radius[i] + abs(rows.distance[row]) + 2 * _STEP
            queries[side, 4] = ignore_below[i]
            queries[side, 5] = index[i]
        answer[:, 0] = -1.0
        query_map(maps, queries, answer)
        if answer[0, 0] < 0.0:
            continue
        for side in range(1, 1 + _SIDES):
            n_W = answer[side, 5:]
            if answer[side, 0] < 0.0 or _is_known(
                sphere, direction_W, count, i, n_W
            ):
                continue
            # This is the value at the sphere's centre of the tangent plane at
            # the offset point.
            beside = 0.0
            for c in range(3):
                beside += n_W[c] * (queries[side, c] - p_WS[i, c])
            more = answer[side, 1] + beside - answer[0, 1]
            sphere[count] = i
            distance[count] = rows.distance[row] + max(more, 0.0)
            for c in range(3):
                direction_W[count, c] = n_W[c]
                p_WC[count, c] = answer[side, 2 + c]
            count += 1
    return sphere[:count], distance[:count], direction_W[:count], p_WC[:count]


@helper
def _is_known(sphere, direction_W, count, i, n_W):
    """Whether a sphere already has a row of nearly the same direction."""
    for row in range(count):
        if sphere[row] == i and dot(direction_W[row], n_W) > _ALIKE:
            return True
    return False
