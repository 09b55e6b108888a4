"""Alignment: what is off is found, what is right stays, doubt is honest."""

import dataclasses as dc

import numpy as np
import pytest

from remosplat_drake.base.errors import FieldError, FileError
from remosplat_drake.capture.capture import Capture
from remosplat_drake.capture.rendering.camera_poses import look_at
from remosplat_drake.capture.rendering.synthetic import render_capture
from remosplat_drake.reconstruction.alignment import alignment
from remosplat_drake.reconstruction.alignment.alignment import AlignmentConfig
from remosplat_drake.reconstruction.alignment.cameras_file import (
    cameras_path,
    with_cameras,
    write_cameras,
)
from remosplat_drake.reconstruction.alignment.measured_length import Length
from remosplat_drake.reconstruction.alignment.odometry_prior import (
    OdometryNoise,
    _cost,
    estimate_noise,
    plausible_noise,
)
from remosplat_drake.reconstruction.alignment.one_view import align_view
from remosplat_drake.reconstruction.alignment.perturbation import (
    difference,
    perturbed,
)
from remosplat_drake.reconstruction.alignment.summary import (
    summarize_alignment,
)
from remosplat_drake.reconstruction.alignment.view_stack import stack_views
from remosplat_drake.scene.rmmi import read_scene

FEW = AlignmentConfig(samples=250)


def align(capture, config=FEW):
    return alignment.align(capture, config)


@pytest.fixture(scope="module")
def orbit() -> Capture:
    """Sixteen views around the shipped table's target, in order."""
    scene = read_scene("models/scenes/table/scene.json").with_floor()
    assert scene.X_WE_target is not None
    focus = scene.X_WE_target.translation()
    angles = np.linspace(0, 2 * np.pi, 16, endpoint=False)
    poses = [
        look_at(
            focus + np.array([1.3 * np.cos(a), 1.3 * np.sin(a), 0.5]),
            focus - [0, 0, 0.1],
        )
        for a in angles
    ]
    return render_capture(scene, poses, 320, 240)


def moved(capture: Capture, error: np.ndarray) -> Capture:
    return dc.replace(capture, X_WC=perturbed(capture.X_WC, error))


def apart(a: Capture, b: Capture) -> float:
    """Root mean square distance of two captures' cameras [m]."""
    return float(
        np.linalg.norm(a.X_WC[:, :3, 3] - b.X_WC[:, :3, 3], axis=1).mean()
    )


def test_an_exact_capture_stays_as_it_is(orbit):
    result = align(orbit)
    sizes = np.abs(difference(result.capture.X_WC, orbit.X_WC))
    assert sizes[:, :3].max() < np.deg2rad(0.01)
    assert sizes[:, 3:].max() < 3e-4
    assert result.groups == 1
    assert result.scale_std < 0.002


def test_drift_is_found_and_the_first_views_hold_the_world(orbit):
    error = np.zeros((len(orbit), 6))
    error[:, 3] = np.linspace(0, 0.05, len(orbit))
    result = align(moved(orbit, error))
    assert result.accepted
    assert apart(result.capture, orbit) < 0.003


def test_white_noise_of_poses_becomes_small(orbit):
    rng = np.random.default_rng(1)
    error = rng.standard_normal((len(orbit), 6)) * np.repeat(
        [np.deg2rad(0.15), 0.005], 3
    )
    noisy = moved(orbit, error)
    result = align(noisy)
    assert result.accepted
    assert apart(result.capture, orbit) < 0.6 * apart(noisy, orbit)
    assert result.noise.white == pytest.approx(0.005, rel=0.5)
    before = [row.median_before for row in result.rows]
    after = [row.median_after for row in result.rows]
    assert max(after) < 0.3 * max(before)


def test_a_scale_of_two_percent_is_found_by_metric_poses(orbit):
    result = align(orbit.with_depth(1.02, 0.0))
    assert result.accepted
    assert result.scale * 1.02 == pytest.approx(1, abs=2e-3)
    assert apart(result.capture, orbit) < 1e-3


def test_a_scale_next_to_none_is_left_and_expected(orbit):
    """Curved surfaces pretend as much."""
    result = align(orbit.with_depth(1.002, 0.0), FEW)
    assert (result.scale, result.offset) == (1.0, 0.0)
    assert result.error[-2] == pytest.approx(-0.002, abs=5e-4)


