"""Gaps between measured surfaces and discs: measured, closed, noise apart."""

import numpy as np

from remosplat_drake.reconstruction.uncertainty.gaps import (
    LARGEST_GAP,
    close_gaps,
    gaps,
)
from remosplat_drake.reconstruction.uncertainty.measured_voxels import (
    MeasuredVoxels,
)
from remosplat_drake.splat.gaussian_splat import GaussianSplat

DOWN = np.array([0.0, 0.0, -1.0])


def disc(radius: float) -> GaussianSplat:
    """One disc in the plane z = 0, around the origin."""
    return GaussianSplat(
        p_GK=np.zeros((1, 3)),
        quaternions=np.array([[1.0, 0, 0, 0]]),
        scales=np.full((1, 2), radius),
        opacities=np.ones(1),
        colors=np.full((1, 3), 0.5),
    )


def seen_from_above(p_W: np.ndarray, sigma: float) -> MeasuredVoxels:
    count = len(p_W)
    return MeasuredVoxels(
        p_W, np.tile(DOWN, (count, 1)), np.full(count, sigma), np.ones(count)
    )


def test_a_gap_is_the_distance_to_the_nearest_disc():
    points = np.array([[0.01, 0, 0], [0.05, 0, 0], [0, 0.02, 0.03]])
    measured = seen_from_above(points, sigma=0.0)
    distance, nearest = gaps(disc(0.02), measured)
    np.testing.assert_allclose(distance, [0, 0.03, 0.03], atol=1e-9)
    assert (nearest == 0).all()


def test_noise_along_the_ray_is_no_gap_and_across_it_is_one():
    points = np.array([[0, 0, 0.008], [0, 0, 0.015], [0.028, 0, 0.003]])
    distance, _ = gaps(disc(0.02), seen_from_above(points, sigma=0.0025))
    # Ten millimetres are four standard deviations.
    np.testing.assert_allclose(distance, [0, 0.005, 0.008], atol=5e-4)


def test_bare_points_get_discs_until_no_gap_is_left():
    rng = np.random.default_rng(0)
    plane = np.append(rng.uniform(-0.1, 0.1, (4000, 2)), np.zeros((4000, 1)), 1)
    measured = seen_from_above(plane, sigma=0.0)
    before, _ = gaps(disc(0.03), measured)
    assert before.max() > 0.05
    closed = close_gaps(disc(0.03), measured, np.ones(4000, bool))
    after, _ = gaps(closed, measured)
    assert after.max() < LARGEST_GAP
    # The new discs lie in the plane of the points.
    assert np.abs(closed.p_GK[:, 2]).max() < 1e-6
    assert np.abs(closed.R_GK[:, 2, 2]).min() > 0.999


def test_where_nothing_is_bare_the_splat_stays_as_it_is():
    splat = disc(0.03)
    measured = seen_from_above(np.array([[0.01, 0.01, 0.001]]), sigma=0.0)
    assert close_gaps(splat, measured, np.ones(1, bool)) is splat


def test_gaps_within_the_noise_get_no_discs():
    splat = disc(0.05)
    rng = np.random.default_rng(1)
    points = rng.uniform(-0.03, 0.03, (500, 3))
    points[:, 2] = np.clip(0.002 * rng.standard_normal(500), -0.007, 0.007)
    measured = seen_from_above(points, sigma=0.002)
    assert close_gaps(splat, measured, np.ones(500, bool)) is splat


def test_an_unconfirmed_point_gets_a_disc_if_its_gap_exceeds_its_noise():
    """Points 1 cm and 10 cm beside the disc; a standard deviation is 2 cm."""
    points = np.array([[0.06, 0, 0], [0, 0.15, 0]])
    measured = seen_from_above(points, sigma=0.02)
    closed = close_gaps(disc(0.05), measured, np.zeros(2, bool))
    np.testing.assert_allclose(closed.p_GK[1:], points[1:])
    # Confirmed points have smaller gaps.
    closed = close_gaps(disc(0.05), measured, np.ones(2, bool))
    assert len(closed) == 3
