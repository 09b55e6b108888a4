"""Converts raw network parameters to the values of a `GaussianSplat`."""

from pathlib import Path

import numpy as np

from remosplat_drake.base.errors import FileError, RemoSplatError
from remosplat_drake.splat.gaussian_splat import GaussianSplat

_TINY = np.finfo(np.float32).tiny


def sigmoid(logits: np.ndarray) -> np.ndarray:
    """Computes opacities in [0, 1] from their logits, of any shape."""
    with np.errstate(over="ignore", under="ignore"):
        return 1 / (1 + np.exp(-logits))


def logit(opacities: np.ndarray) -> np.ndarray:
    """Computes the logits of opacities, which are finite even for 0 and 1."""
    opacity = np.clip(opacities.astype(np.float64), _TINY, 1 - 2.0**-24)
    return np.log(opacity / (1 - opacity))


def exponential(log_scales: np.ndarray) -> np.ndarray:
    """Computes scales [m] from log scales; infinite where they overflow."""
    with np.errstate(over="ignore", under="ignore"):
        return np.exp(log_scales)


def checked_splat(
    path: Path,
    *,
    p_GK: np.ndarray,
    quaternions: np.ndarray,
    scales: np.ndarray,
    opacities: np.ndarray,
    colors: np.ndarray,
    sh_rest: np.ndarray,
    uncertainty: np.ndarray | None = None,
) -> GaussianSplat:
    """Makes a `GaussianSplat` from the activated values of a file.

    The arguments are the arrays of `GaussianSplat`. Scales and opacities that
    have underflowed to zero are raised to the smallest normal float.
    Quaternions may have any nonzero norm.

    Raises:
        FileError: The file contains no splats, or a value is invalid.
    """
    if not len(p_GK):
        raise FileError(path, "holds no splats")
    # The maximum is computed column by column, since NumPy computes the maximum
    # of short rows slowly.
    w, x, y, z = np.abs(quaternions).T
    length = np.maximum(np.maximum(w, x), np.maximum(y, z))[:, None]
    if (length == 0).any():
        row = (length == 0).argmax()
        raise FileError(path, f"row {row}: the quaternion is zero")
    try:
        with np.errstate(over="ignore", invalid="ignore"):
            return GaussianSplat(
                p_GK=p_GK,
                quaternions=quaternions / length,
                scales=_raised(scales),
                opacities=_raised(opacities),
                colors=colors,
                sh_rest=sh_rest,
                uncertainty=uncertainty,
            )
    except RemoSplatError as error:
        raise FileError(path, str(error)) from error


def _raised(values: np.ndarray) -> np.ndarray:
    if values.min(initial=np.inf) >= _TINY:
        return values
    return np.where((values >= 0) & (values < _TINY), _TINY, values)
