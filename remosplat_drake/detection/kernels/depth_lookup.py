"""Looks up a depth image in the direction of points."""

import math

import numpy as np

from remosplat_drake.base.kernels import kernel


@kernel
def depth_lookup(depth, K, X_WC, far, p_W):
    """Looks points up in an image.

    Args:
        depth: Depth image, shape (h, w), float32 [m]; 0 where it is unknown.
        K: Intrinsic matrix, shape (3, 3) [pixels].
        X_WC: Camera pose, shape (4, 4).
        far: Greatest depth of the camera's range [m].
        p_W: Points in W, shape (n, 3) [m].

    Returns:
        The points in C, shape (n, 3) [m], and the measured depths at their
        pixels, up to `far`, shape (n,) [m]; NaN where nothing was measured, or
        if a point is outside the image.
    """
    height, width = depth.shape
    n = len(p_W)
    p_C, measured = np.empty((n, 3)), np.full(n, math.nan)
    for i in range(n):
        x = p_W[i, 0] - X_WC[0, 3]
        y = p_W[i, 1] - X_WC[1, 3]
        z = p_W[i, 2] - X_WC[2, 3]
        for k in range(3):
            p_C[i, k] = X_WC[0, k] * x + X_WC[1, k] * y + X_WC[2, k] * z
        ahead = p_C[i, 2]
        if not ahead > 1e-6:
            continue
        u = K[0, 0] * p_C[i, 0] / ahead + K[0, 2]
        v = K[1, 1] * p_C[i, 1] / ahead + K[1, 2]
        if 0.0 <= u < width and 0.0 <= v < height:
            shown = float(depth[int(v), int(u)])
            if shown > 0.0:
                measured[i] = min(shown, far)
    return p_C, measured
