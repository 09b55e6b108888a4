"""The bound of discs on the plane z = 0, which two views look down on."""

import dataclasses as dc

import numpy as np
import pytest
from plane_views import FOCAL, looking_down

from remosplat_drake.capture.capture import Capture
from remosplat_drake.oracle.sphere_to_ellipsoid import SphereToEllipsoidField
from remosplat_drake.reconstruction.alignment.camera_errors import COUNT
from remosplat_drake.reconstruction.alignment.pose_errors import PoseErrors
from remosplat_drake.reconstruction.surfels.surfels import (
    Surfels,
    splat_of_surfels,
)
from remosplat_drake.reconstruction.uncertainty.bound import (
    LARGEST_EDGE,
    LARGEST_PITCH,
    SIGNIFICANCE,
    bound_splat,
)
from remosplat_drake.robot.sphere_model import Spheres
from remosplat_drake.splat.gaussian_splat import GaussianSplat

HEIGHT, SPACING = 1.0, 0.02


@pytest.fixture(scope="module")
def capture() -> Capture:
    return looking_down(np.array([[-0.05, 0, HEIGHT], [0.05, 0, HEIGHT]]))


def bounded(
    capture: Capture, errors: PoseErrors | None = None
) -> GaussianSplat:
    """The splat of a square of discs, with its bounds."""
    side = np.arange(-0.5, 0.5, SPACING)
    x, y = np.meshgrid(side, side)
    p_W = np.stack([x.ravel(), y.ravel(), np.zeros(x.size)], axis=1)
    up = np.tile([0.0, 0, 1], (len(p_W), 1))
    gray = np.full((len(p_W), 3), 0.5)
    spacing = np.full(len(p_W), SPACING)
    plane = splat_of_surfels(Surfels(p_W, up, gray, spacing))
    return bound_splat(capture, plane, errors).bounded_W


def bounds(capture: Capture, errors: PoseErrors | None = None) -> np.ndarray:
    """Bounds of the discs near the middle, which both views see."""
    splat_W = bounded(capture, errors)
    assert splat_W.uncertainty is not None
    return splat_W.uncertainty[np.abs(splat_W.p_GK[:, :2]).max(axis=1) < 0.2]


def rising(rise: np.ndarray) -> PoseErrors:
    """Draws in which the cameras are too low by rows of `rise`, (k, 2) [m]."""
    t_W = rise[:, :, None] * [0.0, 0, 1]
    none = np.zeros((len(rise), COUNT))
    return PoseErrors(np.zeros_like(t_W), t_W, none)


def test_two_exact_views_leave_one_footprint_of_a_pixel(capture):
    """1 cm at 1 m: an edge may lie all of it beyond, of which 8 mm count."""
    assert HEIGHT / FOCAL > LARGEST_EDGE
    exact = bounds(capture)
    assert exact.min() >= LARGEST_EDGE
    assert exact.max() < LARGEST_EDGE + 0.001


def test_many_exact_views_leave_the_pitch_of_their_pixels(capture):
    many = bounds(capture.select(np.arange(80) % len(capture)))
    assert many.min() >= LARGEST_PITCH
    assert many.max() < LARGEST_PITCH + 0.001


def test_a_common_error_of_the_poses_is_covered_and_single_ones_average(
    capture,
):
    draws = 0.005 * np.random.default_rng(0).standard_normal((64, 2))
    common = bounds(capture, rising(np.repeat(draws[:, :1], 2, axis=1)))
    sigma = draws[:, 0].std()
    np.testing.assert_allclose(
        common - bounds(capture), SIGNIFICANCE * sigma, rtol=0.1
    )
    each = bounds(capture, rising(draws))
    middle = draws.mean(axis=1).std()
    np.testing.assert_allclose(
        each - bounds(capture), SIGNIFICANCE * middle, rtol=0.2
    )


def test_what_is_expected_to_be_wrong_counts_once(capture):
    off = bounds(capture, rising(np.full((8, 2), -0.006)))
    np.testing.assert_allclose(off - bounds(capture), 0.006, atol=1e-6)


def test_views_that_disagree_are_both_believed(capture):
    apart = looking_down(capture.X_WC[:, :3, 3])
    apart.X_WC[1, 2, 3] += 0.008
    field = SphereToEllipsoidField(bounded(apart))
    p_W = np.random.default_rng(0).uniform(-0.2, 0.2, (200, 3))
    for z in (0.0, 0.008):
        p_W[:, 2] = z
        distance = field.clearances(Spheres.at(p_W)).per_sphere(len(p_W))
        assert distance.max() < 0


def test_two_noisy_looks_at_a_post_are_enough(capture):
    """Its pixels are 2 cm apart along the rays: no voxel contains both."""
    noise = 0.008 * np.random.default_rng(0).standard_normal((2, 80, 80))
    noisy = dc.replace(capture, depth=(capture.depth + noise).astype("f4"))
    post_W, wrong = np.array([0.0, 0, 0.3]), (0.01, -0.01)
    for view, p_WC in enumerate(noisy.X_WC[:, :3, 3]):
        column = int(40 + FOCAL * (post_W - p_WC)[0] / 0.7)
        noisy.depth[view, 39:41, column - 1 : column + 2] = 0.7 + wrong[view]
    splat_W = bounded(noisy)
    own = np.linalg.norm(splat_W.p_GK - post_W, axis=1).argmin()
    assert splat_W.uncertainty is not None
    # The mean of six pixels is known to 8 mm / sqrt(6).
    assert splat_W.uncertainty[own] > SIGNIFICANCE * 0.003
    field = SphereToEllipsoidField(splat_W)
    distance = field.clearances(Spheres.at(post_W[None])).per_sphere(1)
    assert distance[0] < 0
