"""Discs that views looked through go; those that they did not come back."""

import numpy as np
import pytest

from remosplat_drake.reconstruction.surfels.seen_through import (
    drop_floaters,
    fill_holes,
)
from remosplat_drake.reconstruction.surfels.surfels import (
    splat_of_surfels,
    surfels_from_capture,
)
from remosplat_drake.splat.gaussian_splat import GaussianSplat


@pytest.fixture
def discs(scene_capture) -> GaussianSplat:
    return splat_of_surfels(surfels_from_capture(scene_capture, 3000))


def at(discs: GaussianSplat, p_GK) -> GaussianSplat:
    """One of the discs, somewhere else."""
    one = discs.select(np.array([0]))
    return GaussianSplat(
        np.array([p_GK]), one.quaternions, one.scales, one.opacities, one.colors
    )


def test_nothing_lost_nothing_added(scene_capture, discs):
    assert len(fill_holes(scene_capture, discs, discs)) == len(discs)


def test_a_hole_in_a_surface_is_filled(scene_capture, discs):
    board = np.abs(discs.p_GK[:, 2] - 0.43) < 0.01
    middle = np.abs(discs.p_GK[:, :2] - [1, 0]).max(axis=1) < 0.15
    hole = board & middle
    assert hole.sum() > 3
    filled = fill_holes(scene_capture, discs.select(~hole), discs)
    back = filled.p_GK[len(discs) - hole.sum() :]
    assert 0.5 * hole.sum() < len(back) <= hole.sum()
    assert (np.abs(back[:, 2] - 0.43) < 0.01).all()


def test_what_views_looked_through_stays_away(scene_capture, discs):
    # In the air over the board, beside the cylinder.
    floater = at(discs, [1.0, -0.2, 0.7])
    filled = fill_holes(scene_capture, discs, discs.joined_with(floater))
    assert len(filled) == len(discs)


def test_floaters_go_and_surfaces_stay(scene_capture, discs):
    floater = at(discs, [1.0, -0.2, 0.7])
    kept = drop_floaters(scene_capture, discs.joined_with(floater))
    assert len(kept) == len(discs)
    # A disc a little before a surface may be the surface, seen with noise.
    board = np.abs(discs.p_GK[:, 2] - 0.43) < 0.01
    near = at(discs, discs.p_GK[board][0] + [0, 0, 0.02])
    kept = drop_floaters(scene_capture, discs.joined_with(near))
    assert len(kept) == len(discs) + 1
