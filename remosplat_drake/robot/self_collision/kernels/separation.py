"""Distances of convex shapes along a direction, at eight configurations."""

import math

import numpy as np

from remosplat_drake.base.kernels import helper
from remosplat_drake.base.lanes import (
    WIDTH,
    greatest,
    greatest_of,
    in_all,
    lanes_from,
    least,
)
from remosplat_drake.robot.pose_lanes import entry, turned, turned_back


@helper
def separations(shapes, X_WL, pair, n_A):
    """Computes the gap between two shapes along a direction, as lanes.

    It is a lower bound on their distance.

    Args:
        shapes: The shapes.
        X_WL: Poses of all bodies, see `pose_lanes`.
        pair: The first shape and the second.
        n_A: Unit vector in the frame A of the first one's link, from the first
            to the second, shape (3,).
    """
    i, j = pair
    A, B = shapes.body[i], shapes.body[j]
    n_W = turned(X_WL, A, n_A)
    gap = in_all(-_highest(shapes.blocks, shapes.first, i, n_A))
    for r in range(3):
        gap = gap + n_W[r] * (entry(X_WL, B, r, 3) - entry(X_WL, A, r, 3))
    x, y, z = turned_back(X_WL, B, n_W)
    lowest = in_all(math.inf)
    for block in range(shapes.first[j], shapes.first[j + 1]):
        for k in range(WIDTH):
            v = shapes.blocks[block, :, k]
            lowest = least(lowest, x * v[0] + y * v[1] + z * v[2])
    return gap + lowest - (shapes.radius[i] + shapes.radius[j])


@helper
def _highest(blocks, first, i, n):
    """Returns the height of a shape's highest vertex along a direction [m]."""
    top = in_all(-np.inf)
    for block in range(first[i], first[i + 1]):
        at = 3 * WIDTH * block
        height = n[0] * lanes_from(blocks, at)
        height = height + n[1] * lanes_from(blocks, at + WIDTH)
        top = greatest(top, height + n[2] * lanes_from(blocks, at + 2 * WIDTH))
    return greatest_of(top)
