"""Training, on a textured plane that is seen by five cameras."""

import dataclasses as dc

import numpy as np
import pytest

torch = pytest.importorskip("torch", reason="needs torch, of the extra `gpu`")

from remosplat_drake.base.errors import FileError, RemoSplatError
from remosplat_drake.capture.capture import Capture, back_project
from remosplat_drake.reconstruction.surfels.surfels import (
    splat_of_surfels,
    surfels_from_capture,
)
from remosplat_drake.reconstruction.training.discs import Discs
from remosplat_drake.reconstruction.training.rasterization import rasterize
from remosplat_drake.reconstruction.training.rasterization_reference import (
    rasterize_reference,
)
from remosplat_drake.reconstruction.training.training import (
    Progress,
    TrainingConfig,
    train,
    train_without_holes,
)
from remosplat_drake.reconstruction.training.views import Views
from remosplat_drake.splat.gaussian_splat import GaussianSplat

HAS_CUDA = torch.cuda.is_available()
NEEDS_CUDA = pytest.mark.skipif(not HAS_CUDA, reason="needs a CUDA device")


LOOSE = TrainingConfig(
    center_rate=1e-3, rotation_rate=1e-3, scale_limits=(0.2, 1.6)
)
"""Discs may go where they have to: they start in the wrong places."""


@pytest.fixture(scope="module", autouse=True)
def one_thread():
    """The tensors are small: threads would only wait for each other."""
    threads = torch.get_num_threads()
    torch.set_num_threads(1)
    yield
    torch.set_num_threads(threads)


@pytest.fixture(scope="module")
def capture() -> Capture:
    """Cameras 1 m above the plane z = 0, looking down, with a red ripple."""
    K = np.array([[120.0, 0, 60], [0, 120, 48], [0, 0, 1]])
    poses, colors = [], []
    depth = np.ones((96, 120), np.float32)
    for x, y in [(0, 0), (0.1, 0), (-0.1, 0), (0, 0.1), (0, -0.1)]:
        X_WC = np.diag([1.0, -1, -1, 1])
        X_WC[:3, 3] = [x, y, 1]
        p_W = back_project(K, depth, X_WC)
        rgb = np.full((96, 120, 3), 100.0)
        rgb[..., 0] += 80 * np.sin(15 * p_W[..., 0])
        poses.append(X_WC)
        colors.append(rgb.astype(np.uint8))
    return Capture(
        K=np.tile(K, (5, 1, 1)),
        X_WC=np.array(poses),
        rgb=np.array(colors),
        depth=np.repeat(depth[None], 5, axis=0),
    )


@pytest.fixture
def start(capture) -> GaussianSplat:
    """Discs a few millimetres off the plane, and fifty floaters above it."""
    surfels = surfels_from_capture(capture, count=250, stride=1)
    rng = np.random.default_rng(0)
    lifted = surfels.p_WK + rng.normal(0, 0.003, surfels.p_WK.shape)
    central = np.flatnonzero(np.abs(lifted[:, :2]).max(axis=1) < 0.2)
    lifted[central[:10], 2] = 0.3
    return splat_of_surfels(dc.replace(surfels, p_WK=lifted), opacity=0.7)


def check_trained(splat: GaussianSplat, start: GaussianSplat):
    assert len(splat) > 0.85 * len(start)
    z = splat.p_GK[:, 2]
    assert np.percentile(np.abs(z), 95) < 1.5e-3
    assert (np.abs(z) > 0.1).mean() < 0.005
    assert splat.opacities.min() >= 0.2


def small(capture: Capture) -> Capture:
    """Every fourth pixel: what the reference can draw in a moment."""
    K = capture.K.copy()
    K[:, :2] /= 4
    return Capture(
        K,
        capture.X_WC,
        capture.rgb[:, 2::4, 2::4],
        capture.depth[:, 2::4, 2::4],
    )


def train_by_reference(capture, start, config, **options):
    return train(
        small(capture),
        start,
        config,
        device="cpu",
        rasterizer=rasterize_reference,
        **options,
    )


def test_discs_settle_on_the_plane_and_floaters_go(capture, start):
    config = dc.replace(LOOSE, steps=100, opacity_rate=0.1)
    seen = []
    trained = train_by_reference(capture, start, config, report=seen.append)
    assert [p.step for p in seen] == list(range(10, 101, 10))
    assert seen[-1].loss < 0.5 * seen[0].loss
    check_trained(trained.splat, start)


def test_it_stops_when_the_held_out_view_has_nothing_to_gain(capture, start):
    config = TrainingConfig(
        steps=1000, check_every=5, patience=2, least_gain=0.5
    )
    held_out = np.array([False, False, True, False, False])
    trained = train_by_reference(capture, start, config, held_out=held_out)
    # The first look gains on nothing at all; the next two do not halve it.
    assert trained.progress.step == 15
    assert np.isfinite(trained.progress.held_out)


