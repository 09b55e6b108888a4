"""Training, on a textured plane that is seen by five cameras."""

import dataclasses as dc

import numpy as np
import pytest

torch = pytest.importorskip("torch")

from remosplat_drake.capture.capture import (  # noqa: E402
    Capture,
    back_project,
)
from remosplat_drake.reconstruction.surfels import (  # noqa: E402
    surfels_from_capture,
)

HAS_CUDA = torch.cuda.is_available()
NEEDS_CUDA = pytest.mark.skipif(not HAS_CUDA, reason="needs a CUDA device")


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


@pytest.mark.gpu
@NEEDS_CUDA
def test_discs_settle_on_the_plane_and_floaters_go(capture):
    pytest.importorskip("gsplat")
    from remosplat_drake.reconstruction.training import TrainingConfig, train

    surfels = surfels_from_capture(capture, count=2000, stride=1)
    rng = np.random.default_rng(0)
    lifted = surfels.p_WK + rng.normal(0, 0.003, surfels.p_WK.shape)
    central = np.flatnonzero(np.abs(lifted[:, :2]).max(axis=1) < 0.2)
    lifted[central[:50], 2] = 0.3
    start = dc.replace(surfels, p_WK=lifted)

    losses = []
    splat = train(
        capture,
        start,
        TrainingConfig(steps=1000),
        report=lambda step, loss: losses.append(loss),
    )

    assert losses[-1] < 0.5 * losses[0]
    assert len(splat) > 0.9 * len(start)
    z = splat.p_GK[:, 2]
    assert np.percentile(np.abs(z), 95) < 1.5e-3
    assert (np.abs(z) > 0.1).mean() < 0.005
    assert splat.opacities.min() >= 0.2


@pytest.mark.skipif(HAS_CUDA, reason="there is a CUDA device")
def test_without_cuda_it_says_so(capture):
    from remosplat_drake.errors import RemoSplatError
    from remosplat_drake.reconstruction.training import train

    with pytest.raises(RemoSplatError, match="CUDA"):
        train(capture, surfels_from_capture(capture, count=100))
