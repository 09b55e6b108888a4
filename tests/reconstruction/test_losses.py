"""Losses, on one camera that looks straight down at the plane z = 0."""

import numpy as np
import pytest

torch = pytest.importorskip("torch")

from remosplat_drake.reconstruction.losses import (  # noqa: E402
    View,
    coverage_loss,
    geometric_losses,
    haze_loss,
    photometric_loss,
)

MARGIN = 0.02


@pytest.fixture
def view():
    """A camera 1 m above the plane, 40 x 40 pixels, its y axis towards -y."""
    X_CW = np.diag([1.0, -1, -1, 1])
    X_CW[2, 3] = 1.0
    return View(
        X_CW=torch.tensor(X_CW, dtype=torch.float32),
        K=torch.tensor([[40.0, 0, 20], [0, 40, 20], [0, 0, 1]]),
        rgb=torch.zeros(40, 40, 3),
        depth=torch.ones(40, 40),
        normal_W=torch.tensor([0.0, 0, 1]).expand(40, 40, 3),
    )


def _losses(view, centers, normal=(0.0, 0.0, 1.0)):
    n = len(centers)
    return [
        float(loss)
        for loss in geometric_losses(
            torch.tensor(centers),
            torch.tensor([normal] * n),
            torch.full((n,), 0.5),
            view,
            MARGIN,
        )
    ]


def test_discs_on_the_surface_cost_nothing(view):
    losses = _losses(view, [[0.0, 0, 0], [0.3, -0.2, 0]])
    assert losses == pytest.approx([0, 0, 0], abs=1e-6)


def test_height_over_the_surface_is_in_metres(view):
    surface, _, _ = _losses(view, [[0.0, 0, 0.01], [0.2, 0.1, -0.005]])
    assert surface == pytest.approx((0.01 + 0.005) / 2, abs=1e-6)


def test_tilt_counts_whichever_side_is_up(view):
    half = np.sqrt(0.5)
    for sign in (1, -1):
        _, normal, _ = _losses(
            view, [[0.0, 0, 0]], (sign * half, 0.0, sign * half)
        )
        assert normal == pytest.approx(1 - half, abs=1e-6)


def test_floaters_cost_their_opacity(view):
    assert _losses(view, [[0.0, 0, 0.3]]) == pytest.approx([0, 0, 0.5])


def test_what_is_hidden_or_out_of_view_costs_nothing(view):
    hidden = [[0.0, 0, -0.3], [5.0, 0, 0.1], [0.0, 0, 3.0]]
    assert _losses(view, hidden) == pytest.approx([0, 0, 0])


def test_pixels_without_depth_say_nothing(view):
    view.depth.zero_()
    assert _losses(view, [[0.0, 0, 0.3], [0.0, 0, 0]]) == [0, 0, 0]


def test_photometric_loss_is_zero_for_equal_images_only():
    image = torch.rand(32, 32, 3, generator=torch.Generator().manual_seed(0))
    assert float(photometric_loss(image, image)) == pytest.approx(0, abs=1e-6)
    assert float(photometric_loss(image, image * 0.5)) > 0.1


def test_coverage_and_haze_by_hand():
    alpha = torch.tensor([[1.0, 0.5, 0.0]])
    depth = torch.tensor([[1.0, 1.0, 0.0]])
    assert float(coverage_loss(alpha, depth)) == pytest.approx(0.25)
    opacity = torch.tensor([0.0, 0.5, 1.0])
    assert float(haze_loss(opacity)) == pytest.approx(0.25 / 3)