def test_an_interrupted_training_ends_as_if_it_had_not_been(
    capture, start, tmp_path
):
    config = TrainingConfig(steps=20, check_every=10)
    whole = train_by_reference(capture, start, config)

    def interrupt(progress: Progress):
        if progress.step == 10:
            raise KeyboardInterrupt

    path = tmp_path / "training.pt"
    with pytest.raises(KeyboardInterrupt):
        train_by_reference(
            capture, start, config, checkpoint=path, report=interrupt
        )
    steps = []
    resumed = train_by_reference(
        capture, start, config, checkpoint=path, report=steps.append
    )
    assert [p.step for p in steps] == [20]
    np.testing.assert_array_equal(resumed.splat.p_GK, whole.splat.p_GK)
    np.testing.assert_array_equal(resumed.splat.colors, whole.splat.colors)


def test_a_checkpoint_of_something_else_is_refused(capture, start, tmp_path):
    path = tmp_path / "training.pt"
    config = TrainingConfig(steps=10, check_every=10)
    train_by_reference(capture, start, config, checkpoint=path)
    other = TrainingConfig(steps=11, check_every=10)
    with pytest.raises(FileError, match=r"training\.pt.*another"):
        train_by_reference(capture, start, other, checkpoint=path)
    path.write_bytes(b"no checkpoint")
    with pytest.raises(FileError, match="not a training checkpoint"):
        train_by_reference(capture, start, config, checkpoint=path)


def test_what_fades_on_a_surface_is_put_back_and_a_floater_is_not(
    capture, start
):
    faint = start.p_GK[:, 0] > 0.1
    weak = np.where(faint, 0.1, start.opacities)
    weakened = dc.replace(start, opacities=weak)
    options = {"device": "cpu", "rasterizer": rasterize_reference}
    config = TrainingConfig(steps=1)
    lost = train(small(capture), weakened, config, **options).splat
    kept = train_without_holes(small(capture), weakened, config, **options)
    floats = start.p_GK[:, 2] > 0.1
    assert len(lost) == (~faint).sum()
    back = kept.splat.p_GK[len(lost) :]
    assert len(back) > 0.5 * (faint & ~floats).sum()
    assert (np.abs(back[:, 2]) < 0.1).all()


def test_a_ray_along_a_disc_leaves_gradients_finite():
    """The camera looks along x, its middle row of pixels never meets z = 1."""
    splat = GaussianSplat(
        p_GK=np.array([[1.0, 0, 1]]),
        quaternions=np.array([[1.0, 0, 0, 0]]),
        scales=np.full((1, 2), 0.1),
        opacities=np.array([0.8]),
        colors=np.ones((1, 3)),
    )
    X_WC = np.eye(4)
    X_WC[:3, :3] = [[0, 0, 1], [-1, 0, 0], [0, -1, 0]]
    camera = Capture(
        K=np.array([[[5.0, 0, 5.5], [0, 5, 5.5], [0, 0, 1]]]),
        X_WC=X_WC[None],
        rgb=np.zeros((1, 11, 11, 3), np.uint8),
        depth=np.ones((1, 11, 11), np.float32),
    )
    discs = Discs(splat, (0.5, 2.0))
    views = Views.of_capture(camera, "cpu")
    rasterize_reference(discs, views).image.sum().backward()
    for values in (discs.p_WK, discs.quaternions, discs.log_scales):
        assert values.grad is not None and values.grad.isfinite().all()


@pytest.mark.skipif(HAS_CUDA, reason="there is a CUDA device")
def test_without_cuda_it_says_so(capture, start):
    with pytest.raises(RemoSplatError, match="CUDA"):
        train(capture, start)


@pytest.mark.gpu
@NEEDS_CUDA
def test_gsplat_draws_what_the_reference_draws(capture, start):
    pytest.importorskip("gsplat")
    discs = Discs(start, (0.5, 2.0)).to("cuda")
    views = Views.of_capture(small(capture), "cuda")
    fast, slow = rasterize(discs, views), rasterize_reference(discs, views)
    assert float((fast.image - slow.image).abs().max()) < 2e-3
    assert float((fast.alpha - slow.alpha).abs().max()) < 2e-3
    assert float((fast.median == slow.median).float().mean()) > 0.995


@pytest.mark.gpu
@NEEDS_CUDA
def test_the_same_with_gsplat(capture, start):
    pytest.importorskip("gsplat")
    trained = train(
        capture, start, dc.replace(LOOSE, steps=600, center_rate=2e-4)
    )
    check_trained(trained.splat, start)
