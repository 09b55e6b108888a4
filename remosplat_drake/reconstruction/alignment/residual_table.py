"""Table of the residuals of pairs of views, by the distance of the cameras."""

import itertools

import numpy as np

from remosplat_drake.reconstruction.alignment.alignment_summary import (
    ResidualRow,
)
from remosplat_drake.reconstruction.alignment.pair_kernel import pair_residuals
from remosplat_drake.reconstruction.alignment.solver import State
from remosplat_drake.reconstruction.alignment.view_stack import ViewStack

DISTANCES = (0.0, 0.25, 0.5, 1.0, 2.0, np.inf)
"""The table has one row for each range of the distance between two cameras;
these are the limits of the ranges [m].
"""

GATE, LEAST_COSINE = 0.15, 0.7
"""Two points belong to the same surface if their distance is at most the first
number [m], and the cosine of the angle between their normals is at least the
second number.
"""

_MOST = 0.02
"""When two solutions are compared, a larger distance between surfaces counts as
this distance [m]."""

_LEAST_POINTS = 20
"""A pair of views is used to compare two solutions if at least this many of its
points are near a surface of the other view in both solutions."""

_KEPT = 0.9
"""A refinement is rejected if the number of points near a surface of the other
view does not exceed this fraction of the number before it.
"""


def distances_of_pairs(
    stack: ViewStack, state: State, pairs: np.ndarray, stride: int = 2
) -> np.ndarray:
    """Returns distances of points from the surface of the pair's other view.

    Args:
        stack: The views.
        state: Poses, and errors of the camera.
        pairs: Indices of views (a, b), shape (m, 2).
        stride: Step between the points that are compared.

    Returns:
        Shape (m, k) [m]; NaN if the other view has no surface near the point.
    """
    kept = -(-stack.point.shape[1] // stride)
    values = np.empty((len(pairs), 2, kept, 2))
    pair_residuals(
        stack, state.pose, state.left, pairs, GATE, LEAST_COSINE, stride,
        values,
    )  # fmt: skip
    return np.abs(values[..., 0]).reshape(len(pairs), 2 * kept)


def residual_rows(
    X_WC: np.ndarray, pairs: np.ndarray, before: np.ndarray, after: np.ndarray
) -> list[ResidualRow]:
    """Tabulates residuals before and after a refinement, by camera distance.

    Args:
        X_WC: Poses, shape (n, 4, 4).
        pairs: Indices of views (a, b), shape (m, 2).
        before: The result of `distances_of_pairs` before the refinement, shape
            (m, k) [m].
        after: The result of `distances_of_pairs` after the refinement, which
            may have changed the images.
    """
    apart = np.linalg.norm(
        X_WC[pairs[:, 0], :3, 3] - X_WC[pairs[:, 1], :3, 3], axis=1
    )
    rows = []
    for low, high in itertools.pairwise(DISTANCES):
        here = (apart >= low) & (apart < high)
        old, new = before[here], after[here]
        old, new = old[np.isfinite(old)], new[np.isfinite(new)]
        if not (len(old) and len(new)):
            continue
        rows.append(
            ResidualRow(
                nearest=low,
                farthest=min(high, float(apart[here].max())),
                pairs=int(here.sum()),
                points=len(new),
                median_before=float(np.median(old)),
                high_before=float(np.percentile(old, 95)),
                median_after=float(np.median(new)),
                high_after=float(np.percentile(new, 95)),
            )
        )
    return rows


def is_better(before: np.ndarray, after: np.ndarray) -> bool:
    """Returns whether held-out pairs of views agree better after a refinement.

    After the refinement, nearly as many points as before it must be near a
    surface of the other view. For each pair, the mean distances are compared,
    in which distances above 2 cm are limited to 2 cm. The sum of all decreases
    minus that of all increases must exceed two limits: 0.01 of the sum of the
    means, and twice the sum of the increases. The second limit rejects a drift
    along a table, which only few pairs of views contradict.

    Args:
        before: Distances of points of m held-out pairs, shape (m, k) [m].
        after: Distances of these points after the refinement, shape (m, k) [m].
    """
    both = before, after
    counts = np.array([np.isfinite(each).sum(axis=1) for each in both])
    used = counts.min(axis=0) >= _LEAST_POINTS
    means = [
        np.nansum(np.minimum(each[used], _MOST), axis=1) / count[used]
        for each, count in zip(both, counts, strict=True)
    ]
    gain = means[0] - means[1]
    lost = np.maximum(-gain, 0).sum()
    kept = counts[1].sum() > _KEPT * counts[0].sum()
    return bool(kept and gain.sum() > max(2 * lost, 0.01 * means[0].sum()))
