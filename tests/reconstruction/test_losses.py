"""Losses, on one camera that looks straight down at the plane z = 0."""

import dataclasses as dc

import numpy as np
import pytest

torch = pytest.importorskip("torch", reason="needs torch, of the extra `gpu`")

from remosplat_drake.reconstruction.training.discs import Discs
from remosplat_drake.reconstruction.training.losses import (
    coverage_loss,
    depth_loss,
    disc_losses,
    haze_loss,
    photometric_loss,
    ray_splat_depth,
)
from remosplat_drake.reconstruction.training.rasterization import (
    NO_DISC,
    Rendered,
)
from remosplat_drake.reconstruction.training.views import Views
from remosplat_drake.splat.gaussian_splat import GaussianSplat

MARGIN = 0.02


@pytest.fixture
def view() -> Views:
    """A camera 1 m above the plane, 40 x 40 pixels, its y axis towards -y."""
    X_CW = np.diag([1.0, -1, -1, 1])
    X_CW[2, 3] = 1.0
    return Views(
        X_CW=torch.tensor(X_CW, dtype=torch.float32)[None],
        K=torch.tensor([[[40.0, 0, 20], [0, 40, 20], [0, 0, 1]]]),
        rgb=torch.zeros(1, 40, 40, 3),
        depth=torch.ones(1, 40, 40),
        front=torch.ones(1, 40, 40),
        normal_C=torch.tensor([0.0, 0, -1]).expand(1, 40, 40, 3),
        shown=torch.ones(1, 40, 40, dtype=torch.bool),
    )


def discs_at(centers, tilt=0.0) -> Discs:
    """Half-opaque discs, tilted about their x axis."""
    n = len(centers)
    wxyz = [np.cos(tilt / 2), np.sin(tilt / 2), 0, 0]
    splat = GaussianSplat(
        p_GK=np.array(centers),
        quaternions=np.tile(wxyz, (n, 1)),
        scales=np.full((n, 2), 0.01),
        opacities=np.full(n, 0.5),
        colors=np.full((n, 3), 0.5),
    )
    return Discs(splat, (0.5, 2.0))


def rendered_with(median) -> Rendered:
    return Rendered(
        torch.zeros(1, 40, 40, 3), torch.ones(1, 40, 40), torch.tensor(median)
    )


def values(view, discs):
    return [loss.item() for loss in disc_losses(discs, view, MARGIN)]


def test_discs_on_the_surface_cost_nothing(view):
    losses = values(view, discs_at([[0.0, 0, 0], [0.3, -0.2, 0]]))
    assert losses == pytest.approx([0, 0, 0], abs=1e-6)


def test_height_over_the_surface_is_in_metres(view):
    surface, _, _ = values(view, discs_at([[0.0, 0, 0.01], [0.2, 0.1, -0.005]]))
    assert surface == pytest.approx((0.01 + 0.005) / 2, abs=1e-6)


@pytest.mark.parametrize("tilt", [np.pi / 4, -3 * np.pi / 4])
def test_tilt_counts_whichever_side_is_up(view, tilt):
    _, normal, _ = values(view, discs_at([[0.0, 0, 0]], tilt))
    assert normal == pytest.approx(1 - np.sqrt(0.5), abs=1e-6)


def test_floaters_cost_their_opacity(view):
    losses = values(view, discs_at([[0.0, 0, 0.3]]))
    assert losses == pytest.approx([0, 0, 0.5])


def test_what_is_hidden_or_out_of_view_costs_nothing(view):
    losses = values(
        view, discs_at([[0.0, 0, -0.3], [5.0, 0, 0.1], [0.0, 0, 3.0]])
    )
    assert losses == pytest.approx([0, 0, 0])


def test_pixels_without_depth_say_nothing(view):
    blind = dc.replace(
        view,
        depth=torch.zeros_like(view.depth),
        front=torch.full_like(view.front, torch.inf),
    )
    assert values(blind, discs_at([[0.0, 0, 0.3], [0.0, 0, 0]])) == [0, 0, 0]


