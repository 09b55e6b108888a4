"""Alignment: what is off is found, what is right stays, doubt is honest."""

import dataclasses as dc

import numpy as np
import pytest
from scipy.ndimage import map_coordinates
from scipy.spatial.transform import Rotation

from remosplat_drake.base.errors import FieldError, FileError
from remosplat_drake.capture.capture import Capture
from remosplat_drake.capture.rendering.camera_poses import look_at
from remosplat_drake.capture.rendering.synthetic import render_capture
from remosplat_drake.capture.undistortion import Distortion, distort
from remosplat_drake.reconstruction.alignment import alignment
from remosplat_drake.reconstruction.alignment.camera_errors import (
    COUNT,
    DELAY,
    FOCAL,
    GROWTH,
    K1,
    SCALE,
    TURN,
    CameraPrior,
)
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
from remosplat_drake.reconstruction.alignment.refinement import AlignmentConfig
from remosplat_drake.reconstruction.alignment.residual_table import is_better
from remosplat_drake.reconstruction.alignment.solver import (
    Equations,
    Posterior,
    posterior,
)
from remosplat_drake.reconstruction.alignment.summary import (
    summarize_alignment,
)
from remosplat_drake.reconstruction.alignment.view_stack import stack_views
from remosplat_drake.scene.rmmi import read_scene

FEW = AlignmentConfig(samples=250)


ANGLES = np.linspace(0, 2 * np.pi, 16, endpoint=False)
"""Where the views of the orbit are on their circle [rad]."""


def align(capture, config=FEW):
    return alignment.align(capture, config)


@pytest.fixture(scope="module")
def aligned_orbit(orbit) -> alignment.Alignment:
    """What is found in a capture that is exact."""
    return align(orbit)


@pytest.fixture(scope="module")
def orbit() -> Capture:
    """Sixteen views around the shipped table's target, in order."""
    scene = read_scene("models/scenes/table/scene.json").with_floor()
    assert scene.X_WE_target is not None
    focus = scene.X_WE_target.translation()
    poses = [
        look_at(
            focus + np.array([1.3 * np.cos(a), 1.3 * np.sin(a), 0.5]),
            focus - [0, 0, 0.1],
        )
        for a in ANGLES
    ]
    return render_capture(scene, poses, 320, 240)


@pytest.fixture(scope="module")
def large(orbit) -> Capture:
    """The orbit with depths that are too long by two percent."""
    return orbit.with_depth(1.02, 0.0)


@pytest.fixture(scope="module")
def aligned_large(large) -> alignment.Alignment:
    return align(large)


def moved(capture: Capture, error: np.ndarray) -> Capture:
    return dc.replace(capture, X_WC=perturbed(capture.X_WC, error))


def apart(a: Capture, b: Capture) -> float:
    """Root mean square distance of two captures' cameras [m]."""
    return float(
        np.linalg.norm(a.X_WC[:, :3, 3] - b.X_WC[:, :3, 3], axis=1).mean()
    )


def test_an_exact_capture_stays_as_it_is(orbit, aligned_orbit):
    result = aligned_orbit
    sizes = np.abs(difference(result.capture.X_WC, orbit.X_WC))
    assert sizes[:, :3].max() < np.deg2rad(0.01)
    assert sizes[:, 3:].max() < 3e-4
    assert result.groups == 1
    assert not result.undone.any()
    np.testing.assert_array_equal(result.capture.K, orbit.K)
    assert result.deviations[SCALE] < 0.003


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


def test_a_scale_of_two_percent_is_found_by_metric_poses(orbit, aligned_large):
    result = aligned_large
    assert result.accepted
    assert result.scale * 1.02 == pytest.approx(1, abs=2e-3)
    assert apart(result.capture, orbit) < 1e-3


def test_a_scale_next_to_none_is_left_and_expected(orbit):
    """Curved surfaces pretend as much."""
    result = align(orbit.with_depth(1.002, 0.0), FEW)
    assert (result.scale, result.offset) == (1.0, 0.0)
    assert result.error[-COUNT + SCALE] == pytest.approx(-0.002, abs=5e-4)


