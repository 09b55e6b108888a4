"""Thins surfels where several of them have moved to nearly the same point."""

import numpy as np
from scipy.spatial import KDTree

from remosplat_drake.reconstruction.surfels.surfels import Surfels

_FAINT = 0.1
"""Of two surfels, the one with the lower weight is faint if the ratio of its
weight to the other's is less than this."""


def uncrowded(
    surfels: Surfels, weight: np.ndarray, crowding: float
) -> np.ndarray:
    """Selects surfels by non-maximum suppression.

    Of surfels that are crowded, the one with the largest weight is kept. A
    faint surfel, about which views contain little information, is removed if a
    surfel that is not faint is within its spacing, since the normal of the
    faint surfel is unreliable.

    Args:
        surfels: The n surfels.
        weight: Information from views about each surfel, see `refine`, shape
            (n,).
        crowding: Distance, as a fraction of the spacing, below which surfels
            with similar normals are crowded.

    Returns:
        Mask of the surfels that are kept, shape (n,), bool.
    """
    # In descending order of weight, ties by index.
    rank = np.empty(len(surfels), np.int64)
    rank[np.argsort(-weight, kind="stable")] = np.arange(len(surfels))
    pairs = KDTree(surfels.p_WK).query_pairs(
        float(np.percentile(surfels.spacing, 99)), output_type="ndarray"
    )
    better = np.where(
        rank[pairs[:, 0]] < rank[pairs[:, 1]], pairs[:, 0], pairs[:, 1]
    )
    worse = pairs.sum(axis=1) - better
    apart = np.linalg.norm(surfels.p_WK[better] - surfels.p_WK[worse], axis=1)
    apart /= surfels.spacing[worse]
    cosine = (surfels.normal_W[better] * surfels.normal_W[worse]).sum(axis=1)
    faint = weight[worse] < _FAINT * weight[better]
    close = ((cosine > 0.7) & (apart < crowding)) | (faint & (apart < 1))
    better, worse = better[close], worse[close]
    keep = np.ones(len(surfels), bool)
    for k in np.argsort(rank[better], kind="stable"):
        if keep[better[k]]:
            keep[worse[k]] = False
    return keep


def with_spacing(surfels: Surfels, kept: np.ndarray) -> Surfels:
    """Returns the selected surfels, with their new spacing."""
    p_WK, least = surfels.p_WK[kept], surfels.spacing[kept]
    neighbors, _ = KDTree(p_WK).query(p_WK, k=min(4, len(p_WK)))
    spacing = neighbors[:, 1:].mean(axis=1)
    return Surfels(
        p_WK,
        surfels.normal_W[kept],
        surfels.colors[kept],
        np.clip(spacing, least, 1.5 * least),
    )
