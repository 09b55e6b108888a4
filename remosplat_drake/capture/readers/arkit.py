"""Confidence of depths in the captures of apps that use Apple's ARKit."""

import numpy as np

from remosplat_drake.base.errors import FileError
from remosplat_drake.capture.images import Source

MIN_CONFIDENCE = 2
"""Least ARKit confidence of a depth that is used: 0 is low, 1 medium, 2 high.

At edges, depths of medium confidence are between two surfaces.
"""


def keep_confident(
    source: Source, depth: np.ndarray, levels: np.ndarray
) -> np.ndarray:
    """Sets depths of low confidence to 0, unknown.

    Args:
        source: The file with the confidence levels, which errors contain.
        depth: Depth, shape (h, w) [m].
        levels: Confidence of each pixel, 0 to 2, as many values as in `depth`.

    Raises:
        FileError: The sizes differ.
    """
    if levels.size != depth.size:
        raise FileError(
            str(source),
            f"has {levels.size} levels for {depth.size} depths",
        )
    sure = levels.reshape(depth.shape) >= MIN_CONFIDENCE
    return np.where(sure, depth, np.float32(0))
