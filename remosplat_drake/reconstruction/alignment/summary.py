"""What a quality report says of an alignment."""

import numpy as np

from remosplat_drake.reconstruction.alignment.alignment import Alignment
from remosplat_drake.reconstruction.alignment.camera_errors import (
    COUNT,
    OFFSET,
    SCALE,
)
from remosplat_drake.reconstruction.alignment.perturbation import difference
from remosplat_drake.reconstruction.report.alignment_summary import (
    AlignmentSummary,
)


def summarize_alignment(
    alignment: Alignment, given: np.ndarray
) -> AlignmentSummary:
    """Summarises an alignment of a capture with given poses (n, 4, 4)."""
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
        words=_words(alignment, moved, turned),
    )


def _words(alignment: Alignment, moved: float, turned: float) -> str:
    if alignment.accepted:
        words = (
            f"Cameras were moved by {1e3 * moved:.1f} mm and"
            f" {np.rad2deg(turned):.2f} degrees (median); depth was multiplied"
            f" by {alignment.scale:.4f} ± {alignment.deviations[SCALE]:.4f}"
            f" and {1e3 * alignment.offset:+.1f} mm added."
        )
    else:
        words = (
            "The given poses are kept: pairs of views that the refinement did"
            " not use agree no better with it."
        )
    if alignment.groups > 1:
        words += f" {alignment.groups} groups of views share no surface."
    return words
