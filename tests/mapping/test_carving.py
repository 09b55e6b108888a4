"""Discs of things that have gone, down to their feet and last specks."""

import dataclasses as dc

import numpy as np
import pytest
from laden_table import TOP

from remosplat_drake.mapping.carving import find_gone, find_rest
from remosplat_drake.mapping.depth_specks import without_specks
from remosplat_drake.reconstruction.surfels.surfels import (
    splat_of_surfels,
    surfels_from_capture,
)
from remosplat_drake.splat.gaussian_splat import GaussianSplat


def discs(capture) -> GaussianSplat:
    return splat_of_surfels(surfels_from_capture(capture, 5000))


@pytest.fixture(scope="module")
def bare_discs(bare) -> GaussianSplat:
    return discs(bare)


@pytest.fixture(scope="module")
def laden_discs(laden) -> GaussianSplat:
    return discs(laden)


def above(splat: GaussianSplat, height: float) -> np.ndarray:
    """Discs on the thing: as far above the table's top."""
    return splat.p_GK[:, 2] > TOP + height


def test_views_carve_nothing_that_they_see(
    bare, bare_discs, laden, laden_discs
):
    assert not find_gone(bare_discs.p_GK, bare).any()
    assert not find_gone(laden_discs.p_GK, laden).any()


def test_the_thing_is_carved_with_its_foot(bare, laden_discs):
    gone = find_gone(laden_discs.p_GK, bare)
    assert above(laden_discs, 0.05).sum() > 50
    assert gone[above(laden_discs, 0.05)].all()
    left = laden_discs.select(~gone)
    assert left.p_GK[:, 2].max() < TOP + 0.02
    assert gone.sum() < 1.1 * above(laden_discs, 0.01).sum()


def test_around_nothing_that_has_gone_nothing_goes(bare, laden_discs):
    nothing = np.zeros((0, 3))
    assert not find_rest(laden_discs.p_GK, nothing, bare).any()
    assert not find_gone(nothing, bare).any()


def test_specks_without_depth_hold_nothing_in_place(bare, laden_discs):
    """One pixel in a hundred is unknown, and spoils the nine around it."""
    rng = np.random.default_rng(0)
    holes = rng.random(bare.depth.shape) < 0.01
    spotted = dc.replace(bare, depth=bare.depth * ~holes)
    gone = find_gone(laden_discs.p_GK, without_specks(spotted))
    assert gone[above(laden_discs, 0.02)].all()


def test_specks_get_the_least_depth_around_them(bare):
    depth = bare.depth.copy()
    depth[0, 50, 60] = 0
    depth[0, 10:13, 20:23] = 0
    hidden = np.zeros(depth.shape, bool)
    hidden[0, 80:90, 80:90] = True
    dut = without_specks(dc.replace(bare, depth=depth, hidden=hidden))
    around = np.delete(depth[0, 49:52, 59:62], 4)
    assert dut.depth[0, 50, 60] == around.min()
    # Of a larger hole only the corners can be told.
    assert dut.depth[0, 11, 21] == 0
    assert (dut.depth[hidden] == 0).all()
    depth[hidden] = 0
    known = depth > 0
    np.testing.assert_array_equal(dut.depth[known], depth[known])
