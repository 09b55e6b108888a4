"""Refinement: noise averaged, edges kept, floaters gone, always alike."""

import dataclasses as dc

import numpy as np
import pytest

from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.capture.capture import Capture
from remosplat_drake.oracle.signed_distance import SignedDistanceField
from remosplat_drake.reconstruction.surfels.refinement import (
    RefinementConfig,
    refine,
)
from remosplat_drake.reconstruction.surfels.surfels import (
    Surfels,
    splat_of_surfels,
    surfels_from_capture,
)
from remosplat_drake.robot.sphere_model import Spheres


@pytest.fixture(scope="module")
def noisy_capture(scene_capture) -> Capture:
    """The capture with depth noise that grows with distance, in mm."""
    z = scene_capture.depth
    sigma = 0.001 + 0.002 * z**2
    noise = np.random.default_rng(0).normal(size=z.shape) * sigma
    rounded = np.round(1000 * (z + noise)) / 1000
    return dc.replace(
        scene_capture, depth=np.where(z > 0, rounded, 0).astype(np.float32)
    )


@pytest.fixture(scope="module")
def surfels(noisy_capture) -> Surfels:
    return surfels_from_capture(noisy_capture, count=4000, stride=1)


def offsets(scene, p_WK: np.ndarray) -> np.ndarray:
    """Distances of points from the scene's surfaces."""
    truth = SignedDistanceField(scene).clearances(Spheres.at(p_WK))
    return np.abs(truth.per_sphere(len(p_WK)))


def test_noise_is_averaged_over_the_views(scene, noisy_capture, surfels):
    splat = refine(noisy_capture, surfels)
    assert splat.is_surfel
    assert len(splat) > 0.6 * len(surfels)
    before = np.median(offsets(scene, surfels.p_WK))
    after = np.median(offsets(scene, splat.p_GK))
    assert after < 0.5 * before
    assert after < 1.2e-3
    colors = splat_of_surfels(surfels).colors
    assert splat.colors.min() >= 0 and splat.colors.max() <= 1
    assert abs(splat.colors.mean() - colors.mean()) < 0.05


def test_what_views_look_through_is_dropped(noisy_capture, surfels):
    """A disc in mid-air, in front of the cylinder's and the board's views."""
    stray = np.array([[1.0, -0.15, 0.72]])
    planted = Surfels(
        np.concatenate([surfels.p_WK, stray]),
        np.concatenate([surfels.normal_W, [[0.0, 0, 1]]]),
        np.concatenate([surfels.colors, [[1.0, 0, 0]]]),
        np.append(surfels.spacing, 0.02),
    )
    splat = refine(noisy_capture, planted)
    assert np.linalg.norm(splat.p_GK - stray, axis=1).min() > 0.05


def test_exact_depth_stays_exact(scene, scene_capture):
    surfels = surfels_from_capture(scene_capture, count=4000, stride=1)
    splat = refine(scene_capture, surfels)
    assert np.median(offsets(scene, splat.p_GK)) < 2e-4
    # Discs end at the edges: their rims are on the scene, too.
    for axis in (0, 1):
        for sign in (-1, 1):
            rim = (
                splat.p_GK
                + sign * splat.scales[:, axis, None] * (splat.R_GK[:, :, axis])
            )
            assert np.percentile(offsets(scene, rim), 98) < 4e-3


def test_it_is_deterministic_and_tells_its_progress(noisy_capture, surfels):
    calls = []
    config = RefinementConfig(sweeps=2)
    splats = [
        refine(noisy_capture, surfels, config, lambda *call: calls.append(call))
        for _ in range(2)
    ]
    assert splats[0].content_hash == splats[1].content_hash
    n = len(noisy_capture)
    assert calls[: len(calls) // 2] == [(k + 1, 3 * n) for k in range(3 * n)]


def test_surfels_of_another_capture_are_refused(noisy_capture, surfels):
    elsewhere = dc.replace(surfels, p_WK=surfels.p_WK + 50)
    with pytest.raises(RemoSplatError, match="no view"):
        refine(noisy_capture, elsewhere)
