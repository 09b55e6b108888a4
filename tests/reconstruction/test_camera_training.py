"""Cameras as unknowns of the training: gradients, gauge, planted errors."""

import dataclasses as dc

import numpy as np
import pytest
from hypothesis import given as for_all
from hypothesis import settings
from hypothesis import strategies as st

torch = pytest.importorskip("torch", reason="needs torch, of the extra `gpu`")

from pydrake.math import RigidTransform

from apps.studies.map_bound.ray_casting import cast_capture
from remosplat_drake.base.errors import FileError
from remosplat_drake.base.resources import models_dir
from remosplat_drake.capture.capture import Capture
from remosplat_drake.capture.rendering.camera_poses import look_at
from remosplat_drake.capture.rendering.synthetic import survey_poses
from remosplat_drake.reconstruction.alignment.perturbation import (
    difference,
    perturbed,
)
from remosplat_drake.reconstruction.surfels.surfels import (
    splat_of_surfels,
    surfels_from_capture,
)
from remosplat_drake.reconstruction.training import losses
from remosplat_drake.reconstruction.training.cameras import (
    CameraDeviations,
    Cameras,
)
from remosplat_drake.reconstruction.training.discs import Discs
from remosplat_drake.reconstruction.training.rasterization import (
    _viewmats,
    rasterize,
)
from remosplat_drake.reconstruction.training.rasterization_reference import (
    rasterize_reference,
)
from remosplat_drake.reconstruction.training.training import (
    CAMERA_TRAINING,
    Progress,
    Trained,
    train,
)
from remosplat_drake.reconstruction.training.views import Views
from remosplat_drake.scene.primitive_scene import Box, PrimitiveScene
from remosplat_drake.scene.rmmi import read_scene
from remosplat_drake.splat.gaussian_splat import GaussianSplat

NEEDS_CUDA = pytest.mark.skipif(
    not torch.cuda.is_available(), reason="needs a CUDA device"
)
EVERY = ("poses", "lens", "depth")
MAP_KNOWN = dc.replace(
    CAMERA_TRAINING, center_rate=0.0, rotation_rate=0.0, batch=4
)
"""Discs stay where they are: only cameras and colours are unknowns."""


@pytest.fixture(scope="module", autouse=True)
def one_thread():
    """The tensors are small: threads would only wait for each other."""
    threads = torch.get_num_threads()
    torch.set_num_threads(1)
    yield
    torch.set_num_threads(threads)


def textured(capture: Capture) -> Capture:
    """The capture in waves of colours that are fixed in space."""
    waves = np.array([[15.0, 5, -8], [-6, 14, 7], [7, -9, 13]])
    rgb = np.zeros_like(capture.rgb)
    for view in range(len(capture)):
        seen = capture.depth[view] > 0
        p_W = capture.points_W(view)[seen]
        rgb[view][seen] = 127 + 90 * np.sin(p_W @ waves.T + [0, 1, 2])
    return dc.replace(capture, rgb=rgb)


@pytest.fixture(scope="module")
def true() -> Capture:
    """Eight small views of three walls that meet in the origin."""
    walls = np.array([[-0.1, 0.5, 0.5], [0.5, -0.1, 0.5], [0.5, 0.5, -0.1]])
    halves = np.where(walls < 0, 0.1, 0.6)
    scene = PrimitiveScene(
        boxes=tuple(
            Box(RigidTransform(p_WP), half)
            for p_WP, half in zip(walls, halves, strict=True)
        )
    )
    i = np.arange(8)
    p_WC = 0.75 + 0.3 * np.sin(np.stack([2.4 * i, 1.1 * i + 1, 1.7 * i], 1))
    poses = [look_at(p, np.array([0.15, 0.15, 0.15])) for p in p_WC]
    return textured(cast_capture(scene, poses, 28, 21, fov_y=1.0))


@pytest.fixture(scope="module")
def start(true) -> GaussianSplat:
    """Discs where the true cameras see surfaces."""
    return splat_of_surfels(surfels_from_capture(true, count=350, stride=1))


def disturbed(
    capture: Capture, meters: float, degrees: float, focal: float
) -> Capture:
    """Errors of each pose by so much, without a common one, and of the lens."""
    rng = np.random.default_rng(0)
    error = rng.standard_normal((len(capture), 2, 3))
    error /= np.linalg.norm(error, axis=2, keepdims=True)
    error *= np.array([[np.deg2rad(degrees)], [meters]])
    error -= error.mean(axis=0)
    K = capture.K.copy()
    K[:, [0, 1], [0, 1]] *= 1 + focal
    X_WC = perturbed(capture.X_WC, error.reshape(-1, 6))
    return dc.replace(capture, X_WC=X_WC, K=K)


