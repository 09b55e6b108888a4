"""Image quality: PSNR and SSIM of two colour images, without hidden pixels.

Training uses the same SSIM on torch's tensors, see `photometric_loss`.
"""

import numpy as np
from scipy.ndimage import maximum_filter

from remosplat_drake.base.system_libraries import import_optional

_SIGMA, _REACH = 1.5, 5
"""Standard deviation and half width of SSIM's window (Wang et al., 2004)
[pixels]."""


def psnr(
    image: np.ndarray, target: np.ndarray, hidden: np.ndarray | None = None
) -> float:
    """Computes the peak signal-to-noise ratio of two images [dB].

    Args:
        image: The rendered image, shape (h, w, 3), in [0, 1].
        target: The captured image, of the same shape.
        hidden: Pixels that do not count, shape (h, w), bool; None: all count.

    Returns:
        The ratio [dB]; inf for equal images, NaN if no pixel counts.
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

    A pixel counts if its window of 11 x 11 pixels is in the image and has no
    hidden pixel.

    Args:
        image: The rendered image, shape (h, w, 3), in [0, 1].
        target: The captured image, of the same shape.
        hidden: Pixels that do not count, shape (h, w), bool; None: all count.

    Returns:
        The mean, at most 1; 1 for equal images, NaN if no pixel counts.

    Raises:
        MissingExtraError: scikit-image is not installed.
    """
    if min(image.shape[:2]) <= 2 * _REACH:
        return float("nan")
    metrics = import_optional(
        "skimage.metrics", "comparing images", "reconstruction"
    )
    _, similarity = metrics.structural_similarity(
        image.astype(float),
        target.astype(float),
        gaussian_weights=True,
        sigma=_SIGMA,
        use_sample_covariance=False,
        data_range=1.0,
        channel_axis=-1,
        full=True,
    )
    inner = slice(_REACH, -_REACH), slice(_REACH, -_REACH)
    similarity = similarity[inner]
    if hidden is not None:
        reached = maximum_filter(hidden, 2 * _REACH + 1)[inner]
        similarity = similarity[np.logical_not(reached)]
    return float(similarity.mean()) if similarity.size else float("nan")


def _squares(image: np.ndarray, target: np.ndarray) -> np.ndarray:
    return (image.astype(float) - target.astype(float)) ** 2
