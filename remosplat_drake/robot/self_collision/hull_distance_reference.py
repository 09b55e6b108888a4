"""Slow reference of the distance of two convex hulls, from its definition.

Both functions use the whole Minkowski difference, the set of all b - a.
"""

import numpy as np
from scipy.optimize import minimize
from scipy.spatial import ConvexHull


def signed_distance(p_WA: np.ndarray, p_WB: np.ndarray) -> float:
    """Computes the signed distance of two hulls, negative where they overlap.

    Args:
        p_WA: Vertices of hull A, shape (m, 3) [m].
        p_WB: Vertices of hull B, shape (n, 3) [m].

    Returns:
        The distance; if the hulls overlap, minus the least translation that
        separates them [m].
    """
    difference = (p_WB[None] - p_WA[:, None]).reshape(-1, 3)
    # Heights of the origin above the facets.
    heights = ConvexHull(difference).equations[:, 3]
    if (heights <= 0.0).all():
        return float(heights.max())
    return float(np.linalg.norm(nearest_to_origin(difference)))


def nearest_to_origin(points: np.ndarray) -> np.ndarray:
    """Finds the point of a hull nearest to the origin, as a quadratic program.

    Args:
        points: Points that span the hull, shape (n, 3) [m].

    Returns:
        The point, shape (3,) [m].
    """
    points = points[ConvexHull(points).vertices]
    n = len(points)
    start = np.zeros(n)
    start[np.linalg.norm(points, axis=1).argmin()] = 1.0
    found = minimize(
        lambda w: 0.5 * np.sum((w @ points) ** 2),
        start,
        jac=lambda w: points @ (w @ points),
        bounds=[(0.0, 1.0)] * n,
        constraints={
            "type": "eq",
            "fun": lambda w: w.sum() - 1.0,
            "jac": np.ones_like,
        },
        method="SLSQP",
        options={"ftol": 1e-14, "maxiter": 500},
    )
    return found.x @ points