def test_a_focal_length_three_percent_short_is_found(orbit):
    K = orbit.K.copy()
    K[:, [0, 1], [0, 1]] *= 0.97
    result = align(dc.replace(orbit, K=K))
    assert result.accepted
    focal = 0.97 * (1 + result.undone[FOCAL])
    assert focal == pytest.approx(1, abs=2e-3)
    np.testing.assert_allclose(
        result.capture.K[:, 0, 0], focal * orbit.K[:, 0, 0]
    )


def through_a_lens(capture: Capture, lens: Distortion) -> Capture:
    """What a camera with a lens that shows less has in its images."""
    height, width = capture.size
    K = capture.K[0]
    u, v = np.meshgrid(np.arange(width) + 0.5, np.arange(height) + 0.5)
    focal, center = K[[0, 1], [0, 1]], K[:2, 2]
    target = (np.stack([u, v], axis=-1) - center) / focal
    xy = target.copy()
    for _ in range(60):
        xy += target - distort(lens, xy)
    place = (xy * focal + center - 0.5)[..., ::-1].transpose(2, 0, 1)
    depth = np.zeros_like(capture.depth)
    for view, z in enumerate(capture.depth):
        inverse = 1 / np.where(z > 0, z, np.inf)
        smooth = map_coordinates(inverse, place, order=1, mode="nearest")
        nearest = map_coordinates(inverse, place, order=0, mode="nearest")
        surface = (nearest > 0) & (np.abs(smooth - nearest) < 0.02 * nearest)
        depth[view][surface] = 1 / smooth[surface]
    return dc.replace(capture, depth=depth)


@pytest.mark.slow
def test_the_distortion_of_a_lens_is_found(orbit):
    few = orbit.select(np.arange(8))
    result = align(through_a_lens(few, Distortion(k1=0.05)))
    assert result.accepted
    assert result.undone[K1] == pytest.approx(0.05, abs=0.005)


@pytest.mark.parametrize(
    "turn",
    [pytest.param([1, 0, 0], marks=pytest.mark.slow), [0.6, 0.6, 0.5]],
)
def test_a_camera_that_is_turned_on_its_carrier_is_found(orbit, turn):
    """A turn is a principal point that is off, but for the corners."""
    X_CD = np.eye(4)
    X_CD[:3, :3] = Rotation.from_rotvec(turn, degrees=True).as_matrix()
    told = dc.replace(orbit, X_WC=orbit.X_WC @ np.linalg.inv(X_CD))
    result = align(told)
    assert result.accepted
    found = np.rad2deg(result.undone[TURN : TURN + 3])
    np.testing.assert_allclose(found, turn, atol=0.2)
    # All that was found of it is in the poses.
    left = difference(result.capture.X_WC, orbit.X_WC)[:, :3]
    assert np.abs(left).max() < np.deg2rad(0.01)


def test_an_error_that_grows_with_the_square_of_depth_is_found(orbit):
    """What is told is z' with z' + 0.01 z'^2 = z."""
    z = orbit.depth.astype(float)
    wrong = (np.sqrt(1 + 0.04 * z) - 1) / 0.02
    result = align(dc.replace(orbit, depth=wrong.astype(np.float32)))
    assert result.accepted
    assert result.undone[GROWTH] == pytest.approx(0.01, abs=0.002)


def flown(orbit: Capture, delay: float) -> Capture:
    """The orbit, flown at a changing speed, with poses of a time before."""
    up = np.array([0, 0, 1.0])
    axis = orbit.X_WC[:, :3, 3].mean(axis=0)
    alpha = 0.5 * np.cos(2 * ANGLES)[:, None] * up
    omega_then = (0.6 + 0.4 * np.sin(3 * ANGLES))[:, None] * up
    omega = omega_then - delay * alpha
    back = -delay * omega_then + delay**2 / 2 * alpha
    turn = Rotation.from_rotvec(back).as_matrix()
    arm = (turn @ (orbit.X_WC[:, :3, 3] - axis)[..., None])[..., 0]
    X_WC = orbit.X_WC.copy()
    X_WC[:, :3, :3] = turn @ orbit.X_WC[:, :3, :3]
    X_WC[:, :3, 3] = axis + arm
    v = np.cross(omega, arm)
    a = np.cross(alpha, arm) + np.cross(omega, v)
    return dc.replace(
        orbit,
        X_WC=X_WC,
        velocity_W=np.concatenate([omega, v], axis=1),
        acceleration_W=np.concatenate([alpha, a], axis=1),
    )


