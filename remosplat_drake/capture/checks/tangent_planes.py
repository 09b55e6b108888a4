"""Fits planes to small windows of depth images, for smooth depth and normals.

In the image of a plane a X + b Y + c Z = 1, the inverse depth is linear: 1 / Z
= a x + b y + c, with x = X / Z and y = Y / Z. The plane's normal (a, b, c)
points away from the camera.
"""

import dataclasses as dc

import numpy as np

from remosplat_drake.capture.capture import Capture

_WINDOW, _HALF_SIDE = 0.012, 3
"""Half the side of a window, as a fraction of the image's width (first number),
and number of samples along half the side (second number).
"""

_MIN_COSINE = 0.35
"""A plane is used only if the cosine of the angle of incidence exceeds this."""

_LEAST_ROUGHNESS = 1e-3
"""A window contains an edge if the residual of its plane, relative to the
depth, reaches this value plus three times the median residual of all windows.
"""


@dc.dataclass(frozen=True, eq=False)
class TangentPlanes:
    """Planes of surfaces at n pixels of a view, in its camera frame C.

    Attributes:
        plane: The planes (a, b, c), shape (n, 3) [1/m]. They are NaN if the
            window is partly outside the image, has unknown pixels, contains an
            edge, or shows a surface at a grazing angle.
        p_C: Points of the planes at the pixels' centres, shape (n, 3) [m]; NaN
            where the plane is NaN.
    """

    plane: np.ndarray
    p_C: np.ndarray

    @property
    def normal_C(self) -> np.ndarray:
        """Unit normals that point away from the camera, shape (n, 3)."""
        length = np.linalg.norm(self.plane, axis=1, keepdims=True)
        return self.plane / length

    def select(self, rows: np.ndarray) -> "TangentPlanes":
        """Returns the planes that a boolean mask or index array selects."""
        return TangentPlanes(self.plane[rows], self.p_C[rows])


def planes_under(capture: Capture, view: int, p_C: np.ndarray) -> TangentPlanes:
    """Fits planes at the pixels into which points of a view project.

    Args:
        capture: The views.
        view: Index of the view.
        p_C: Points in the view's camera frame, shape (n, 3) [m], or NaN.
    """
    K = capture.K[view]
    z = np.where(p_C[:, 2] > 0, p_C[:, 2], np.nan)
    with np.errstate(invalid="ignore", over="ignore"):
        u = K[0, 0] * p_C[:, 0] / z + K[0, 2]
        v = K[1, 1] * p_C[:, 1] / z + K[1, 2]
    column, row = (
        np.nan_to_num(x, nan=-1).clip(-1, 1e6).astype(int) for x in (u, v)
    )
    planes, roughness = fit_planes(K, capture.depth[view], row, column)
    ray = np.stack(
        [
            (column + 0.5 - K[0, 2]) / K[0, 0],
            (row + 0.5 - K[1, 2]) / K[1, 1],
            np.ones(len(row)),
        ],
        axis=1,
    )
    inverse = (planes * ray).sum(axis=1)
    length = np.linalg.norm(planes, axis=1) * np.linalg.norm(ray, axis=1)
    known = np.isfinite(inverse)
    flat = _LEAST_ROUGHNESS
    if known.any():
        flat += 3 * float(np.median(roughness[known]))
    usable = known & (roughness < flat) & (inverse > _MIN_COSINE * length)
    inverse = np.where(usable, inverse, np.nan)
    return TangentPlanes(
        np.where(usable[:, None], planes, np.nan), ray / inverse[:, None]
    )


def fit_planes(
    K: np.ndarray, depth: np.ndarray, row: np.ndarray, column: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Fits planes by least squares to the windows around some pixels.

    A plane goes through the centre of the paraboloid that fits the window best.
    A plane through the mean of the window's points would lie inside a curved
    object.

    Args:
        K: Intrinsic matrix, shape (3, 3) [pixels].
        depth: Depth z in C, shape (h, w) [m]; 0 where unknown.
        row: Rows of the windows' centres, shape (n,).
        column: Columns of the windows' centres, shape (n,).

    Returns:
        The planes (a, b, c), shape (n, 3) [1/m], and the root mean square
        residuals of the fits, as fractions of the depth, shape (n,). A plane is
        NaN if its window is partly outside the image or has unknown pixels.
    """
    height, width = depth.shape
    stride = max(1, round(_WINDOW * width / _HALF_SIDE))
    step = stride * np.arange(-_HALF_SIDE, _HALF_SIDE + 1)
    reach = int(step[-1])
    inside = (np.minimum(row, column) >= reach) & (row < height - reach)
    inside &= column < width - reach
    if not inside.any():
        return np.full((len(row), 3), np.nan), np.full(len(row), np.nan)
    rows = np.where(inside, row, reach)[:, None, None] + step[:, None]
    columns = np.where(inside, column, reach)[:, None, None] + step
    z = depth.take(rows.clip(0, height - 1) * width + columns).astype(float)
    inside &= (z > 0).all(axis=(1, 2))
    inverse = 1 / np.where(z > 0, z, 1)
    middle = inverse.mean(axis=(1, 2))
    square = np.square(step).sum() * len(step)
    right = (inverse * step).sum(axis=(1, 2)) / square
    down = (inverse * step[:, None]).sum(axis=(1, 2)) / square
    # By Pythagoras' theorem, since the three parts of the fit are orthogonal.
    left = np.square(inverse - middle[:, None, None]).mean(axis=(1, 2))
    left -= (right**2 + down**2) * np.square(step).mean()
    roughness = np.sqrt(np.maximum(left, 0)) / middle
    bend = np.square(step) - np.square(step).mean()
    bends = np.square(bend).sum() * len(step)
    middle = middle - np.square(step).mean() / bends * (
        (inverse * bend).sum(axis=(1, 2))
        + (inverse * bend[:, None]).sum(axis=(1, 2))
    )
    a, b = right * K[0, 0], down * K[1, 1]
    x = (column + 0.5 - K[0, 2]) / K[0, 0]
    y = (row + 0.5 - K[1, 2]) / K[1, 1]
    planes = np.stack([a, b, middle - a * x - b * y], axis=1)
    return np.where(inside[:, None], planes, np.nan), roughness
