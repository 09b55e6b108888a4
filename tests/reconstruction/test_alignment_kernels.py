"""Planes of depth images, residuals of pairs, and their derivatives."""

import dataclasses as dc

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from plane_views import FOCAL, SIZE, looking_down

from remosplat_drake.reconstruction.alignment.camera_errors import (
    COUNT,
    DELAY,
    NO_ERRORS,
    READOUT,
    SCALE,
    CameraPrior,
)
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
from remosplat_drake.reconstruction.alignment.view_stack import (
    ViewStack,
    stack_views,
)

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
def stack(scene_capture) -> ViewStack:
    """Views whose cameras move, each in its own way."""
    rng = np.random.default_rng(0)
    velocity = rng.uniform(-0.5, 0.5, (len(scene_capture), 6))
    moving = dc.replace(scene_capture, velocity_W=velocity)
    return stack_views(moving, samples=60)


def poses(capture, seed, size=0.01):
    error = size * np.random.default_rng(seed).standard_normal(
        (len(capture), 6)
    )
    return perturbed(capture.X_WC, error)


def some_errors(seed, known=True) -> np.ndarray:
    """Errors of every kind, or none of a camera that is taken as exact."""
    if not known:
        return NO_ERRORS
    rng = np.random.default_rng(seed)
    return rng.normal(0, 0.3 * CameraPrior().deviations())


def compared(stack, X, errors, a, b, i, out, arms) -> bool:
    """What the kernel says of point i of view a in view b."""
    pose = np.ascontiguousarray(X[:, :3])
    return associate(stack, pose, errors, a, b, i, GATE, 0.7, out, arms)


@given(seed=st.integers(0, 1000), known=st.booleans())
@settings(max_examples=10)
def test_residuals_equal_the_reference(scene_capture, stack, seed, known):
    X, errors = poses(scene_capture, seed), some_errors(seed, known)
    a, b = np.random.default_rng(seed).choice(len(X), 2, replace=False)
    out, arms = np.empty(VALUES), np.empty((2, len(errors), 3))
    for i in range(stack.count[a]):
        expected = compare(stack, X[a], X[b], errors, (a, b), i, GATE, 0.7)
        hit = compared(stack, X, errors, a, b, i, out, arms)
        assert hit == (expected is not None)
        if expected is None:
            continue
        e = residual(expected, X[a], X[b], errors)
        assert out[0] == pytest.approx(e, abs=1e-9)
        sigma = deviation(stack, expected, X[a], X[b], errors, (a, b))
        assert out[1] == pytest.approx(sigma, rel=1e-6)


def derivatives(X, errors, out, arms, a, b) -> np.ndarray:
    """Those of a residual by both poses and the shared errors, (12 + 17,)."""
    normal, arm = out[2:5], out[5:8]
    by_errors = arms[0] @ normal
    by_errors[SCALE] -= out[0]
    pair = np.concatenate([np.cross(arm, normal), normal, by_errors])
    T = pair_expansion(X, np.array([[a, b]]), COUNT)[0]
    return T @ pair / (1 + errors[SCALE])


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_derivatives_equal_differences(scene_capture, stack, seed):
    """Of small errors only the first order is meant: they are 0 here."""
    X, errors = poses(scene_capture, seed), np.zeros(COUNT)
    errors[SCALE] = 0.02
    out, arms = np.empty(VALUES), np.empty((2, COUNT, 3))
    step, found = 1e-6, 0
    for a in range(len(X)):
        b = (a + 1 + seed) % len(X)
        for i in range(0, stack.count[a], 7):
            at = compare(stack, X[a], X[b], errors, (a, b), i, GATE, 0.7)
            if at is None:
                continue
            found += 1
            compared(stack, X, errors, a, b, i, out, arms)
            numeric = []
            for unknown in step * np.eye(12 + COUNT):
                ends = []
                for change in (unknown, -unknown):
                    Y = perturbed(X[[a, b]], change[:12].reshape(2, 6))
                    ends.append(residual(at, Y[0], Y[1], errors + change[12:]))
                numeric.append((ends[0] - ends[1]) / (2 * step))
            J = derivatives(X, errors, out, arms, a, b)
            np.testing.assert_allclose(J, numeric, atol=1e-6)
    assert found > 10


def test_rows_are_those_of_the_image_and_not_of_the_lattice():
    """Of 201 rows, a lattice of every other pixel has 101."""
    small = looking_down(np.array([[0, 0, 1.0], [0, 0, 1.0]]))
    depth = np.ones((2, 201, 320), np.float32)
    velocity_W = np.array([[0, 0, 0, 0.3, 0, 0], np.zeros(6)])
    capture = dc.replace(
        small,
        rgb=np.zeros((*depth.shape, 3), np.uint8),
        depth=depth,
        velocity_W=velocity_W,
    )
    stack = stack_views(capture, samples=20)
    assert (stack.step, stack.plane.shape[1]) == (2, 101)
    out, arms = np.empty(VALUES), np.empty((2, COUNT, 3))
    for i in range(stack.count[0]):
        assert compared(
            stack, capture.X_WC, np.zeros(COUNT), 0, 1, i, out, arms
        )
        _, y, z = stack.point[0, i]
        row = FOCAL * y / z + SIZE / 2
        late = arms[0, READOUT, 0] / arms[0, DELAY, 0]
        assert late == pytest.approx(row / 201 - 0.5, abs=1e-6)


