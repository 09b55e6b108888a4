"""Evaluates and rotates spherical harmonics, a splat's view-dependent colours.

The real harmonics are those of 3D Gaussian splatting (Kerbl et al., 2023), with
the Condon-Shortley sign (-1)^m. Each degree l has 2 l + 1 harmonics, ordered by
m from -l to l.
"""

import math

import numpy as np
import scipy

from remosplat_drake.base.directions import spread_directions
from remosplat_drake.base.errors import RemoSplatError

_SAMPLES = 64
"""Directions at which harmonics are evaluated to compute their rotation."""


def harmonics(degree: int, directions: np.ndarray) -> np.ndarray:
    """Evaluates the real spherical harmonics of one degree.

    Args:
        degree: The degree l.
        directions: Unit vectors, shape (n, 3).

    Returns:
        Values, shape (n, 2 l + 1), ordered by m from -l to l.
    """
    x, y, z = directions.T
    azimuth = np.arctan2(y, x)
    columns = []
    for m in range(-degree, degree + 1):
        k = abs(m)
        norm = (2 * degree + 1) / (4 * np.pi)
        norm *= math.factorial(degree - k) / math.factorial(degree + k)
        wave = np.sin(k * azimuth) if m < 0 else np.cos(k * azimuth)
        twice = np.sqrt(2.0) if m else 1.0
        legendre = scipy.special.lpmv(k, degree, z)
        columns.append(twice * np.sqrt(norm) * legendre * wave)
    return np.stack(columns, axis=1)


def last_degree(coefficients: int) -> int:
    """Returns the degree for a given number of higher harmonics.

    Args:
        coefficients: Number of harmonics without that of degree 0.

    Raises:
        RemoSplatError: No degree has this number of harmonics.
    """
    degree = round(np.sqrt(coefficients + 1)) - 1
    if (degree + 1) ** 2 != coefficients + 1:
        raise RemoSplatError(
            f"{coefficients} higher harmonics match no degree; valid:"
            " 0, 3, 8, 15, 24"
        )
    return degree


def rotated_harmonics(sh_rest: np.ndarray, R_FG: np.ndarray) -> np.ndarray:
    """Expresses the higher harmonics of splats in another frame F.

    The colour along a direction d_G becomes the colour along R_FG d_G. A
    rotation mixes only harmonics of the same degree. The matrix of each degree
    is found by least squares from the harmonics' values at many directions.

    Args:
        sh_rest: Coefficients as in `GaussianSplat`, shape (N, K, 3).
        R_FG: Rotation matrix, shape (3, 3).

    Returns:
        The coefficients in F, shape (N, K, 3).

    Raises:
        RemoSplatError: No degree has K harmonics.
    """
    last = last_degree(sh_rest.shape[1])
    d_F = spread_directions(_SAMPLES)
    d_G = d_F @ R_FG
    rotated = np.empty_like(sh_rest)
    for degree in range(1, last + 1):
        band = slice(degree**2 - 1, (degree + 1) ** 2 - 1)
        there = np.linalg.pinv(harmonics(degree, d_F))
        turn = (there @ harmonics(degree, d_G)).astype(sh_rest.dtype)
        rotated[:, band] = turn @ sh_rest[:, band]
    return rotated
