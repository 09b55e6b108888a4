"""Selects pairs of views that share surfaces.

Pairs of neighbouring views alone would not show drift. So distant views are
also paired, which includes loop closures. The distances between cameras are
divided into bins. In each bin, a view is paired with the views that share most
of its surfaces.
"""

import numpy as np

from remosplat_drake.base.kernels import numpy_kernel
from remosplat_drake.reconstruction.alignment.pair_kernel import (
    VALUES,
    associate,
)
from remosplat_drake.reconstruction.alignment.view_stack import ViewStack

_POINTS = 60
"""Number of points of a view that the search for partner views uses."""

_LEAST_SHARED = 0.08
"""Two views are partners if each shows at least this fraction of the other's
points."""

_BINS = 4
"""Number of bins of distance; the same number of partners is chosen in each."""


@numpy_kernel
def shared_fractions(stack, pose, errors, gate, least_cosine, out):
    """Writes the fraction of view a's points that view b shows to out[a, b].

    See `associate` for the arguments.
    """
    values, arms = np.empty(VALUES), np.empty((2, len(errors), 3))
    for a in range(len(stack.count)):
        stride = max(1, stack.count[a] // _POINTS)
        for b in range(len(stack.count)):
            hits, tried = 0, 0
            for i in range(0, stack.count[a], stride):
                tried += 1
                if a != b and associate(
                    stack, pose, errors, a, b, i, gate, least_cosine, values,
                    arms,
                ):  # fmt: skip
                    hits += 1
            out[a, b] = hits / max(tried, 1)


def choose_pairs(
    stack: ViewStack,
    X_WC: np.ndarray,
    errors: np.ndarray,
    gate: float,
    least_cosine: float,
    partners: int,
) -> np.ndarray:
    """Chooses pairs of views that share surfaces.

    Args:
        stack: The n views.
        X_WC: Poses of the views, shape (n, 4, 4).
        errors: Errors that all images share, shape (k,).
        gate: Largest residual of a shared point [m].
        least_cosine: Least cosine between the normals of a shared point.
        partners: Number of partners that every view chooses, at most.

    Returns:
        Indices of views (a, b) with a < b, shape (m, 2), sorted.
    """
    n = len(stack.count)
    shared = np.zeros((n, n))
    shared_fractions(
        stack,
        np.ascontiguousarray(X_WC[:, :3]),
        errors,
        gate,
        least_cosine,
        shared,
    )
    shared = np.minimum(shared, shared.T)
    p_WC = X_WC[:, :3, 3]
    chosen = set()
    for a in range(n):
        others = np.flatnonzero(shared[a] >= _LEAST_SHARED)
        distance = np.linalg.norm(p_WC[others] - p_WC[a], axis=1)
        by_distance = others[np.argsort(distance, kind="stable")]
        for bin in np.array_split(by_distance, _BINS):
            best = bin[np.argsort(-shared[a, bin], kind="stable")]
            for b in best[: partners // _BINS].tolist():
                chosen.add((min(a, b), max(a, b)))
    return np.array(sorted(chosen), np.int64).reshape(-1, 2)