def errors(found: Capture, true: Capture) -> tuple[float, float, float]:
    """Root mean squares of turns [rad] and shifts [m], and that of focal."""
    error = difference(found.X_WC, true.X_WC).reshape(-1, 2, 3)
    error -= error.mean(axis=0)
    turn, shift = np.sqrt((error**2).sum(axis=2).mean(axis=0))
    focal, expected = (K[:, [0, 1], [0, 1]] for K in (found.K, true.K))
    return turn, shift, np.abs(focal / expected - 1).max()


def train_small(given, start, config, **options) -> Trained:
    return train(
        given,
        start,
        config,
        device="cpu",
        rasterizer=rasterize_reference,
        **options,
    )


def cameras_of(capture: Capture, scale: float, seed: int = 0) -> Cameras:
    """Cameras with random errors of so many standard deviations."""
    count = len(capture)
    cameras = Cameras(capture.X_WC, CameraDeviations(), np.ones(count, bool))
    generator = torch.Generator().manual_seed(seed)
    with torch.no_grad():
        for values in cameras.parameters():
            values += scale * torch.randn(values.shape, generator=generator)
    return cameras


@settings(max_examples=10)
@for_all(seed=st.integers(0, 1000), scale=st.floats(0, 30))
def test_views_and_the_capture_get_the_same_cameras(true, seed, scale):
    """Even where errors are large: rotations are exact."""
    cameras = cameras_of(true, scale, seed)
    index = torch.tensor([5, 2])
    given = Views.of_capture(true, "cpu")[index]
    views = cameras.corrected(given, index)
    capture = cameras.capture(true).select(index.numpy())
    X_WC = torch.linalg.inv(views.X_CW.double()).detach().numpy()
    np.testing.assert_allclose(X_WC, capture.X_WC, atol=1e-5)
    np.testing.assert_allclose(views.K.detach(), capture.K, rtol=1e-5)
    np.testing.assert_allclose(views.depth.detach(), capture.depth, atol=1e-5)


def test_cameras_by_hand(true):
    """In units of standard deviations: 0.01 rad, 0.01 m, 2 %, 0.005 f."""
    cameras = cameras_of(true, 0)
    with torch.no_grad():
        cameras.poses[3, 2], cameras.poses[3, 4] = 1.0, -2.0
        cameras.lens[:] = torch.tensor([np.log(1.01) / 0.02, 0, 0, 2])
        cameras.depth[:] = torch.tensor([0.5, 1, 2])
    found = cameras.capture(true)
    np.testing.assert_allclose(
        difference(found.X_WC, true.X_WC)[3], [0, 0, 0.01, 0, -0.02, 0],
        atol=1e-8,
    )  # fmt: skip
    fx, fy = true.K[0, 0, 0], true.K[0, 1, 1]
    expected = [[1.01 * fx, 0, 14], [0, fy, 10.5 + 0.01 * fy], [0, 0, 1]]
    np.testing.assert_allclose(found.K[3], expected, rtol=1e-6)
    z = true.depth.astype(float)
    np.testing.assert_allclose(
        found.depth, np.where(z > 0, 0.003 + 1.01 * z + 0.01 * z**2, 0),
        rtol=1e-6,
    )  # fmt: skip
    prior = cameras.prior(torch.tensor([3, 4])).item()
    lens = (np.log(1.01) / 0.02) ** 2 + 4
    expected = 0.5 * ((1 + 4) / 2 + (lens + 5.25) / 8)
    assert prior == pytest.approx(expected)


@pytest.mark.parametrize("name", EVERY)
@pytest.mark.parametrize("loss", ["photometric", "depth", "surface"])
def test_gradients_are_as_finite_differences_say(true, start, name, loss):
    cameras = cameras_of(true, 0.2).double()
    discs = Discs(start, (0.5, 2.0)).double()
    index = torch.tensor([1])
    given = Views.of_capture(true, "cpu")[index]
    given = Views(
        *(
            x if x.dtype == torch.bool else x.double()
            for x in (getattr(given, f.name) for f in dc.fields(Views))
        )
    )

    def value():
        views = cameras.corrected(given, index)
        if loss == "surface":
            return losses.disc_losses(discs, views, 0.1)[0]
        rendered = rasterize_reference(discs, views)
        if loss == "depth":
            return losses.depth_loss(discs, views, rendered, 1.0)
        return losses.photometric_loss(rendered, views)

    parameter = getattr(cameras, name)
    value().backward()
    if name == "depth" and loss == "photometric":
        assert parameter.grad is None
        return
    assert parameter.grad is not None
    generator = torch.Generator().manual_seed(3)
    direction = torch.randn(parameter.shape, generator=generator).double()
    step = 1e-4
    ends = []
    for sign in (1, -1):
        with torch.no_grad():
            parameter += sign * step * direction
            ends.append(value().item())
            parameter -= sign * step * direction
    slope = (ends[0] - ends[1]) / (2 * step)
    found = (parameter.grad * direction).sum().item()
    assert found == pytest.approx(slope, rel=0.02, abs=1e-7)


