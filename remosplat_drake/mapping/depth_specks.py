"""Fills the specks that depth cameras leave unmeasured."""

import dataclasses as dc

import numpy as np
from scipy.ndimage import convolve, minimum_filter

from remosplat_drake.capture.capture import Capture

_KNOWN_AROUND = 5
"""How many of an unknown pixel's eight neighbours must be known at least for it
to be a speck."""


def without_specks(capture: Capture) -> Capture:
    """Gives unknown specks the depth of the nearest point beside them.

    One unknown pixel keeps a view from having looked through anything around
    it, so that dropouts would hold in place what has gone. This is for
    telling what is free, and not for finding surfaces. What is hidden, by the
    robot for example, stays unknown.
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