def test_views_are_averaged(view):
    both = view[torch.tensor([0, 0])]
    discs = discs_at([[0.0, 0, 0.01], [0.0, 0, 0.3]], 0.1)
    assert values(both, discs) == pytest.approx(values(view, discs))


def test_ray_splat_depth_of_a_tilted_disc_by_hand(view):
    """Z = -y, seen from 1 m up: the ray (x, y, 1) meets it at z (1 - y) = 1."""
    median = np.full((1, 40, 40), 0)
    median[0, 0, 0] = NO_DISC
    discs = discs_at([[0.0, 0, 0]], tilt=-np.pi / 4)
    depth = ray_splat_depth(discs, view, torch.tensor(median)).detach()
    assert torch.isnan(depth[0, 0, 0])
    for row in (5, 19, 30):
        y = (row + 0.5 - 20) / 40
        expected = 1 / (1 + y)
        assert float(depth[0, row, 7]) == pytest.approx(expected, rel=1e-5)


def test_depth_loss_by_hand_and_its_limit(view):
    median = np.full((1, 40, 40), NO_DISC)
    median[0, 20, :4] = 0
    median[0, 21, :4] = 1
    discs = discs_at([[0.0, 0, 0.005], [0.0, 0, 0.5]])
    loss = depth_loss(discs, view, rendered_with(median), MARGIN)
    assert loss.item() == pytest.approx((0.005 + MARGIN) / 2, abs=1e-6)


def test_depth_loss_moves_centres_as_finite_differences_say(view):
    median = np.zeros((1, 40, 40), int)

    def loss(z: float, tilt: float):
        discs = discs_at([[0.1, 0.05, z]], tilt)
        return discs, depth_loss(discs, view, rendered_with(median), 1.0)

    discs, at = loss(0.1, 0.2)
    at.backward()
    assert discs.p_WK.grad is not None
    step = 1e-3
    ahead, behind = loss(0.1 + step, 0.2)[1], loss(0.1 - step, 0.2)[1]
    slope = (ahead - behind).item() / (2 * step)
    assert float(discs.p_WK.grad[0, 2]) == pytest.approx(slope, rel=0.02)


def test_photometric_loss_is_zero_for_equal_images_only(view):
    image = torch.rand(1, 40, 40, 3, generator=torch.Generator().manual_seed(0))
    same = dc.replace(view, rgb=image)
    rendered = Rendered(image, view.depth, view.depth.long())
    assert float(photometric_loss(rendered, same)) == pytest.approx(0, abs=1e-6)
    dark = dc.replace(view, rgb=image * 0.5)
    assert float(photometric_loss(rendered, dark)) > 0.1


def test_hidden_pixels_cost_nothing(view):
    image = torch.full((1, 40, 40, 3), 0.7)
    half = torch.zeros(1, 40, 40, dtype=torch.bool)
    half[:, :, :20] = True
    seen = torch.where(half[..., None], image, 0.0)
    masked = dc.replace(view, rgb=seen, shown=half)
    rendered = Rendered(image, view.depth, view.depth.long())
    assert float(photometric_loss(rendered, masked)) == pytest.approx(
        0, abs=1e-6
    )


def test_coverage_and_haze_by_hand(view):
    alpha = torch.tensor([[[1.0, 0.5, 0.0]]])
    depth = torch.tensor([[[1.0, 1.0, 0.0]]])
    rendered = Rendered(torch.zeros(1, 1, 3, 3), alpha, depth.long())
    small = dc.replace(view, depth=depth)
    assert coverage_loss(rendered, small).item() == pytest.approx(0.25)
    # A view without depth says nothing; a mean over nothing would be NaN.
    blind = dc.replace(view, depth=torch.zeros(1, 1, 3))
    assert float(coverage_loss(rendered, blind)) == 0
    discs = discs_at([[0.0, 0, 0]])
    assert haze_loss(discs).item() == pytest.approx(0.25)