def test_a_measured_length_tells_the_scale_where_nothing_else_does(orbit):
    """Poses and depths of one too large world agree with each other."""
    large = dc.replace(orbit.with_depth(1.03, 0.0), X_WC=orbit.X_WC.copy())
    large.X_WC[:, :3, 3] *= 1.03
    pixels = ((120, 160), (200, 170))
    p_C = Length((0, 0), pixels, 1.0).points_C(orbit)
    length = Length((0, 0), pixels, float(np.linalg.norm(p_C[1] - p_C[0])))
    loose = OdometryNoise(0.01, 0.01, 0.01, 0.01, 0.1, 0.1, 0.1, 0.1)
    config = AlignmentConfig(0.05, 0.001, loose, samples=250)
    assert align(large, config).scale_std > 0.01
    told = align(large, dc.replace(config, lengths=(length,)))
    assert told.scale * 1.03 == pytest.approx(1, abs=3 * told.scale_std)
    assert told.scale_std < 0.01


@pytest.mark.parametrize(
    ("length", "says"),
    [
        (Length((0, 99), ((120, 160), (6, 6)), 1.0), "frame 99"),
        (Length((0, 0), ((120, 160), (999, 6)), 1.0), "pixel 999 6"),
    ],
)
def test_a_length_of_nothing_is_refused(orbit, length, says):
    with pytest.raises(FieldError, match=says):
        align(orbit, dc.replace(FEW, lengths=(length,)))


def test_views_that_share_nothing_stay_and_are_counted(orbit):
    """Every view in a world of its own."""
    far = orbit.X_WC.copy()
    far[:, 0, 3] += 100 * np.arange(len(orbit))
    result = align(dc.replace(orbit, X_WC=far))
    assert not result.accepted
    assert result.groups == len(orbit)
    np.testing.assert_array_equal(result.capture.X_WC, far)
    words = summarize_alignment(result, far).words
    assert f"{len(orbit)} groups of views share no surface" in words


def test_on_a_blank_wall_nobody_knows_who_slid():
    """Twelve cameras 1 m off the plane x = 0, that look straight at it."""
    K = np.array([[100.0, 0, 50], [0, 100, 40], [0, 0, 1]])
    X_WC = np.tile(np.eye(4), (12, 1, 1))
    X_WC[:, :3, :3] = [[0, 0, 1], [-1, 0, 0], [0, -1, 0]]
    X_WC[:, 0, 3] = -1
    X_WC[:, 1, 3] = np.linspace(0, 0.5, 12)
    rng = np.random.default_rng(0)
    depth = 1 + 0.002 * rng.standard_normal((12, 80, 100))
    wall = Capture(
        np.tile(K, (12, 1, 1)),
        X_WC,
        np.zeros((12, 80, 100, 3), np.uint8),
        depth.astype(np.float32),
    )
    error = np.zeros((12, 6))
    error[:, 3:] = 0.01 * rng.standard_normal((12, 3))
    noise = OdometryNoise(0.001, 0, 0, 0, 0.01, 0, 0, 0)
    result = align(moved(wall, error), dc.replace(FEW, odometry=noise))
    deviation = np.sqrt(np.diag(result.covariance)[:-2]).reshape(12, 6)
    assert result.accepted
    assert deviation[:, 4:].min() > 0.007
    assert deviation[:, 3].max() < 0.006
    off = difference(result.capture.X_WC, X_WC)
    sliding = np.abs(off - error)[:, 4:]
    assert sliding.max() < 0.004
    assert off[:, 3].std() < 0.2 * error[:, 3].std()


@pytest.mark.parametrize("seed", [0, 1])
def test_doubt_is_as_large_as_errors_are(orbit, seed):
    """Normalised errors over all cameras, whose mean square is 1."""
    rng = np.random.default_rng(seed)
    given = OdometryNoise(0.002, 0, 0, 0, 0.005, 0, 0, 0)
    error = rng.standard_normal((len(orbit), 6)) * np.repeat([0.002, 0.005], 3)
    noise = rng.standard_normal(orbit.depth.shape) * 0.002 * orbit.depth**2
    depth = np.where(orbit.depth > 0, orbit.depth + noise, 0)
    noisy = moved(dc.replace(orbit, depth=depth.astype(np.float32)), error)
    result = align(noisy, dc.replace(FEW, odometry=given))
    off = difference(orbit.X_WC, result.capture.X_WC).ravel()
    deviation = np.sqrt(np.diag(result.covariance)[:-2])
    ratio = (off - result.error[:-2]) / deviation
    assert 0.1 < (ratio**2).mean() < 3


