"""Covers of points with spheres whose centres are in a body."""

import math

import numpy as np

from remosplat_drake.base.kernels import helper, kernel


@kernel
def needed_bulges(points, centers, depth):
    """Computes the bulge that each centre needs to cover each point.

    Args:
        points: Points on a surface, shape (n, 3) [m].
        centers: Centres of spheres, shape (k, 3) [m].
        depth: Depths of the centres in the body, shape (k,) [m].

    Returns:
        The bulges, shape (n, k) float32 [m].
    """
    need = np.empty((len(points), len(centers)), np.float32)
    # With its own array for each axis, the inner loop is vectorized.
    x, y, z = centers[:, 0].copy(), centers[:, 1].copy(), centers[:, 2].copy()
    for i in range(len(points)):
        p, q, r = points[i]
        for k in range(len(x)):
            square = (x[k] - p) ** 2 + (y[k] - q) ** 2 + (z[k] - r) ** 2
            need[i, k] = math.sqrt(square) - depth[k]
    return need


@kernel
def count_covered(need, bulge):
    """Counts the points that each centre covers with a given bulge.

    Args:
        need: The bulge that each centre needs, shape (n, k) [m].
        bulge: The bulge [m].

    Returns:
        The counts, shape (k,).
    """
    count = np.zeros(need.shape[1], np.int32)
    for i in range(len(need)):
        for k in range(len(count)):
            count[k] += need[i, k] <= bulge
    return count


@kernel
def close_covered(need, bulge, chosen, is_open, gain):
    """Closes the points that a centre covers.

    Args:
        need: The bulge that each centre needs, shape (n, k) [m].
        bulge: The bulge [m].
        chosen: Index of the centre.
        is_open: Whether points are open, shape (n,) bool; updated.
        gain: Number of open points that each centre covers, shape (k,);
            updated.
    """
    for i in range(len(need)):
        if is_open[i] and need[i, chosen] <= bulge:
            is_open[i] = False
            for k in range(len(gain)):
                gain[k] -= need[i, k] <= bulge


@kernel
def move_centers(points, centers, lowest, step, depth, origin, pitch):
    """Moves centres by at most a step to where they need less bulge.

    Each point belongs to the centre that covers it with the least bulge. A
    centre moves to that of the 27 points of a small grid around it at which its
    own points need the least bulge.

    Args:
        points: Points on a surface, shape (n, 3) [m].
        centers: Centres of spheres, shape (k, 3) [m]; updated.
        lowest: Least z of a centre [m].
        step: Edge of a cell of the small grid [m].
        depth: Depths on the voxel grid, see `SolidGrid` [m].
        origin: Centre of the first voxel, shape (3,) [m].
        pitch: Edge of a voxel [m].
    """
    n = len(points)
    at_center = np.empty(len(centers))
    for k in range(len(centers)):
        at_center[k] = _depth_at(depth, origin, pitch, centers[k])
    owner = np.empty(n, np.int64)
    for i in range(n):
        owner[i], _ = _owner(points[i], centers, at_center)
    own = np.empty((n, 3))
    trial, best = np.empty(3), np.empty(3)
    for k in range(len(centers)):
        count = 0
        for i in range(n):
            if owner[i] == k:
                own[count] = points[i]
                count += 1
        least = np.inf
        for x in (0.0, -1.0, 1.0):
            for y in (0.0, -1.0, 1.0):
                for z in (0.0, -1.0, 1.0):
                    trial[0] = centers[k, 0] + step * x
                    trial[1] = centers[k, 1] + step * y
                    trial[2] = max(centers[k, 2] + step * z, lowest)
                    inside = _depth_at(depth, origin, pitch, trial)
                    bulge = _reach(own, count, trial, inside + least) - inside
                    if bulge < least:
                        least = bulge
                        best[:] = trial
        if count:
            centers[k] = best


@kernel
def enclosing_radii(points, centers, depth):
    """Computes the radii at which spheres enclose all points.

    Each point belongs to the centre that covers it with the least bulge.

    Args:
        points: Points on a surface, shape (n, 3) [m].
        centers: Centres of spheres, shape (k, 3) [m].
        depth: Depths of the centres in the body, shape (k,) [m].

    Returns:
        The radii, shape (k,) [m]; zero for centres without points.
    """
    radius = np.zeros(len(centers))
    for i in range(len(points)):
        k, distance = _owner(points[i], centers, depth)
        radius[k] = max(radius[k], distance)
    return radius


@helper
def _owner(point, centers, depth):
    """Returns the centre with the least bulge, and the distance to it [m]."""
    owner, least, distance = 0, np.inf, 0.0
    for k in range(len(centers)):
        away = _distance(point, centers[k])
        if away - depth[k] < least:
            owner, least, distance = k, away - depth[k], away
    return owner, distance


@helper
def _reach(points, count, center, enough):
    """Returns the largest distance of points, or one of at least `enough`."""
    reach = 0.0
    for i in range(count):
        reach = max(reach, _distance(points[i], center))
        if reach >= enough:
            break
    return reach


@helper
def _distance(p, q):
    x, y, z = p[0] - q[0], p[1] - q[1], p[2] - q[2]
    return math.sqrt(x * x + y * y + z * z)


@helper
def _depth_at(depth, origin, pitch, p):
    """Interpolates the depth at a point, as `SolidGrid.depth_at` [m]."""
    value, beyond = 0.0, 0.0
    low, share = np.empty(3, np.int64), np.empty(3)
    for c in range(3):
        last = depth.shape[c] - 1
        cell = (p[c] - origin[c]) / pitch
        inside = min(max(cell, 0.0), float(last))
        beyond += (cell - inside) ** 2
        low[c] = min(int(inside), last - 1)
        share[c] = inside - low[c]
    for corner in range(8):
        i, j, k = corner & 1, corner >> 1 & 1, corner >> 2
        weight = share[0] if i else 1.0 - share[0]
        weight *= share[1] if j else 1.0 - share[1]
        weight *= share[2] if k else 1.0 - share[2]
        value += weight * depth[low[0] + i, low[1] + j, low[2] + k]
    return value - pitch * math.sqrt(beyond)
