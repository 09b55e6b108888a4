"""`ConversionError`: the change of a splat that a file format causes."""

import dataclasses as dc

import numpy as np

from remosplat_drake.splat.gaussian_splat import GaussianSplat


@dc.dataclass(frozen=True)
class ConversionError:
    """Differences of corresponding Gaussians of two splats, of shape (N,).

    Attributes:
        position: Distance between the centres [m].
        scale: Largest ratio of two corresponding scales of the Gaussian, minus
            1.
        rotation: Angle between the orientations [rad].
        opacity: Absolute difference of the opacities.
    """

    position: np.ndarray
    scale: np.ndarray
    rotation: np.ndarray
    opacity: np.ndarray


def conversion_error(
    before: GaussianSplat, after: GaussianSplat
) -> ConversionError:
    """Compares Gaussian i of one splat with Gaussian i of another.

    Raises:
        ValueError: The splats differ in their number or kind of Gaussians.
    """
    if before.scales.shape != after.scales.shape:
        raise ValueError(f"{before.scales.shape} and {after.scales.shape}")
    logarithms = np.log(before.scales, dtype=float) - np.log(
        after.scales, dtype=float
    )
    a, b = before.quaternions.astype(float), after.quaternions.astype(float)
    # q and -q are the same rotation. The angle is computed from the chord,
    # since the arc cosine is inaccurate for small angles.
    chord = np.minimum(
        np.linalg.norm(a - b, axis=1), np.linalg.norm(a + b, axis=1)
    )
    return ConversionError(
        position=np.linalg.norm(before.p_GK - after.p_GK, axis=1),
        scale=np.expm1(np.abs(logarithms).max(axis=1)),
        rotation=4 * np.arcsin(np.minimum(chord / 2, 1)),
        opacity=np.abs(before.opacities - after.opacities),
    )
