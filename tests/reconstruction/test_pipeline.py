"""One way from surfels to discs, with and without views that clear space."""

import numpy as np
import pytest

from remosplat_drake.reconstruction.pipeline import reconstruct
from remosplat_drake.reconstruction.surfels.surfels import (
    Surfels,
    surfels_from_capture,
)

FLOATER = np.array([1.0, -0.2, 0.7])
"""In the air over the board, beside the cylinder."""


@pytest.fixture
def surfels(scene_capture) -> Surfels:
    """Surfels on all surfaces, the last one in the air."""
    found = surfels_from_capture(scene_capture, 3000)
    return Surfels(
        np.concatenate([found.p_WK, FLOATER[None]]),
        np.concatenate([found.normal_W, [[0.0, 0.0, 1.0]]]),
        np.concatenate([found.colors, [[0.5, 0.5, 0.5]]]),
        np.append(found.spacing, found.spacing[0]),
    )


@pytest.mark.parametrize("bounded", [False, True])
def test_what_looks_have_seen_through_is_dropped(
    scene_capture, surfels, bounded
):
    kept = [
        reconstruct(
            scene_capture, "none", surfels=surfels, looks=looks, bounded=bounded
        ).splat
        for looks in (None, scene_capture, scene_capture.select(np.array([0])))
    ]
    apart = [
        np.linalg.norm(splat.p_GK - FLOATER, axis=1).min() for splat in kept
    ]
    # A single view may be elsewhere: two must have looked through it.
    assert max(apart[0], apart[2]) < 1e-6 and apart[1] > 0.1
    assert len(kept[0]) == len(kept[1]) + 1
    for splat in kept:
        assert (splat.uncertainty is not None) is bounded
