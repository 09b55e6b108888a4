"""What the apps that record with Apple's ARKit have in common."""

import numpy as np

from remosplat_drake.base.errors import FileError
from remosplat_drake.capture.images import Source

MIN_CONFIDENCE = 2
"""Depth is kept if ARKit trusts it this much: 0 low, 1 medium, 2 high. Around
edges medium depths float between two surfaces."""


def keep_confident(
    source: Source, depth: np.ndarray, levels: np.ndarray
) -> np.ndarray:
    """Depth (h, w) without what the confidence levels put in doubt.

    Args:
        source: The file with the levels.
        depth: Shape (h, w) [m].
        levels: As many numbers as `depth` has, 0 to 2.

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