def test_viewmats_carry_the_gradient_of_the_lens(true):
    """Gsplat uses K_0 viewmats, where K X_CW is meant."""
    cameras = cameras_of(true, 1.0)
    index = torch.tensor([0, 6])
    given = Views.of_capture(true, "cpu")[index]
    views = cameras.corrected(given, index)
    viewmats = _viewmats(views)
    assert torch.equal(viewmats, views.X_CW)
    weights = torch.randn(2, 3, 4, generator=torch.Generator().manual_seed(0))
    meant = views.K @ views.X_CW[:, :3]
    used = views.K.detach() @ viewmats[:, :3]
    parameters = cameras.poses, cameras.lens
    expected, found = (
        torch.autograd.grad(
            (weights * product).sum(), parameters, retain_graph=True
        )
        for product in (meant, used)
    )
    torch.testing.assert_close(found, expected, rtol=1e-4, atol=1e-4)


def test_what_all_views_do_together_is_taken_out(true):
    """A common turn, shift and scale go; what only one view does stays."""
    trained = np.arange(8) != 2
    cameras = Cameras(true.X_WC, CameraDeviations(), trained)
    p_WC = torch.tensor(true.X_WC[:, :3, 3], dtype=torch.float32)
    common = torch.cat([torch.full((8, 3), 0.7), 1.5 + 0.4 * p_WC], dim=1)
    with torch.no_grad():
        cameras.poses += common
    cameras.hold_frame()
    assert cameras.poses.abs().max() < 1e-5
    with torch.no_grad():
        cameras.poses += 0.1 * torch.randn(
            8, 6, generator=torch.Generator().manual_seed(0)
        )
    cameras.hold_frame()
    held = cameras.poses.clone()
    with torch.no_grad():
        cameras.poses += common
    cameras.hold_frame()
    torch.testing.assert_close(cameras.poses, held, rtol=0, atol=1e-5)
    assert held[trained].mean(dim=0).abs().max() < 1e-6
    assert held.abs().max() > 0.05


@pytest.mark.slow
def test_planted_errors_are_pulled_back_to_a_map(true, start):
    given = disturbed(true, 0.005, 0.3, 0.01)
    result = train_small(given, start, dc.replace(MAP_KNOWN, steps=100))
    before, after = errors(given, true), errors(result.capture, true)
    assert after[0] < 0.4 * before[0]
    assert after[1] < 0.4 * before[1]
    assert after[2] < 0.005
    # The frame stays: no common motion has crept in.
    mean = difference(result.capture.X_WC, given.X_WC).mean(axis=0)
    assert np.abs(mean).max() < 1e-6


def test_without_refinement_the_capture_is_the_given_one(true, start):
    config = dc.replace(MAP_KNOWN, steps=1, refine_cameras=False)
    result = train_small(true, start, config)
    assert result.capture is true
    assert not result.undone.any()


def test_cameras_wait_for_their_start(true, start):
    config = dc.replace(MAP_KNOWN, steps=3, camera_start=3)
    given = disturbed(true, 0.005, 0.3, 0.01)
    capture = train_small(given, start, config).capture
    np.testing.assert_array_equal(capture.X_WC, given.X_WC)
    np.testing.assert_array_equal(capture.K, given.K)


def test_held_out_images_move_their_own_cameras_only(true, start):
    config = dc.replace(CAMERA_TRAINING, steps=6, camera_start=0, batch=2)
    held_out = np.arange(8) == 4
    rgb = true.rgb.copy()
    rgb[4] = rgb[4][:, ::-1]
    one, other = (
        train_small(capture, start, config, held_out=held_out)
        for capture in (true, dc.replace(true, rgb=rgb))
    )
    np.testing.assert_array_equal(one.splat.p_GK, other.splat.p_GK)
    np.testing.assert_array_equal(one.splat.colors, other.splat.colors)
    np.testing.assert_array_equal(one.capture.K, other.capture.K)
    moved = np.abs(one.capture.X_WC - other.capture.X_WC).max(axis=(1, 2)) > 0
    assert moved.tolist() == held_out.tolist()