def test_a_delay_is_found(orbit):
    result = align(flown(orbit, 0.08))
    assert result.accepted
    assert result.undone[DELAY] == pytest.approx(0.08, abs=0.01)
    assert apart(result.capture, orbit) < 0.001


def test_a_delay_that_is_taken_as_exact_stays_so(orbit):
    """The poses take it on where they may."""
    loose = OdometryNoise(0.01, 0, 0, 0, 0.02, 0, 0, 0)
    camera = CameraPrior(delay=0)
    config = dc.replace(FEW, camera=camera, odometry=loose)
    assert align(flown(orbit, 0.04), config).undone[DELAY] == 0


def test_a_large_drift_beside_no_noise_has_a_precision():
    """1e-6 rad beside 0.3 rad: rounding alone would make it indefinite."""
    noise = OdometryNoise(0, 0, 0.3, 0, 0, 0, 0, 1.0)
    precision = noise.precision(14)
    np.testing.assert_array_equal(precision, precision.T)
    assert np.linalg.eigvalsh(precision).min() > 0
    # What drifts steadily is as precise as its drift: tau^T P tau.
    tau = np.zeros((14, 6))
    tau[:, 0] = np.linspace(0, 1, 14)
    assert tau.ravel() @ precision @ tau.ravel() == pytest.approx(
        0.3**-2, rel=1e-3
    )


def test_points_without_a_surface_do_not_judge():
    """Of a hundred points, 60 and then 55 have one, which is 2 mm nearer."""
    before, after = np.full((2, 1, 100), np.nan)
    before[0, :60], after[0, :55] = 0.003, 0.001
    assert is_better(before, after)
    assert not is_better(after, before)
    after[0, 40:] = np.nan
    assert not is_better(before, after)


def test_a_measured_length_tells_the_scale_where_nothing_else_does(orbit):
    """Poses and depths of one too large world agree with each other."""
    orbit = orbit.select(np.arange(8))
    large = dc.replace(orbit.with_depth(1.03, 0.0), X_WC=orbit.X_WC.copy())
    large.X_WC[:, :3, 3] *= 1.03
    pixels = ((120, 160), (200, 170))
    p_C = Length((0, 0), pixels, 1.0).points_C(orbit)
    length = Length((0, 0), pixels, float(np.linalg.norm(p_C[1] - p_C[0])))
    loose = OdometryNoise(0.01, 0.01, 0.01, 0.01, 0.1, 0.1, 0.1, 0.1)
    camera = CameraPrior(scale=0.05, offset=0.001)
    config = AlignmentConfig(camera, loose, samples=250)
    assert align(large, config).deviations[SCALE] > 0.01
    told = align(large, dc.replace(config, lengths=(length,)))
    doubt = told.deviations[SCALE]
    assert told.scale * 1.03 == pytest.approx(1, abs=3 * doubt)
    assert doubt < 0.01


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


def test_on_a_blank_wall_a_slide_is_not_observable():
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
    deviation = np.sqrt(np.diag(result.covariance)[:-COUNT]).reshape(12, 6)
    assert result.accepted
    assert deviation[:, 4:].min() > 0.007
    assert deviation[:, 3].max() < 0.006
    off = difference(result.capture.X_WC, X_WC)
    sliding = np.abs(off - error)[:, 4:]
    assert sliding.max() < 0.004
    assert off[:, 3].std() < 0.2 * error[:, 3].std()


@pytest.mark.parametrize("seed", [0, pytest.param(1, marks=pytest.mark.slow)])
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
    deviation = np.sqrt(np.diag(result.covariance)[:-COUNT])
    ratio = (off - result.error[:-COUNT]) / deviation
    assert 0.1 < (ratio**2).mean() < 3


