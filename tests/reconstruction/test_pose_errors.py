"""Motions of discs by camera errors, by hand and by finite differences."""

import dataclasses as dc

import numpy as np
from plane_views import FOCAL, looking_down

from remosplat_drake.capture.capture import back_project
from remosplat_drake.reconstruction.alignment.camera_errors import (
    CENTER_X,
    COUNT,
    DELAY,
    GROWTH,
    K1,
    OFFSET,
    SCALE,
    SHIFT,
    TURN,
)
from remosplat_drake.reconstruction.alignment.perturbation import perturbed
from remosplat_drake.reconstruction.alignment.pose_errors import PoseErrors
from remosplat_drake.reconstruction.surfels.surfel_gathering import DepthNoise
from remosplat_drake.reconstruction.uncertainty.disc_errors import disc_errors
from remosplat_drake.splat.gaussian_splat import GaussianSplat

EXACT = DepthNoise(1e-4, 0.0, 0.1, 0.1)


def disc_at(p_WK) -> GaussianSplat:
    return GaussianSplat(
        p_GK=np.array([p_WK], float),
        quaternions=np.array([[1.0, 0, 0, 0]]),
        scales=np.full((1, 2), 0.01),
        opacities=np.ones(1),
        colors=np.full((1, 3), 0.5),
    )


def errors(theta_W, t_W, camera: dict[int, float] | None = None) -> PoseErrors:
    """One draw: rows of `theta_W` and `t_W` are the cameras'."""
    shared = np.zeros((1, COUNT))
    for error, size in (camera or {}).items():
        shared[0, error] = size
    return PoseErrors(
        np.array([theta_W], float), np.array([t_W], float), shared
    )


def test_each_error_of_one_camera_by_hand():
    capture = looking_down(np.array([[0.0, 0.0, 2.0]]))
    splat = disc_at([0.3, 0.0, 0.0])
    none = np.zeros((1, 3))
    for draw, expected in (
        (errors(none, [[0, 0, 0.01]]), 0.01),
        (errors(none, [[0.01, 0, 0]]), 0.0),
        # Turned about y, what is at x = 0.3 moves by -0.3 theta in z.
        (errors([[0, 0.01, 0]], none), -0.003),
        # Twice as deep is two metres below.
        (errors(none, none, {SCALE: 0.01}), -0.02),
        (errors(none, none, {OFFSET: 0.01}), -0.01),
        (errors(none, none, {GROWTH: 0.01}), -0.04),
        # What moves aside stays on its plane.
        (errors(none, none, {CENTER_X: 0.01, K1: 0.1}), 0.0),
        # The camera looks down: turned about its y, right of it comes nearer.
        (errors(none, none, {TURN + 1: 0.01}), 0.003),
        (errors(none, none, {SHIFT + 2: 0.01}), -0.01),
    ):
        moved, pitch, edge = disc_errors(capture, splat, EXACT, draw)
        np.testing.assert_allclose(moved, [[expected]], atol=1e-9)
        np.testing.assert_allclose(pitch, [2.0 / FOCAL])
        # Seen at 0.3 in 2, and by nothing else: one footprint.
        slant = np.sqrt(1 + 0.15**2)
        np.testing.assert_allclose(edge, [slant * 2.0 / FOCAL])


def test_views_are_averaged_by_their_weights_and_pitch_is_the_finest():
    capture = looking_down(np.array([[0, 0, 1.0], [0, 0, 2.0]]))
    noise = DepthNoise(0.0, 1e-3, 0.1, 0.1)
    draw = errors(np.zeros((2, 3)), [[0, 0, 0.017], [0, 0, 0.0]])
    moved, pitch, _ = disc_errors(capture, disc_at([0.0, 0, 0]), noise, draw)
    # Noise of z^2: the nearer view counts sixteen times as much.
    np.testing.assert_allclose(moved, [[0.016]], rtol=1e-6)
    np.testing.assert_allclose(pitch, [1.0 / FOCAL])


