"""Fills small gaps in depth images."""

import dataclasses as dc

import numpy as np
from scipy.ndimage import convolve, minimum_filter

from remosplat_drake.capture.capture import Capture

_KNOWN_AROUND = 5
"""Least number of known neighbours, of eight, of an unknown pixel in a small
gap."""


def without_specks(capture: Capture) -> Capture:
    """Fills small gaps with the depth of the nearest neighbouring point.

    One unknown pixel prevents the view from counting as free around it, so that
    dropouts would preserve vanished things. The result is for free space, not
    for surfaces. Masked pixels, of the robot for example, stay unknown.
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
