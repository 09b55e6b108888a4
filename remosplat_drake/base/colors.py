"""Display colours and the linear light that renderers compute with."""

import numpy as np


def linear_rgb(srgb: np.ndarray) -> np.ndarray:
    """Linear light of sRGB display colours in [0, 1], of any shape.

    Photos, splats and CAD files hold display colours; glTF materials and
    vertex colours are linear (IEC 61966-2-1). Values outside are clipped.
    """
    srgb = np.clip(np.asarray(srgb, float), 0.0, 1.0)
    return np.where(
        srgb <= 0.04045, srgb / 12.92, ((srgb + 0.055) / 1.055) ** 2.4
    )
