"""Converts display colours to linear light, with which renderers compute."""

import numpy as np


def linear_rgb(srgb: np.ndarray) -> np.ndarray:
    """Converts sRGB display colours to linear light (IEC 61966-2-1).

    Photos, splats and CAD files contain display colours (sRGB). The materials
    and vertex colours of glTF files are linear.

    Args:
        srgb: Colours of any shape; values outside [0, 1] are clipped.

    Returns:
        Linear colours in [0, 1], of the same shape.
    """
    srgb = np.clip(np.asarray(srgb, float), 0.0, 1.0)
    return np.where(
        srgb <= 0.04045, srgb / 12.92, ((srgb + 0.055) / 1.055) ** 2.4
    )
