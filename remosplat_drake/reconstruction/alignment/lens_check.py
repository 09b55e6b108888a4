"""Judges whether a refined lens model fits the images."""

import numpy as np

from remosplat_drake.capture.checks.exactness import disagreement
from remosplat_drake.capture.checks.findings import LENS, WARNING, Finding
from remosplat_drake.capture.checks.wide_baselines import WideBaselines
from remosplat_drake.reconstruction.alignment.camera_errors import K1, K2

_IMPLAUSIBLE = 0.1
"""A radial distortion is implausible for images of a pinhole camera if |k_1| or
|k_2| exceeds this value. An equidistant fisheye lens has k_1 = -1/3.
"""


def judge_lens(wide: WideBaselines, undone: np.ndarray) -> list[Finding]:
    """Detects a wrong lens model from views that disagree after refinement.

    The two coefficients of the refined lens model describe a fisheye lens only
    in the middle of its images.

    Args:
        wide: Comparison of the refined views.
        undone: Camera errors that were corrected, see `camera_errors`.
    """
    found = disagreement(wide)
    strange = np.abs(undone[[K1, K2]]).max() > _IMPLAUSIBLE
    if found is None or not found.is_excessive or not strange:
        return []
    problem = (
        "the lens differs from that in the capture: a radial distortion of k1"
        f" {undone[K1]:+.2f} and k2 {undone[K2]:+.2f} was corrected, but"
        f" {found}; if it is a fisheye lens, calibrate the camera, and"
        " undistort its images or give its coefficients"
    )
    return [Finding(LENS, problem, WARNING)]
