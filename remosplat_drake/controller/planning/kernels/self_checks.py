"""Checks for self-collision in a configuration."""

from remosplat_drake.base.kernels import helper, kernel
from remosplat_drake.base.kernels.returns import TRUTH
from remosplat_drake.robot.self_collision.kernels.pair_distance import (
    least_distance,
    place_centers,
    shape_distance,
)

ROUNDING = 1e-9
"""Bound of rounding errors of distances [m]."""


@kernel(returns=TRUTH)
def is_off_itself(space, X_WL):
    """Returns whether all pairs of shapes keep their distances.

    Args:
        space: The `SpaceArrays`. If all distances are kept, the margins of the
            links are written to its working memory.
        X_WL: Poses of all bodies, shape (b, 4, 4).
    """
    work, pairs = space.self_work, space.self_pairs.pairs
    place_centers(pairs.link_boxes, X_WL, work.p_WL)
    place_centers(pairs.shapes, X_WL, work.p_WC)
    for link in range(len(pairs.boxes)):
        a, b = pairs.boxes[link, 0], pairs.boxes[link, 1]
        apart = least_distance(pairs.link_boxes, X_WL, work.p_WL, a, b)
        margin = apart - space.link_level[link]
        # For most pairs of links, the bounding boxes are far apart.
        if margin < 0.0 and not _is_apart(space, X_WL, link):
            return False
        work.margin[link] = max(margin, 0.0)
    return True


@helper
def _is_apart(space, X_WL, link):
    """Returns whether two links keep their distance."""
    pairs, level, work = (
        space.self_pairs.pairs,
        space.self_level,
        space.self_work,
    )
    shapes, body = pairs.shapes, pairs.shapes.body
    for k in range(pairs.start[link], pairs.start[link + 1]):
        kept = level[k] - pairs.allowance[k]
        i, j = pairs.first[k], pairs.second[k]
        if least_distance(shapes, X_WL, work.p_WC, i, j) >= kept:
            continue
        X_WA, X_WB, offset_W = X_WL[body[i]], X_WL[body[j]], work.offset_W
        for r in range(3):
            offset_W[r] = work.p_WC[j, r] - work.p_WC[i, r]
        found, _, _, _ = shape_distance(
            shapes, X_WA, X_WB, (i, j), offset_W, kept, work.gjk
        )
        if found < kept - ROUNDING:
            return False
    return True
