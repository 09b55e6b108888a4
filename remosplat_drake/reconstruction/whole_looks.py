"""Counts the views in which cubes of space are completely free."""

import math

import numpy as np
from numba import prange

from remosplat_drake.base.kernels import helper, parallel_kernel
from remosplat_drake.capture.capture import Capture

_NOISE_DEPTH = 2.0
"""Depth beyond which margins grow with the square of the depth, like the noise
of triangulating cameras [m]."""

_NEAREST = 0.05
"""Cubes must be farther than this from a camera's centre [m]."""

_HALF_PIXEL = 0.71
"""Half the diagonal of a pixel, rounded up [pixels]."""


def count_whole_looks(
    capture: Capture,
    lower_W: np.ndarray,
    edge: float,
    *,
    margin: float,
    enough: int,
    pitch: float = np.inf,
) -> np.ndarray:
    """Counts, for each cube, the views that show all of it as free.

    A view shows a cube as free if the cube is completely in its image, and
    every pixel whose ray meets the cube has measured a surface behind it. A
    pixel without depth does not show free space.

    Args:
        capture: Posed RGB-D images.
        lower_W: Lower corners of axis-aligned cubes in W, shape (n, 3) [m].
        edge: Edge length of the cubes [m].
        margin: Least distance of measurements behind a cube [m]; beyond a depth
            of 2 m it grows with the square of the depth.
        enough: Number of views at which counting stops.
        pitch: Largest distance between neighbouring rays of a view at a cube
            [m]; views with a larger distance do not count.

    Returns:
        Number of views for each cube, at most `enough`, shape (n,), int64.
    """
    count = np.zeros(len(lower_W), np.int64)
    lower_W = np.ascontiguousarray(lower_W, float)
    for view in range(len(capture)):
        _count_looks(
            np.ascontiguousarray(capture.depth[view]),
            capture.K[view].astype(float),
            capture.X_WC[view].astype(float),
            lower_W,
            edge,
            margin,
            pitch,
            enough,
            count,
        )
    return count


@parallel_kernel
def _count_looks(depth, K, X_WC, lower_W, edge, margin, pitch, enough, count):
    """Increases the count of each cube that one view shows as free."""
    for i in prange(len(lower_W)):
        if count[i] < enough and _is_behind_centre(
            depth, K, X_WC, lower_W[i], edge, margin
        ):
            count[i] += _is_behind_all(
                depth, K, X_WC, lower_W[i], edge, margin, pitch
            )


@helper
def _is_behind_centre(depth, K, X_WC, lower_W, edge, margin):
    """Whether a view shows free space beyond a cube's centre."""
    x, y, z = _in_camera(X_WC, lower_W, edge, 0.5, 0.5, 0.5)
    if z <= _NEAREST:
        return False
    column = math.floor(K[0, 0] * x / z + K[0, 2])
    row = math.floor(K[1, 1] * y / z + K[1, 2])
    if not (0 <= row < depth.shape[0] and 0 <= column < depth.shape[1]):
        return False
    return depth[row, column] > z + margin * _noise(z)


@helper
def _is_behind_all(depth, K, X_WC, lower_W, edge, margin, pitch):
    """Whether all rays through a cube are close together and end behind it."""
    left = top = np.inf
    right = bottom = deepest = -np.inf
    for corner in range(8):
        a, b, c = corner & 1, corner >> 1 & 1, corner >> 2
        x, y, z = _in_camera(X_WC, lower_W, edge, a, b, c)
        if z <= _NEAREST:
            return False
        u = K[0, 0] * x / z + K[0, 2]
        v = K[1, 1] * y / z + K[1, 2]
        left, right = min(left, u), max(right, u)
        top, bottom = min(top, v), max(bottom, v)
        deepest = max(deepest, z)
    if deepest > pitch * min(K[0, 0], K[1, 1]):
        return False
    height, width = depth.shape
    if left < 0 or top < 0 or right >= width or bottom >= height:
        return False
    enough = margin * _noise(deepest)
    pad = _HALF_PIXEL * deepest / min(K[0, 0], K[1, 1])
    for row in range(math.floor(top), math.floor(bottom) + 1):
        for column in range(math.floor(left), math.floor(right) + 1):
            d = depth[row, column]
            if d > deepest + enough:
                continue
            x_C = (column + 0.5 - K[0, 2]) / K[0, 0]
            y_C = (row + 0.5 - K[1, 2]) / K[1, 1]
            leaves = _leaves(X_WC, x_C, y_C, lower_W, edge, pad)
            if leaves > 0 and not d > leaves + enough:
                return False
    return True


@helper
def _in_camera(X_WC, lower_W, edge, a, b, c):
    """A point of a cube in C, given by its offset from the corner in edges."""
    x = lower_W[0] + a * edge - X_WC[0, 3]
    y = lower_W[1] + b * edge - X_WC[1, 3]
    z = lower_W[2] + c * edge - X_WC[2, 3]
    return (
        X_WC[0, 0] * x + X_WC[1, 0] * y + X_WC[2, 0] * z,
        X_WC[0, 1] * x + X_WC[1, 1] * y + X_WC[2, 1] * z,
        X_WC[0, 2] * x + X_WC[1, 2] * y + X_WC[2, 2] * z,
    )


@helper
def _leaves(X_WC, x_C, y_C, lower_W, edge, pad):
    """The depth z at which a pixel's ray leaves a padded cube, -1 if never.

    The ray is t (x_C, y_C, 1), so that t is its depth.
    """
    enters, leaves = 0.0, np.inf
    for axis in range(3):
        slope = X_WC[axis, 0] * x_C + X_WC[axis, 1] * y_C + X_WC[axis, 2]
        near = lower_W[axis] - pad - X_WC[axis, 3]
        far = near + edge + 2 * pad
        if abs(slope) < 1e-12:
            if near > 0 or far < 0:
                return -1.0
            continue
        first, last = near / slope, far / slope
        enters = max(enters, min(first, last))
        leaves = min(leaves, max(first, last))
    return leaves if enters < leaves else -1.0


@helper
def _noise(z):
    """Length by which the margin grows at a depth [m]."""
    return max(1.0, z / _NOISE_DEPTH) ** 2