def test_draws_scatter_as_the_covariance_has_it(orbit, aligned_orbit):
    result = aligned_orbit
    draws = result.draws(200)
    assert draws.shape == (200, 6 * len(orbit) + COUNT)
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
    H = np.eye(6 * n + COUNT)
    free = np.eye(n) - 1 / n
    H[: 6 * n, : 6 * n] = 1e8 * np.kron(free, np.eye(6))
    h = H @ np.append(x, np.zeros(COUNT))
    starts = OdometryNoise(), OdometryNoise.of_motions(x.reshape(n, 6))
    found = estimate_noise(H, h, n, starts)
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
    H = np.diag([*np.full(60, 0.005**-2), *np.ones(COUNT)])
    h = np.zeros(len(H))
    found = estimate_noise(H, h, 10, [OdometryNoise()])
    assert found.white < 3e-4
    assert 0.0005 < plausible_noise(H, h, 10, found).white < 0.005


def test_a_scale_is_not_certain_by_hundredths_of_a_millimetre():
    """The data know all poses, but for a common scale, to 0.01 mm.

    They are wrong by 3 % of a hand's tremor of 1 mm, as if the scale were.
    """
    n, rng = 30, np.random.default_rng(0)
    tremor = np.zeros((n, 6))
    tremor[:, 3:] = 0.001 * rng.standard_normal((n, 3))
    path = tremor.ravel()
    sure = 1e-5**-2
    H = np.zeros((6 * n + 1, 6 * n + 1))
    H[:-1, :-1] = sure * np.eye(6 * n)
    H[:-1, -1] = H[-1, :-1] = -sure * path
    H[-1, -1] = sure * path @ path + 0.02**-2
    wrong = -0.03 * path
    h = sure * np.append(wrong, -path @ wrong)
    noise = estimate_noise(H, h, n, [OdometryNoise()])
    H[:-1, :-1] += noise.precision(n)
    scale = np.linalg.solve(H, h)[-1]
    assert abs(scale) < 4 * np.sqrt(np.linalg.inv(H)[-1, -1])


def test_the_best_of_several_starts_counts():
    """The likeliest noise is found beside a start that leads nowhere."""
    n, rng = 30, np.random.default_rng(1)
    x = rng.normal(0, 0.02, 6 * n)
    H = 1e6 * np.eye(6 * n)
    poor = OdometryNoise(*np.full(8, 1e-9))
    one = estimate_noise(H, H @ x, n, [poor], steps=1)
    both = estimate_noise(H, H @ x, n, [poor, OdometryNoise()], steps=1)
    costs = [
        _cost(H, H @ x, n, np.array(dc.astuple(noise)))[0]
        for noise in (one, both)
    ]
    assert costs[1] < costs[0] - 1


def test_noise_is_guessed_from_what_poses_moved_by():
    motion = np.tile([0.01, -0.01, 0.01, 0.03, 0.03, -0.03], (5, 1))
    guess = dc.astuple(OdometryNoise.of_motions(motion))
    np.testing.assert_allclose(guess, [0.01] * 4 + [0.03] * 4)


def test_the_gradient_of_the_evidence_equals_differences():
    rng = np.random.default_rng(0)
    root = rng.standard_normal((18 + COUNT, 18 + COUNT))
    H, h = 100 * root @ root.T, 10 * rng.standard_normal(18 + COUNT)
    deviations = np.array([0.3, 0.2, 0.1, 0.2, 0.2, 0.4, 0.3, 0.1])
    _, gradient = _cost(H, h, 3, deviations)
    for kind in range(8):
        ends = [
            _cost(H, h, 3, deviations * np.exp(sign * np.eye(8)[kind]))[0]
            for sign in (1e-5, -1e-5)
        ]
        numeric = (ends[0] - ends[1]) / 2e-5
        assert gradient[kind] == pytest.approx(numeric, rel=1e-5, abs=1e-7)


