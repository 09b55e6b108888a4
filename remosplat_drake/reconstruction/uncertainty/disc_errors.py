"""Propagates errors of poses and of the camera to the discs of a splat.

A disc is at the weighted mean of the measurements of all views. An error of a
camera's pose displaces the measurements of this camera. So the errors of all
cameras displace the disc by the weighted mean of these displacements. Samples
of the joint distribution of the errors are used, because correlated errors of
views do not average out.
"""

import numpy as np

from remosplat_drake.base.kernels import numpy_kernel
from remosplat_drake.capture.capture import Capture
from remosplat_drake.reconstruction.alignment.camera_errors import (
    COUNT,
    add_displacements,
    velocity_C,
)
from remosplat_drake.reconstruction.alignment.pose_errors import PoseErrors
from remosplat_drake.reconstruction.surfels.surfel_gathering import DepthNoise
from remosplat_drake.splat.gaussian_splat import GaussianSplat

_AGREE = 0.01
"""Largest difference between a disc's depth and the measured depth at which a
view shows the disc, in addition to noise [m].
"""

_STEEPEST = 0.1
"""Least cosine of the angle of incidence with which the size of a pixel's
footprint on a surface is computed.
"""

_UNSEEN_EDGE = float(np.log(1000))
"""Factor of the bound on the distance of edges from a surface's last pixel.

Between the edge of a surface and the last pixel on it there is up to one
footprint F of a pixel, and the pixel grids of different views are independent.
So the probability that no view has a pixel within x of the edge is the product
of 1 - x / F over all views, which is at most exp(-x sum(1 / F)). It is a
thousandth for x = ln(1000) / sum(1 / F)."""


def disc_errors(
    capture: Capture,
    splat_W: GaussianSplat,
    noise: DepthNoise,
    errors: PoseErrors,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Computes the displacements of discs by errors of poses and camera.

    Args:
        capture: Posed RGB-D images.
        splat_W: The n discs, in W.
        noise: Noise of the depth, which determines the weights of the views.
        errors: The k samples of the errors.

    Returns:
        Three arrays. First, displacements along the discs' normals for each
        sample, shape (n, k) [m]; 0 for a disc that no view shows. Second, the
        distance between neighbouring pixels at each disc in the nearest view,
        across the line of sight, shape (n,) [m]; inf for a disc that no view
        shows. Third, the distance by which a surface may extend beyond the last
        pixel on it, see `_UNSEEN_EDGE`, shape (n,) [m]; inf for a disc that no
        view shows.
    """
    p_WK = np.array(splat_W.p_GK, float, order="C")
    normal_W = np.ascontiguousarray(splat_W.R_GK[:, :, 2])
    count = len(errors.camera)
    moved = np.zeros((len(splat_W), count))
    weight = np.zeros(len(splat_W))
    pitch = np.full(len(splat_W), np.inf)
    finest, pixels = pitch.copy(), np.zeros(len(splat_W))
    for view in range(len(capture)):
        _add_view(
            p_WK,
            normal_W,
            capture.depth[view],
            capture.K[view].astype(float),
            capture.X_WC[view].astype(float),
            noise,
            np.ascontiguousarray(errors.theta_W[:, view]),
            np.ascontiguousarray(errors.t_W[:, view]),
            np.ascontiguousarray(errors.camera),
            velocity_C(capture, view),
            moved,
            weight,
            pitch,
            finest,
            pixels,
        )
    moved /= np.maximum(weight, 1e-300)[:, None]
    edge = finest
    seen = pixels > 0
    edge[seen] = np.minimum(edge[seen], _UNSEEN_EDGE / pixels[seen])
    return moved, pitch, edge


@numpy_kernel
def _add_view(
    p_WK,
    normal_W,
    depth,
    K,
    X_WC,
    noise,
    theta,
    t,
    camera,
    velocity,
    moved,
    total,
    pitch,
    finest,
    pixels,
):
    """Adds a view's weighted displacements of each disc that it sees."""
    height, width = depth.shape
    arm, ray, n_C = np.zeros(3), np.zeros(3), np.zeros(3)
    lens = np.array([K[0, 0], K[1, 1], K[0, 2], K[1, 2]])
    b_C, along_n = np.zeros((COUNT, 3)), np.zeros(COUNT)
    for i in range(len(p_WK)):
        for k in range(3):
            arm[k] = p_WK[i, k] - X_WC[k, 3]
        z = X_WC[0, 2] * arm[0] + X_WC[1, 2] * arm[1] + X_WC[2, 2] * arm[2]
        if z <= 0:
            continue
        x = X_WC[0, 0] * arm[0] + X_WC[1, 0] * arm[1] + X_WC[2, 0] * arm[2]
        y = X_WC[0, 1] * arm[0] + X_WC[1, 1] * arm[1] + X_WC[2, 1] * arm[2]
        column = int(np.floor(K[0, 0] * x / z + K[0, 2]))
        row = int(np.floor(K[1, 1] * y / z + K[1, 2]))
        if not (0 <= column < width and 0 <= row < height):
            continue
        sigma = noise.floor + noise.growth * z * z
        if abs(depth[row, column] - z) > max(_AGREE, 4 * sigma):
            continue
        n = normal_W[i]
        along = n[0] * arm[0] + n[1] * arm[1] + n[2] * arm[2]
        squared = arm[0] ** 2 + arm[1] ** 2 + arm[2] ** 2
        weight = along * along / (squared * sigma * sigma)
        # n . (theta x arm) = theta . (arm x n)
        ray[0] = arm[1] * n[2] - arm[2] * n[1]
        ray[1] = arm[2] * n[0] - arm[0] * n[2]
        ray[2] = arm[0] * n[1] - arm[1] * n[0]
        add_displacements(lens, height, velocity, x / z, y / z, z, b_C)
        for k in range(3):
            n_C[k] = X_WC[0, k] * n[0] + X_WC[1, k] * n[1] + X_WC[2, k] * n[2]
        for e in range(COUNT):
            along_n[e] = (
                b_C[e, 0] * n_C[0] + b_C[e, 1] * n_C[1] + b_C[e, 2] * n_C[2]
            )
        for s in range(len(camera)):
            shift = 0.0
            for k in range(3):
                shift += theta[s, k] * ray[k] + t[s, k] * n[k]
            for e in range(COUNT):
                shift += camera[s, e] * along_n[e]
            moved[i, s] += weight * shift
        total[i] += weight
        pitch[i] = min(pitch[i], z / K[0, 0])
        cosine = max(abs(along) / np.sqrt(squared), _STEEPEST)
        footprint = z / (K[0, 0] * cosine)
        finest[i] = min(finest[i], footprint)
        pixels[i] += 1 / footprint