def test_draws_scatter_as_the_covariance_has_it(orbit):
    result = align(orbit)
    draws = result.draws(200)
    assert draws.shape == (200, 6 * len(orbit) + 2)
    spread = draws.std(axis=0) / np.sqrt(np.diag(result.covariance))
    assert 0.8 < np.median(spread) < 1.2


@pytest.mark.parametrize(
    "truth",
    [
        OdometryNoise(0.003, 0, 0, 0, 0.01, 0, 0, 0),
        OdometryNoise(0, 0.02, 0, 0, 0, 0.05, 0, 0),
        OdometryNoise(0, 0, 0, 0.05, 0, 0, 0, 0.2),
    ],
)
def test_the_evidence_tells_noise_and_drifts_apart(truth):
    """Poses that the data know exactly, but for where the world is."""
    n = 60
    root = np.linalg.cholesky(truth.covariance(n))
    x = root @ np.random.default_rng(0).standard_normal(6 * n)
    H = np.zeros((6 * n + 2, 6 * n + 2))
    free = np.eye(n) - 1 / n
    H[:-2, :-2] = 1e8 * np.kron(free, np.eye(6))
    H[-2:, -2:] = np.eye(2)
    found = estimate_noise(H, H @ np.append(x, [0, 0]), OdometryNoise())
    kinds = ["white", "walk", "smooth"]
    largest = max(kinds, key=lambda name: getattr(truth, name))
    expected = getattr(truth, largest)
    # A smooth drift is a handful of numbers a coordinate, not one a view.
    tolerance = 0.5 if largest == "smooth" else 0.3
    assert getattr(found, largest) == pytest.approx(expected, rel=tolerance)
    for other in {"white", "walk"} - {largest}:
        assert getattr(found, other) < 0.3 * expected


def test_little_evidence_of_noise_is_no_evidence_of_none():
    """Ten poses, known to 5 mm by the data, that happen to be exact."""
    H = np.diag([*np.full(60, 0.005**-2), 1.0, 1.0])
    found = estimate_noise(H, np.zeros(62), OdometryNoise())
    assert found.white < 1e-4
    assert 0.0005 < plausible_noise(H, np.zeros(62), found).white < 0.005


def test_the_gradient_of_the_evidence_equals_differences():
    rng = np.random.default_rng(0)
    root = rng.standard_normal((20, 20))
    H, h = 100 * root @ root.T, 10 * rng.standard_normal(20)
    deviations = np.array([0.3, 0.2, 0.1, 0.2, 0.2, 0.4, 0.3, 0.1])
    _, gradient = _cost(H, h, deviations)
    for kind in range(8):
        ends = [
            _cost(H, h, deviations * np.exp(sign * np.eye(8)[kind]))[0]
            for sign in (1e-5, -1e-5)
        ]
        numeric = (ends[0] - ends[1]) / 2e-5
        assert gradient[kind] == pytest.approx(numeric, rel=1e-5, abs=1e-7)


def test_one_view_finds_its_place_among_others(orbit):
    stack = stack_views(orbit, samples=300)
    error = np.zeros((len(orbit), 6))
    error[5] = [0.01, -0.01, 0.01, 0.02, -0.02, 0.01]
    covariance = np.diag([2e-2] * 3 + [3e-2] * 3) ** 2
    others = np.array([2, 3, 4, 6, 7, 8])
    expected = perturbed(orbit.X_WC, error)
    found = align_view(stack, expected, 5, others, covariance)
    poses = expected.copy()
    poses[5] = found.X_WC
    left = difference(poses, orbit.X_WC)[5]
    assert np.abs(left[3:]).max() < 0.003
    assert np.abs(left[:3]).max() < 0.002
    assert (np.abs(left) < 5 * np.sqrt(np.diag(found.covariance))).all()
    assert found.count > 300


def test_refined_cameras_are_kept_beside_the_splat(orbit, tmp_path):
    splat = tmp_path / "table.ply"
    large = orbit.with_depth(1.02, 0.0)
    result = align(large)
    write_cameras(splat, result)
    again = with_cameras(large, splat)
    np.testing.assert_allclose(again.X_WC, result.capture.X_WC, atol=1e-11)
    np.testing.assert_allclose(again.depth, result.capture.depth, rtol=1e-6)
    with pytest.raises(FileError, match="16 cameras, but the capture has 8"):
        with_cameras(large.select(np.arange(8)), splat)
    cameras_path(splat).write_text('{"X_WC": 3}')
    with pytest.raises(FileError, match="must hold X_WC"):
        with_cameras(large, splat)
    write_cameras(splat, None)
    assert with_cameras(large, splat) is large
