"""Clearance of a hand of convex pieces at many poses among points."""

import numpy as np

from remosplat_drake.base.kernels import kernel
from remosplat_drake.base.kernels.returns import reals


@kernel(returns=reals(1))
def hand_clearances(
    planes: np.ndarray,
    first: np.ndarray,
    box: np.ndarray,
    X_OE: np.ndarray,
    points: np.ndarray,
    enough: float,
) -> np.ndarray:
    """Computes the clearance of a hand at each of several poses.

    A point's largest signed distance from the planes of a convex piece is a
    lower bound on its distance from the piece, and is negative inside. The same
    holds for the box around all pieces.

    Args:
        planes: Planes (a, b) of all pieces in E, with unit normals a, shape
            (h, 4); a'x + b <= 0 inside.
        first: Row of the first plane of each piece, and the number of planes,
            shape (s + 1,).
        box: Corners of the box around all pieces, lower and upper, (2, 3) [m].
        X_OE: Poses of the hand, shape (k, 4, 4).
        points: The points in O, shape (n, 3) [m].
        enough: Clearances above this value need not be exact [m].

    Returns:
        The clearances, shape (k,) [m]. A clearance that is not positive is that
        of the first overlapping point, and need not be the least.
    """
    clearance = np.full(len(X_OE), enough)
    for k in range(len(X_OE)):
        R, p = X_OE[k, :3, :3], X_OE[k, :3, 3]
        least = enough
        for i in range(len(points)):
            dx = points[i, 0] - p[0]
            dy = points[i, 1] - p[1]
            dz = points[i, 2] - p[2]
            x = R[0, 0] * dx + R[1, 0] * dy + R[2, 0] * dz
            y = R[0, 1] * dx + R[1, 1] * dy + R[2, 1] * dz
            z = R[0, 2] * dx + R[1, 2] * dy + R[2, 2] * dz
            outside = max(box[0, 0] - x, x - box[1, 0])
            outside = max(outside, max(box[0, 1] - y, y - box[1, 1]))
            outside = max(outside, max(box[0, 2] - z, z - box[1, 2]))
            if outside >= least:
                continue
            for s in range(len(first) - 1):
                away = outside
                for h in range(first[s], first[s + 1]):
                    a = planes[h]
                    away = max(away, a[0] * x + a[1] * y + a[2] * z + a[3])
                    if away >= least:
                        break
                least = min(least, away)
            if least <= 0.0:
                break
        clearance[k] = least
    return clearance
