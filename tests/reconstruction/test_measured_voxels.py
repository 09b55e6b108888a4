"""The measurements of all depth images, pooled; and their noise."""

import dataclasses as dc

import numpy as np
import pytest
from plane_views import looking_down

from remosplat_drake.reconstruction.surfels.refinement import refine
from remosplat_drake.reconstruction.surfels.surfel_gathering import DepthNoise
from remosplat_drake.reconstruction.surfels.surfels import (
    Surfels,
    splat_of_surfels,
    surfels_from_capture,
)
from remosplat_drake.reconstruction.uncertainty.depth_noise import (
    estimate_noise,
)
from remosplat_drake.reconstruction.uncertainty.measured_voxels import (
    measured_voxels,
)

NOISE = DepthNoise(0.001, 0.002, 0.1, 0.1)


def test_pixels_of_a_voxel_are_averaged_by_their_noise(scene_capture):
    pair = scene_capture.select(np.array([0, 0]))
    once = measured_voxels(pair.select(np.array([0])), NOISE)
    twice = measured_voxels(pair, NOISE)
    np.testing.assert_allclose(twice.p_W, once.p_W, atol=1e-12)
    np.testing.assert_allclose(twice.sigma, once.sigma / np.sqrt(2))
    assert (once.views == 1).all() and (twice.views == 2).all()
    length = np.linalg.norm(once.ray_W, axis=1)
    assert length.max() <= 1 + 1e-12 and np.median(length) > 0.999


def test_what_as_many_views_looked_through_is_left_out(scene_capture):
    """A speck in mid-air before one camera, which others look past."""
    whole = measured_voxels(scene_capture, NOISE)
    depth = scene_capture.depth.copy()
    row, column = np.unravel_index(depth[0].argmax(), depth[0].shape)
    depth[0, row, column] *= 0.5
    specked = dc.replace(scene_capture, depth=depth)
    speck_W = specked.points_W(0)[row, column]
    after = measured_voxels(specked, NOISE)
    apart = np.linalg.norm(after.p_W - speck_W, axis=1).min()
    own = np.linalg.norm(whole.p_W - speck_W, axis=1).min()
    assert own > 0.05 and apart > 0.02


@pytest.mark.parametrize(("elevation", "is_kept"), [(0, True), (45, False)])
def test_views_along_a_leaf_do_not_contradict_the_view_onto_it(
    elevation, is_kept
):
    """A leaf of 25 mm, horizontal, 0.5 m below one camera.

    Three cameras see it under an elevation, and measure a wall 1 m behind it.
    """
    leaf_W = np.array([0.0, 0, 0.5])
    slope = np.deg2rad(elevation)
    z_W = np.array([np.cos(slope), 0, -np.sin(slope)])
    aside = looking_down(np.array([[0.0, 0, 1]] * 4))
    X_WC, depth = aside.X_WC, aside.depth
    x_W = np.array([0.0, -1, 0])
    X_WC[1:, :3, :3] = np.stack([x_W, np.cross(z_W, x_W), z_W], axis=1)
    X_WC[1:, :3, 3] = leaf_W - z_W
    depth[0, 38:43, 38:43] = 0.5
    depth[1:] = 2.0
    measured = measured_voxels(aside, DepthNoise(1e-4, 0.0, 0.1, 0.1))
    near = np.linalg.norm(measured.p_W - leaf_W, axis=1) < 0.02
    assert near.sum() == (25 if is_kept else 0)


def test_single_noisy_looks_are_not_confirmed(scene_capture):
    measured = measured_voxels(scene_capture, NOISE)
    confirmed = measured.is_confirmed(0.005)
    assert confirmed.any() and not confirmed.all()
    kept = measured.select(confirmed)
    assert ((kept.views > 1) | (kept.sigma < 5e-4)).all()
    exact = measured_voxels(scene_capture, DepthNoise(1e-4, 0.0, 0.1, 0.1))
    assert exact.is_confirmed(0.005).all()


def test_the_noise_of_the_depth_is_found_again(scene_capture):
    z = scene_capture.depth
    for floor, growth in ((0.0, 0.004), (0.003, 0.0), (0.001, 0.002)):
        sigma = floor + growth * z**2
        noise = np.random.default_rng(0).normal(size=z.shape) * sigma
        noisy = dc.replace(
            scene_capture, depth=np.where(z > 0, z + noise, 0).astype("f4")
        )
        splat = refine(noisy, surfels_from_capture(noisy, 4000, stride=1))
        found = estimate_noise(noisy, splat)
        for depth in (0.8, 1.5, 2.2):
            expected = floor + growth * depth**2
            ratio = (found.floor + found.growth * depth**2) / expected
            assert 0.7 < ratio < 1.4, (floor, growth, depth, ratio)


def test_discs_that_lie_in_the_noise_do_not_hide_it():
    """A plane 1 m below four cameras, with 4 mm of noise.

    A tenth of its discs lie 6 mm above or below it, and are the discs nearest
    to the points beyond them.
    """
    rng = np.random.default_rng(0)
    plane = looking_down(np.array([[x, 0.0, 1] for x in (0, 0.1, 0.2, 0.3)]))
    noise = 0.004 * rng.standard_normal(plane.depth.shape)
    noisy = dc.replace(plane, depth=(plane.depth + noise).astype("f4"))
    grid = np.arange(-0.5, 0.8, 0.01)
    p_WK = np.stack(np.meshgrid(grid, grid, 0), axis=-1).reshape(-1, 3)
    stray = rng.random(len(p_WK)) < 0.1
    p_WK[stray, 2] = 0.006 * rng.choice([-1, 1], stray.sum())
    up_W = np.tile([0.0, 0, 1], (len(p_WK), 1))
    grey, spacing = np.full(p_WK.shape, 0.5), np.full(len(p_WK), 0.01)
    splat = splat_of_surfels(Surfels(p_WK, up_W, grey, spacing))
    found = estimate_noise(noisy, splat)
    assert found.floor + found.growth == pytest.approx(0.004, rel=0.05)


def test_exact_depth_has_hardly_any_noise(scene_capture):
    surfels = surfels_from_capture(scene_capture, 4000, stride=1)
    noise = estimate_noise(scene_capture, refine(scene_capture, surfels))
    assert noise.floor + noise.growth < 5e-4