def test_a_training_with_cameras_goes_on_bit_for_bit(true, start, tmp_path):
    config = dc.replace(
        CAMERA_TRAINING, steps=12, check_every=10, camera_start=2, batch=2
    )
    options = {"held_out": np.arange(8) == 4}
    whole = train_small(true, start, config, **options)

    def interrupt(progress: Progress):
        raise KeyboardInterrupt

    path = tmp_path / "training.pt"
    with pytest.raises(KeyboardInterrupt):
        train_small(
            true, start, config, checkpoint=path, report=interrupt, **options
        )
    resumed = train_small(true, start, config, checkpoint=path, **options)
    np.testing.assert_array_equal(resumed.capture.X_WC, whole.capture.X_WC)
    np.testing.assert_array_equal(resumed.capture.K, whole.capture.K)
    np.testing.assert_array_equal(resumed.capture.depth, whole.capture.depth)
    np.testing.assert_array_equal(resumed.splat.p_GK, whole.splat.p_GK)
    fixed = dc.replace(config, refine_cameras=False)
    with pytest.raises(FileError, match=r"training\.pt.*other settings"):
        train_small(true, start, fixed, checkpoint=path, **options)


@pytest.mark.gpu
@NEEDS_CUDA
def test_gsplat_has_the_gradients_of_the_reference(true, start):
    """By poses and lens, although gsplat has none by its Ks."""
    pytest.importorskip("gsplat")
    cameras = cameras_of(true, 0.2).to("cuda")
    discs = Discs(start, (0.5, 2.0)).to("cuda")
    index = torch.tensor([1, 6])
    given = Views.of_capture(true, "cuda")[index]
    found = []
    for draw in (rasterize, rasterize_reference):
        views = cameras.corrected(given, index)
        loss = losses.photometric_loss(draw(discs, views), views)
        found.append(torch.autograd.grad(loss, (cameras.poses, cameras.lens)))
    for fast, slow in zip(*found, strict=True):
        assert slow.abs().max() > 0
        assert (fast - slow).abs().max() < 0.05 * slow.abs().max()


@pytest.fixture(scope="module")
def table() -> Capture:
    """Two dozen views of a shipped scene, exact and in colours."""
    scene = read_scene(models_dir() / "scenes" / "table" / "scene.json")
    poses = survey_poses(scene, 24)
    capture = cast_capture(scene.with_floor(), poses, 320, 240, fov_y=1.0)
    return textured(capture)


def depth_error(splat: GaussianSplat, true: Capture) -> float:
    """Median error of the depth that the true cameras would see [m]."""
    discs, found = Discs(splat, (0.5, 2.0)).to("cuda"), []
    for view in range(len(true)):
        one = Views.of_capture(true.select(np.array([view])), "cuda")
        with torch.no_grad():
            median = rasterize(discs, one).median
            z = losses.ray_splat_depth(discs, one, median)
        error = (z - one.depth)[one.depth > 0].abs()
        found.append(error[error.isfinite()])
    return torch.cat(found).median().item()


@pytest.mark.gpu
@NEEDS_CUDA
def test_the_lens_of_a_shipped_scene_is_found_by_gsplat(table):
    """Poses that are off are for the alignment, which comes before.

    Here discs start on a wrong map and are free: on an H100 the focal length
    went from 1.00 to 0.47 % and the map's depth from 2.79 to 1.78 mm, but
    turns from 0.19 to 0.37 degrees and shifts from 4.6 to 8.3 mm.
    """
    pytest.importorskip("gsplat")
    given = disturbed(table, 0.005, 0.2, 0.01)
    start = splat_of_surfels(surfels_from_capture(given, count=20_000))
    config = dc.replace(CAMERA_TRAINING, steps=300)
    refined = train(given, start, config)
    fixed = train(given, start, dc.replace(config, refine_cameras=False))
    before, after = errors(given, table), errors(refined.capture, table)
    depths = [depth_error(x.splat, table) for x in (fixed, refined)]
    numbers = (
        f"turn {np.rad2deg(before[0]):.3f} -> {np.rad2deg(after[0]):.3f} deg,"
        f" shift {1e3 * before[1]:.2f} -> {1e3 * after[1]:.2f} mm,"
        f" focal {100 * before[2]:.2f} -> {100 * after[2]:.2f} %,"
        f" depth {1e3 * depths[0]:.2f} -> {1e3 * depths[1]:.2f} mm"
    )
    print(numbers)
    assert after[2] < 0.6 * before[2], numbers
    assert depths[1] < 0.8 * depths[0], numbers
