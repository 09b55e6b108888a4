"""Fills small gaps in depth images."""

import dataclasses as dc

import numpy as np
from scipy.ndimage import convolve, minimum_filter

from remosplat_drake.capture.capture import Capture

_KNOWN_AROUND = 5
"""An unknown pixel is in a small gap if at least this number of its eight
neighbours is known."""


def without_specks(capture: Capture) -> Capture:
    """Fills small gaps with the depth of the nearest neighbouring point.

    Around an unknown pixel no space counts as free, so vanished objects would
    stay in the map because of a few missing pixels. The result is used to
    compute free space, but not surfaces. Masked pixels, for example of the
    robot, stay unknown.
    """
    return dc.replace(
        capture, depth=np.stack([_filled(depth) for depth in capture.depth])
    )


def _filled(depth: np.ndarray) -> np.ndarray:
    known = depth > 0
    around = convolve(known.astype(np.uint8), np.ones((3, 3)), mode="nearest")
    nearest = minimum_filter(np.where(known, depth, np.inf), 3, mode="nearest")
    speck = ~known & (around >= _KNOWN_AROUND)
    return np.where(speck, nearest, depth).astype(np.float32)
