"""Summarises an alignment for a quality report."""

import numpy as np

from remosplat_drake.reconstruction.alignment.alignment import Alignment
from remosplat_drake.reconstruction.alignment.alignment_summary import (
    AlignmentSummary,
)
from remosplat_drake.reconstruction.alignment.camera_errors import (
    COUNT,
    OFFSET,
    SCALE,
)
from remosplat_drake.reconstruction.alignment.camera_summary import (
    camera_errors,
    words_of_camera,
)
from remosplat_drake.reconstruction.alignment.perturbation import difference


def summarize_alignment(
    alignment: Alignment, given: np.ndarray
) -> AlignmentSummary:
    """Summarises an alignment; the given poses have the shape (n, 4, 4)."""
    motion = difference(alignment.capture.X_WC, given)
    sizes = np.linalg.norm(motion.reshape(-1, 2, 3), axis=2)
    turned, moved = np.median(sizes, axis=0).tolist()
    variances = np.diag(alignment.covariance)[:-COUNT].reshape(-1, 6)
    position_std = np.sqrt(variances[:, 3:].sum(axis=1))
    return AlignmentSummary(
        accepted=alignment.accepted,
        scale=alignment.scale,
        scale_std=float(alignment.deviations[SCALE]),
        offset=alignment.offset,
        offset_std=float(alignment.deviations[OFFSET]),
        moved=moved,
        turned=turned,
        position_std=float(np.median(position_std)),
        groups=alignment.groups,
        rows=alignment.rows,
        camera=camera_errors(alignment),
        words=_words(alignment, moved, turned),
    )


def _words(alignment: Alignment, moved: float, turned: float) -> str:
    if alignment.accepted:
        sentences = [
            f"Cameras were moved by {1e3 * moved:.1f} mm and"
            f" {np.rad2deg(turned):.2f} degrees (median).",
            *words_of_camera(alignment),
        ]
    else:
        sentences = [
            "The given poses are kept: with refined poses, held-out pairs of"
            " views do not agree better, or the estimated errors"
            " of the camera are implausibly large."
        ]
    if alignment.groups > 1:
        sentences.append(
            f"{alignment.groups} groups of views share no surface."
        )
    return " ".join(sentences)