def test_what_no_view_sees_does_not_move():
    capture = looking_down(np.array([[0.0, 0.0, 2.0]]))
    draw = errors(np.zeros((1, 3)), [[0, 0, 0.01]])
    moved, pitch, edge = disc_errors(capture, disc_at([0, 0, 0.5]), EXACT, draw)
    assert moved[0, 0] == 0 and np.isinf(pitch[0]) and np.isinf(edge[0])


def test_small_errors_move_measured_points_as_promised():
    """Finite differences: the pixel's point under the altered camera."""
    rng = np.random.default_rng(3)
    capture = looking_down(np.array([[0.1, -0.2, 1.5]]))
    velocity = rng.uniform(-1, 1, (1, 6))
    capture = dc.replace(capture, velocity_W=velocity)
    row, column = 30, 55
    p_W = capture.points_W(0)[row, column]
    for _ in range(5):
        theta, t = 1e-5 * rng.standard_normal((2, 1, 3))
        scale, offset, center, delay = 1e-5 * rng.standard_normal(4)
        X_WC = perturbed(capture.X_WC, np.concatenate([theta, t], axis=1))
        X_WC = perturbed(X_WC, delay * velocity)[0]
        K = capture.K[0].copy()
        K[0, 2] += center * FOCAL
        depth = (1 + scale) * capture.depth[0].astype(float) + offset
        altered = back_project(K, depth, X_WC)[row, column]
        camera = {SCALE: scale, OFFSET: offset, CENTER_X: center, DELAY: delay}
        moved, *_ = disc_errors(
            capture, disc_at(p_W), EXACT, errors(theta, t, camera)
        )
        np.testing.assert_allclose(moved[0, 0], altered[2] - p_W[2], atol=1e-8)


def test_draws_of_an_alignment_are_sorted():
    draws = np.arange(2.0 * (12 + COUNT)).reshape(2, -1)
    both = PoseErrors.of_draws(draws)
    np.testing.assert_array_equal(both.theta_W[0], [[0, 1, 2], [6, 7, 8]])
    np.testing.assert_array_equal(both.t_W[0], [[3, 4, 5], [9, 10, 11]])
    np.testing.assert_array_equal(both.camera[0], 12 + np.arange(COUNT))
    one = both.of_views(np.array([False, True]))
    np.testing.assert_array_equal(one.t_W, both.t_W[:, 1:])
    np.testing.assert_array_equal(one.camera, both.camera)


def test_in_another_frame_the_camera_errs_alike():
    draw = errors([[0.1, 0.2, 0.3]], [[1, 2, 3]], {SCALE: 0.01})
    R_FW = np.array([[0.0, -1, 0], [1, 0, 0], [0, 0, 1]])
    turned = draw.rotated(R_FW)
    np.testing.assert_allclose(turned.theta_W, [[[-0.2, 0.1, 0.3]]])
    np.testing.assert_allclose(turned.t_W, [[[-2, 1, 3]]])
    np.testing.assert_array_equal(turned.camera, draw.camera)


def test_draws_are_independent_columns():
    capture = looking_down(np.array([[0.0, 0.0, 2.0]]))
    two = PoseErrors(
        np.zeros((2, 1, 3)),
        np.array([[[0, 0, 0.01]], [[0, 0, -0.02]]]),
        np.zeros((2, COUNT)),
    )
    moved, *_ = disc_errors(capture, disc_at([0.0, 0, 0]), EXACT, two)
    np.testing.assert_allclose(moved, [[0.01, -0.02]], atol=1e-9)


def test_the_grids_of_many_views_leave_little_room_for_an_edge():
    """Twenty views from 1 m: ln(1000) / 20 of a pixel's footprint."""
    capture = looking_down(np.tile([0.0, 0, 1.0], (20, 1)))
    draw = errors(np.zeros((20, 3)), np.zeros((20, 3)))
    *_, edge = disc_errors(capture, disc_at([0.0, 0, 0]), EXACT, draw)
    np.testing.assert_allclose(edge, np.log(1000) / 20 / FOCAL, rtol=1e-6)
    # No grid of 20 comes nearer to a random edge in one of 1000 draws.
    rng = np.random.default_rng(0)
    nearest = rng.uniform(0, 1 / FOCAL, (100_000, 20)).min(axis=1)
    assert (nearest > edge).mean() < 1e-3
