"""A texture defined in all of space, so that plain solids have features.

It is the mean of plane waves with wavelengths from 7 to 80 cm. It depends only
on the point in W, so a surface has the same texture in all views.
"""

import math

import numpy as np

from remosplat_drake.base.kernels import kernel
from remosplat_drake.capture.capture import back_project

_MEAN, _CONTRAST = 0.85, 0.4
_SLOWEST, _FASTEST = 8.0, 90.0  # Wave numbers [rad/m].
_COUNT = 8


def _wave_vectors() -> np.ndarray:
    """Wave vectors in W, shape (8, 3) [rad/m]; they are constant."""
    waves = np.random.default_rng(0).normal(size=(_COUNT, 3))
    length = np.geomspace(_SLOWEST, _FASTEST, _COUNT)[:, None]
    return waves * (length / np.linalg.norm(waves, axis=1, keepdims=True))


_WAVES_W = _wave_vectors()


def brightness_reference(
    K: np.ndarray, depth: np.ndarray, X_WC: np.ndarray
) -> np.ndarray:
    """Reference of `brightness`, which evaluates points in W."""
    p_W = np.nan_to_num(back_project(K, depth, X_WC))
    return _MEAN + _CONTRAST * np.sin(p_W @ _WAVES_W.T).mean(axis=-1)


def brightness(
    K: np.ndarray, depth: np.ndarray, X_WC: np.ndarray
) -> np.ndarray:
    """Evaluates the texture at the points that a depth image shows.

    Args:
        K: Intrinsic matrix, shape (3, 3) [pixels].
        depth: Depth z in C, shape (h, w) [m]; the result is arbitrary where it
            is 0.
        X_WC: Camera pose (OpenCV axes), shape (4, 4).

    Returns:
        Factors of the brightness around 0.85, shape (h, w).
    """
    # The phase of a wave at p_W = R_WC p_C + p_WC is linear in p_C.
    return _brightness(
        np.ascontiguousarray(depth),
        _WAVES_W @ X_WC[:3, :3] @ np.linalg.inv(K),
        _WAVES_W @ X_WC[:3, 3],
    )


@kernel
def _brightness(depth, wave_by_pixel, phase):
    height, width = depth.shape
    image = np.empty((height, width), np.float32)
    for i in range(height):
        for j in range(width):
            z = depth[i, j]
            total = 0.0
            if z > 0:
                u, v = j + 0.5, i + 0.5
                for k in range(len(phase)):
                    a = wave_by_pixel[k]
                    total += math.sin(
                        z * (a[0] * u + a[1] * v + a[2]) + phase[k]
                    )
            image[i, j] = _MEAN + _CONTRAST * total / len(phase)
    return image
