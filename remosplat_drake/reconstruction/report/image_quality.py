"""Image quality: PSNR and SSIM of two colour images, without hidden pixels.

The SSIM is the one that training maximises (`losses.structural_similarity`),
without torch.
"""

import numpy as np
from scipy.ndimage import correlate1d, maximum_filter

_SIGMA, _REACH = 1.5, 5  # Of the Gaussian window (Wang et al. 2004) [px].
_C1, _C2 = 0.01**2, 0.03**2


def psnr(
    image: np.ndarray, target: np.ndarray, hidden: np.ndarray | None = None
) -> float:
    """Computes the peak signal-to-noise ratio of two images [dB].

    Args:
        image: The rendered image, shape (h, w, 3), in [0, 1].
        target: The captured image, of the same shape.
        hidden: Pixels that do not count, shape (h, w), bool; None: all count.

    Returns:
        inf for equal images, NaN if no pixel counts.
    """
    error = _squares(image, target)
    if hidden is not None:
        error = error[~hidden]
    if error.size == 0:
        return float("nan")
    with np.errstate(divide="ignore"):
        return float(-10 * np.log10(error.mean()))


def structural_similarity(
    image: np.ndarray, target: np.ndarray, hidden: np.ndarray | None = None
) -> float:
    """Computes the mean SSIM of two images (Wang et al., 2004).

    A pixel counts when its whole window of 11 x 11 pixels does.

    Args:
        image: The rendered image, shape (h, w, 3), in [0, 1].
        target: The captured image, of the same shape.
        hidden: Pixels that do not count, shape (h, w), bool; None: all count.

    Returns:
        At most 1, which equal images have; NaN if no pixel counts.
    """
    similarity = _similarity_map(image.astype(float), target.astype(float))
    if hidden is not None:
        reached = maximum_filter(hidden, 2 * _REACH + 1)
        similarity = similarity[np.logical_not(reached)]
    return float(similarity.mean()) if similarity.size else float("nan")


def _squares(image: np.ndarray, target: np.ndarray) -> np.ndarray:
    return (image.astype(float) - target.astype(float)) ** 2


def _similarity_map(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    mean_a, mean_b = _blur(a), _blur(b)
    var_a = _blur(a * a) - mean_a**2
    var_b = _blur(b * b) - mean_b**2
    covariance = _blur(a * b) - mean_a * mean_b
    return ((2 * mean_a * mean_b + _C1) * (2 * covariance + _C2)) / (
        (mean_a**2 + mean_b**2 + _C1) * (var_a + var_b + _C2)
    )


def _blur(x: np.ndarray) -> np.ndarray:
    """Gaussian means over windows, black beyond the border."""
    offset = np.arange(-_REACH, _REACH + 1)
    window = np.exp(-(offset**2) / (2 * _SIGMA**2))
    window /= window.sum()
    for axis in (0, 1):
        x = correlate1d(x, window, axis, mode="constant")
    return x