@pytest.mark.parametrize("seed", range(4))
def test_unknowns_are_conditioned_on_errors_that_are_zero(seed):
    """The reference solves the equations without these errors.

    Two errors have nearly the same effect, and some directions of the poses
    are 1e8 times as certain as others.
    """
    views, rng = 20, np.random.default_rng(seed)
    own = 6 * views
    J = 300 * rng.standard_normal((400, own + COUNT))
    J[:, own + 1] = J[:, own] + 3 * rng.standard_normal(400)
    truth = 0.01 * rng.standard_normal(own + COUNT)
    noise = OdometryNoise(1e-6, 0.003, 0.003, 0.005, 1e-4, 0.02, 0.01, 0.08)
    H, pairs = J.T @ J, np.zeros((1, 1))
    data = Equations(H, -H @ truth, pairs, pairs, pairs, pairs)
    known = np.zeros_like(H), np.zeros(len(H))
    known[0][own:, own:] = np.eye(COUNT) / 0.02**2
    found = posterior(data, np.zeros(len(H)), views, noise, known)
    none = rng.random(COUNT) < 0.5
    errors, spread = found.camera_without(none, np.zeros(COUNT))
    assert (errors[none] == 0).all() and (spread[none] == 0).all()
    free = np.append(np.ones(own, bool), ~none)
    whole = H + known[0]
    whole[:own, :own] += noise.precision(views)
    part = whole[np.ix_(free, free)]
    scale = 1 / np.sqrt(np.diag(part))
    scale = np.outer(scale, scale)
    inverse = scale * np.linalg.inv(scale * part)
    expected = inverse @ (H @ truth)[free]
    np.testing.assert_allclose(errors[~none], expected[own:], 1e-4, 1e-6)
    deviation = np.sqrt(np.diag(inverse)[own:])
    np.testing.assert_allclose(spread[~none], deviation, 1e-3)
    poses = found.poses_with(errors).ravel()
    np.testing.assert_allclose(poses, expected[:own], 1e-3, 1e-6)


def test_a_bias_is_not_explained_by_errors_that_are_hardly_known():
    """A focal error of 0.1 % is 100 deviations from zero, but only a bias.

    The scale is known to 2 % alone, and nearly certain with the focal length:
    their correlation is 0.99. Given an unbiased estimate of zero, it would
    have to move by 0.99 * 0.02 * 100.
    """
    C = np.zeros((COUNT, COUNT))
    C[SCALE, SCALE], C[FOCAL, FOCAL] = 0.02**2, 1e-5**2
    C[SCALE, FOCAL] = C[FOCAL, SCALE] = 0.99 * 0.02 * 1e-5
    mean, none = np.zeros(COUNT), np.zeros(COUNT, bool)
    mean[SCALE], mean[FOCAL] = -0.012, 1e-3
    none[FOCAL] = True
    noise, no_poses = OdometryNoise(), np.zeros((0, COUNT))
    found = Posterior(mean, C, noise, no_poses)
    far, _ = found.camera_without(none, np.zeros(COUNT))
    assert far[SCALE] == pytest.approx(-0.012 - 0.99 * 0.02 * 100)
    errors, spread = found.camera_without(none, np.full(COUNT, 1e-3))
    assert errors[SCALE] == pytest.approx(-0.012, abs=2.1e-4)
    assert errors[FOCAL] == 0
    assert spread[SCALE] == pytest.approx(0.02, rel=1e-3)


def test_errors_beyond_the_prior_are_implausible():
    """A depth sensor of 2 % may err by 10 %, and a known camera by nothing."""
    errors = np.zeros(COUNT)
    errors[SCALE] = 0.099
    assert alignment.is_plausible(errors, CameraPrior())
    errors[SCALE] = -0.205
    assert not alignment.is_plausible(errors, CameraPrior())
    errors[SCALE], errors[FOCAL] = 0, 0.01
    assert not alignment.is_plausible(errors, CameraPrior.exact(0.02))


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


def test_refined_cameras_are_kept_beside_the_splat(
    large, aligned_large, tmp_path
):
    splat, result = tmp_path / "table.ply", aligned_large
    write_cameras(splat, result.capture, [result.undone])
    again = with_cameras(large, splat)
    np.testing.assert_allclose(again.X_WC, result.capture.X_WC, atol=1e-11)
    np.testing.assert_allclose(again.depth, result.capture.depth, rtol=1e-6)
    with pytest.raises(FileError, match="16 cameras, but the capture has 8"):
        with_cameras(large.select(np.arange(8)), splat)
    cameras_path(splat).write_text('{"X_WC": 3}')
    with pytest.raises(FileError, match="must contain X_WC, and rows of 17"):
        with_cameras(large, splat)
    write_cameras(splat, None)
    assert with_cameras(large, splat) is large
