"""Distances of all pairs of shapes, in one configuration or in many."""

import numpy as np

from remosplat_drake.base.kernels import kernel
from remosplat_drake.robot.kinematics import body_poses
from remosplat_drake.robot.self_collision.kernels.gjk import make_work
from remosplat_drake.robot.self_collision.kernels.pair_distance import (
    centers_in_world,
    distance_beyond,
    least_distance,
)


@kernel
def pair_distances(pairs, X_WL, enough):
    """Computes the distances of k pairs of shapes.

    Args:
        pairs: The k pairs, as packed `PairArrays`.
        X_WL: Poses of all bodies, shape (b, 4, 4).
        enough: Distances above this value may be too small, but are still above
            it [m].

    Returns:
        The distances plus the pairs' allowances, shape (k,) [m].
    """
    first, second, start = pairs.first, pairs.second, pairs.start
    allowance, boxes = pairs.allowance, pairs.boxes
    shapes, link_boxes = pairs.shapes, pairs.link_boxes
    p_WC = centers_in_world(shapes, X_WL)
    p_WL = centers_in_world(link_boxes, X_WL)
    work = make_work()
    distance = np.empty(len(first))
    for link in range(len(start) - 1):
        a, b = boxes[link]
        apart = least_distance(link_boxes, X_WL, p_WL, a, b)
        for k in range(start[link], start[link + 1]):
            limit, found = enough - allowance[k], apart
            if found < limit:
                pair = first[k], second[k]
                found = distance_beyond(shapes, X_WL, p_WC, pair, limit, work)
            distance[k] = found + allowance[k]
    return distance


@kernel
def count_contacts(tree, pairs, states):
    """Counts the configurations in which each pair of links overlaps.

    Args:
        tree: The `TreeArrays`, packed.
        pairs: Packed `PairArrays`, with l pairs of links.
        states: Configurations, shape (m, n_q).

    Returns:
        The counts, shape (l,).
    """
    first, second, start = pairs.first, pairs.second, pairs.start
    boxes, shapes, link_boxes = pairs.boxes, pairs.shapes, pairs.link_boxes
    count = np.zeros(len(start) - 1, np.int64)
    work = make_work()
    for q in states:
        X_WL, _ = body_poses(tree, q)
        p_WC = centers_in_world(shapes, X_WL)
        p_WL = centers_in_world(link_boxes, X_WL)
        for link in range(len(start) - 1):
            a, b = boxes[link]
            if least_distance(link_boxes, X_WL, p_WL, a, b) > 0.0:
                continue
            for k in range(start[link], start[link + 1]):
                pair = first[k], second[k]
                found = distance_beyond(shapes, X_WL, p_WC, pair, 0.0, work)
                if found <= 0.0:
                    count[link] += 1
                    break
    return count
