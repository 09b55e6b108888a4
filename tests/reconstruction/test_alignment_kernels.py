"""Planes of depth images, residuals of pairs, and their derivatives."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from plane_views import looking_down

from remosplat_drake.reconstruction.alignment.pair_kernel import (
    VALUES,
    associate,
    pair_equations,
)
from remosplat_drake.reconstruction.alignment.pair_reference import (
    compare,
    deviation,
    residual,
)
from remosplat_drake.reconstruction.alignment.perturbation import (
    assemble,
    difference,
    pair_expansion,
    perturbed,
)
from remosplat_drake.reconstruction.alignment.plane_maps import plane_map
from remosplat_drake.reconstruction.alignment.solver import (
    Level,
    State,
    equations,
)
from remosplat_drake.reconstruction.alignment.view_stack import stack_views

K = np.array([[100.0, 0, 50], [0, 100, 40], [0, 0, 1]])
GATE = 0.1


def test_a_wall_straight_ahead_is_its_distance():
    planes = plane_map(K, np.full((80, 100), 2.0, np.float32))
    np.testing.assert_allclose(planes.plane[40, 50], [0, 0, -1, -2], atol=1e-6)
    assert planes.step == 1
    assert planes.deviation < 1e-7


def test_a_slope_by_hand():
    """The plane z = 2 + x / 2: n = (1, 0, -2) / sqrt 5, d = -4 / sqrt 5."""
    u = (np.arange(100) + 0.5 - 50) / 100
    depth = np.tile(2 / (1 - u / 2), (80, 1)).astype(np.float32)
    expected = np.array([1, 0, -2, -4]) / np.sqrt(5)
    planes = plane_map(K, depth)
    np.testing.assert_allclose(planes.plane[40, 50], expected, atol=1e-4)


def test_noise_in_inverse_depth_is_measured():
    noise = np.random.default_rng(0).normal(0, 0.002, (80, 100))
    planes = plane_map(K, (1 / (0.5 + noise)).astype(np.float32), radii=(2,))
    # 25 pixels average the noise of their mean.
    assert planes.deviation == pytest.approx(0.002 / 5, rel=0.1)


def test_there_is_no_plane_across_an_edge_nor_over_a_crease():
    depth = np.full((80, 100), 2.0, np.float32)
    depth[:, 50:] = 1.5
    assert not planes_of(depth)[40, 49:52].any()
    u = (np.arange(100) + 0.5 - 50) / 100
    crease = np.tile(2 / (1 - np.abs(u)), (80, 1)).astype(np.float32)
    assert not planes_of(crease)[40, 50].any()
    assert planes_of(crease)[40, 30].any()


def planes_of(depth):
    return plane_map(K, depth).plane


@pytest.fixture(scope="module")
def stack(scene_capture):
    return stack_views(scene_capture, samples=60)


def poses(capture, seed, size=0.01):
    error = size * np.random.default_rng(seed).standard_normal(
        (len(capture), 6)
    )
    return perturbed(capture.X_WC, error)


@given(seed=st.integers(0, 1000))
@settings(max_examples=10)
def test_residuals_equal_the_reference(scene_capture, stack, seed):
    X = poses(scene_capture, seed)
    pose = np.ascontiguousarray(X[:, :3])
    a, b = np.random.default_rng(seed).choice(len(X), 2, replace=False)
    out, found = np.empty(VALUES), 0
    for i in range(stack.count[a]):
        arguments = (1.01, 0.003, (a, b), i, GATE, 0.7)
        expected = compare(stack, X[a], X[b], *arguments)
        hit = associate(stack, pose, 1.01, 0.003, a, b, i, GATE, 0.7, out)
        assert hit == (expected is not None)
        if expected is None:
            continue
        found += 1
        e = residual(expected, X[a], X[b], 1.01, 0.003)
        assert out[0] == pytest.approx(e, abs=1e-9)
        sigma = deviation(stack, expected, X[a], X[b], 1.01, 0.003, (a, b))
        assert out[1] == pytest.approx(sigma, rel=1e-6)


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_derivatives_equal_differences(scene_capture, stack, seed):
    """Of a small offset only the first order is meant: it is 0 here."""
    X = poses(scene_capture, seed)
    pose = np.ascontiguousarray(X[:, :3])
    out, step, found = np.empty(VALUES), 1e-6, 0
    for a in range(len(X)):
        b = (a + 1 + seed) % len(X)
        T = pair_expansion(X, np.array([[a, b]]))[0]
        for i in range(0, stack.count[a], 7):
            at = compare(stack, X[a], X[b], 1.02, 0.0, (a, b), i, GATE, 0.7)
            if at is None:
                continue
            found += 1
            associate(stack, pose, 1.02, 0.0, a, b, i, GATE, 0.7, out)
            numeric = np.empty(14)
            for k in range(14):
                ends = []
                for sign in (step, -step):
                    error, camera = np.zeros((len(X), 6)), np.zeros(2)
                    if k < 12:
                        error[(a, b)[k // 6], k % 6] = sign
                    else:
                        camera[k - 12] = sign
                    Y = perturbed(X, error)
                    ends.append(
                        residual(at, Y[a], Y[b], 1.02 + camera[0], camera[1])
                    )
                numeric[k] = (ends[0] - ends[1]) / (2 * step)
            np.testing.assert_allclose(T @ out[2:10], numeric, atol=1e-6)
    assert found > 10


def test_equations_are_sums_of_both_directions(scene_capture, stack):
    X = poses(scene_capture, 0)
    pose = np.ascontiguousarray(X[:, :3])
    pairs = np.array([[0, 1], [1, 2], [0, 3]])
    H, tilts = np.empty((2, 3, 8, 8))
    g, count = np.empty((3, 8)), np.empty(3)
    stack = stack._replace(tilt=np.full(len(X), 0.1))
    pair_equations(
        stack, pose, 1.0, 0.0, pairs, GATE, 0.7, 2.0, 0.01, H, g, tilts, count
    )
    matrix, gradient = assemble(H, g, X, pairs)
    expected = np.zeros_like(matrix), np.zeros_like(gradient)
    tilt = np.zeros((6, 6))
    out, n = np.empty(VALUES), 0
    for a, b in [*pairs, *pairs[:, ::-1]]:
        T = pair_expansion(X, np.array([[a, b]]))[0]
        rows = [*range(6 * a, 6 * a + 6), *range(6 * b, 6 * b + 6), -2, -1]
        for i in range(stack.count[a]):
            if not associate(stack, pose, 1.0, 0.0, a, b, i, GATE, 0.7, out):
                continue
            n += 1
            J = np.zeros(len(gradient))
            J[rows] = T @ out[2:10]
            sigma = max(2 * out[1], 0.01 / 3)
            w = (1 + (out[0] / (3 * sigma)) ** 2) ** -2 / sigma**2
            expected[0][:] += w * np.outer(J, J)
            expected[1][:] += w * out[0] * J
            if {a, b} == {0, 1}:
                arm = out[10:13] + X[a, :3, 3] - X[0, :3, 3]
                for tangent in np.linalg.svd(out[None, 5:8])[2][1:]:
                    J = np.append(np.cross(arm, tangent), tangent)
                    tilt += 0.01 * w * np.outer(J, J)
    assert n == count.sum() > 50
    scale = np.abs(expected[0]).max()
    np.testing.assert_allclose(matrix, expected[0], atol=1e-9 * scale)
    scale = np.abs(expected[1]).max()
    np.testing.assert_allclose(gradient, expected[1], atol=1e-9 * scale)
    scale = np.abs(tilt).max()
    np.testing.assert_allclose(tilts[0, :6, :6], tilt, atol=1e-6 * scale)


def test_a_wrong_normal_does_not_hold_a_view_that_slides():
    """Two views of one plane, of which one has some normals 2 degrees off."""
    capture = looking_down(np.array([[0, 0, 1.0], [0.1, 0, 1.0]]))
    stack = stack_views(capture, samples=200)
    tilt = np.deg2rad(2)
    stack.plane[1, 30:33, 30:60, 0] = np.sin(tilt)
    stack.plane[1, 30:33, 30:60, 2] *= np.cos(tilt)
    level, pairs = Level(0.03, 0.0, 0.85, 1), np.array([[0, 1]])
    data = equations(stack, State(capture.X_WC), pairs, level, 1.0, 1.0)
    sliding, rising = data.H[3, 3], data.H[5, 5]
    assert data.count[0] > 100
    assert rising**-0.5 < 1e-4
    assert sliding < 1


def test_no_scale_of_a_world_fits_better_than_another(scene_capture, stack):
    """Positions, scale and offset in common are a gauge: J gamma = 0."""
    X = poses(scene_capture, 3)
    pose = np.ascontiguousarray(X[:, :3])
    pairs = np.array([[0, 1], [1, 2], [0, 3]])
    H, tilts = np.empty((2, 3, 8, 8))
    g, count = np.empty((3, 8)), np.empty(3)
    pair_equations(
        stack, pose, 1.02, 0.0, pairs, GATE, 0.7, 1.0, 0.01, H, g, tilts, count
    )
    matrix, gradient = assemble(H, g, X, pairs)
    gauge = np.zeros((len(X), 6))
    gauge[:, 3:] = X[:, :3, 3]
    gauge = np.append(gauge, [1.02, 0.0])
    assert abs(gradient @ gauge) < 1e-9 * np.abs(gradient).max()
    assert np.abs(matrix @ gauge).max() < 1e-9 * np.abs(matrix).max()


def test_perturbations_are_undone(scene_capture):
    error = 0.1 * np.random.default_rng(0).standard_normal(
        (len(scene_capture), 6)
    )
    moved = perturbed(scene_capture.X_WC, error)
    back = difference(moved, scene_capture.X_WC)
    np.testing.assert_allclose(back, error, atol=1e-9)