def sums_of_pairs(stack, X, errors, pairs, spread, width):
    """What `pair_equations` writes: H, g, tilts and count."""
    size = 6 + len(errors)
    H, tilts = np.empty((2, len(pairs), size, size))
    g, count = np.empty((len(pairs), size)), np.empty(len(pairs))
    pair_equations(
        stack, np.ascontiguousarray(X[:, :3]), errors, pairs, GATE, 0.7,
        spread, width, H, g, tilts, count,
    )  # fmt: skip
    return H, g, tilts, count


PAIRS = np.array([[0, 1], [1, 2], [0, 3]])


@pytest.mark.parametrize("known", [True, False])
def test_equations_are_sums_of_both_directions(scene_capture, stack, known):
    X, errors = poses(scene_capture, 0), some_errors(0, known)
    shared = len(errors)
    scale = 1 + errors[SCALE] if known else 1.0
    H, g, _, count = sums_of_pairs(stack, X, errors, PAIRS, 2.0, 0.01)
    matrix, gradient = assemble(H, g, X, PAIRS)
    expected = np.zeros_like(matrix), np.zeros_like(gradient)
    out, arms, n = np.empty(VALUES), np.empty((2, shared, 3)), 0
    for a, b in [*PAIRS, *PAIRS[:, ::-1]]:
        T = pair_expansion(X, np.array([[a, b]]), shared)[0]
        rows = np.arange(6)
        own = 6 * len(X) + np.arange(shared)
        rows = np.concatenate([6 * a + rows, 6 * b + rows, own])
        for i in range(stack.count[a]):
            if not compared(stack, X, errors, a, b, i, out, arms):
                continue
            n += 1
            normal, by_errors = out[2:5], arms[0] @ out[2:5]
            by_errors[:1] -= out[0]
            pair = [np.cross(out[5:8], normal), normal, by_errors]
            J = np.zeros(len(gradient))
            J[rows] = T @ np.concatenate(pair) / scale
            sigma = max(2 * out[1], 0.01 / 3)
            w = (1 + (out[0] / (3 * sigma)) ** 2) ** -2 / sigma**2
            expected[0][:] += w * np.outer(J, J)
            expected[1][:] += w * out[0] * J
    assert n == count.sum() > 50
    largest = np.abs(expected[0]).max()
    np.testing.assert_allclose(matrix, expected[0], atol=1e-9 * largest)
    largest = np.abs(expected[1]).max()
    np.testing.assert_allclose(gradient, expected[1], atol=1e-9 * largest)


@pytest.mark.parametrize("usual", [0.0, 0.1])
@pytest.mark.parametrize("known", [True, False])
def test_tilts_are_what_trembling_normals_add(
    scene_capture, stack, known, usual
):
    """Every fourth point speaks for four, of both tangents of its normal."""
    X, errors = poses(scene_capture, 0), some_errors(0, known)
    stack = stack._replace(tilt=np.full(len(X), usual))
    scale = 1 + errors[SCALE] if known else 1.0
    _, _, tilts, _ = sums_of_pairs(stack, X, errors, PAIRS[:1], 2.0, 0.01)
    expected = np.zeros_like(tilts[0])
    out, arms = np.empty(VALUES), np.empty((2, len(errors), 3))
    for a, b, sign in ((0, 1, 1), (1, 0, -1)):
        for i in range(0, stack.count[a], 4):
            if not compared(stack, X, errors, a, b, i, out, arms):
                continue
            sigma = max(2 * out[1], 0.01 / 3)
            w = (1 + (out[0] / (3 * sigma)) ** 2) ** -2 / sigma**2
            w *= max(usual**2, out[8])
            arm = out[5:8] + X[a, :3, 3] - X[0, :3, 3]
            for tangent in np.linalg.svd(out[None, 2:5])[2][1:]:
                # The residual itself changes by far less than its derivatives.
                pose = sign * np.append(np.cross(arm, tangent), tangent)
                J = np.append(pose, arms[0] @ tangent) / scale
                expected += 4 * w * np.outer(J, J)
    largest = np.abs(expected).max()
    assert largest > 0
    np.testing.assert_allclose(tilts[0], expected, atol=1e-6 * largest)


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


@pytest.mark.parametrize("others", [0.0, 1.0])
def test_no_scale_of_a_world_fits_better_than_another(
    scene_capture, stack, others
):
    """Positions and errors that grow in common are a gauge: J gamma = 0."""
    X, errors = poses(scene_capture, 3), others * some_errors(3)
    errors[SCALE] = 0.02
    H, g, _, _ = sums_of_pairs(stack, X, errors, PAIRS, 1.0, 0.01)
    matrix, gradient = assemble(H, g, X, PAIRS)
    gauge = np.zeros((len(X), 6))
    gauge[:, 3:] = X[:, :3, 3]
    # Depth 1.02 z grows with the world, and so does what is added to it.
    growing = errors.copy()
    growing[SCALE] += 1
    gauge = np.append(gauge, growing)
    assert abs(gradient @ gauge) < 1e-9 * np.abs(gradient).max()
    assert np.abs(matrix @ gauge).max() < 1e-9 * np.abs(matrix).max()


def test_perturbations_are_undone(scene_capture):
    error = 0.1 * np.random.default_rng(0).standard_normal(
        (len(scene_capture), 6)
    )
    moved = perturbed(scene_capture.X_WC, error)
    back = difference(moved, scene_capture.X_WC)
    np.testing.assert_allclose(back, error, atol=1e-9)
