"""A splat from before: what has gone goes, what has come is added."""

import numpy as np
import pytest
from laden_table import TOP

from remosplat_drake.mapping.base_splat import find_covered, updated
from remosplat_drake.reconstruction.surfels.surfels import (
    splat_of_surfels,
    surfels_from_capture,
)
from remosplat_drake.splat.gaussian_splat import GaussianSplat
from remosplat_drake.splat.surfel_conversion import with_thickness


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


def test_surfaces_of_the_base_are_not_doubled(bare_discs, laden_discs):
    assert find_covered(bare_discs, bare_discs.p_GK).all()
    covered = find_covered(bare_discs, laden_discs.p_GK)
    assert not covered[above(laden_discs, 0.02)].any()
    table = ~above(laden_discs, 0.005)
    assert covered[table].mean() > 0.8
    nothing = GaussianSplat.empty()
    assert not find_covered(nothing, laden_discs.p_GK).any()
    assert len(find_covered(bare_discs, nothing.p_GK)) == 0


def test_a_thing_that_comes_is_added_one_that_goes_taken_away(
    bare, bare_discs, laden, laden_discs
):
    with_thing = updated(bare_discs, laden_discs, laden)
    on_it = above(laden_discs, 0.02).sum()
    assert above(with_thing, 0.02).sum() == on_it
    assert len(with_thing) < 1.3 * (len(bare_discs) + on_it)
    without_thing = updated(with_thing, bare_discs, bare)
    assert above(without_thing, 0.05).sum() == 0


def test_discs_join_a_base_of_ellipsoids(bare_discs, laden_discs, laden):
    base = with_thickness(bare_discs)
    assert not updated(base, laden_discs, laden).is_surfel


def test_live_discs_and_those_of_the_base_keep_their_own_bounds(
    bare_discs, laden_discs, laden
):
    bounds = np.linspace(0.001, 0.02, len(bare_discs))
    live = laden_discs.with_uncertainty(0.005)
    with_thing = updated(bare_discs.with_uncertainty(bounds), live, laden)
    on_it = above(with_thing, 0.02)
    assert on_it.any()
    np.testing.assert_allclose(with_thing.uncertainty[on_it], 0.005)
    assert with_thing.uncertainty.min() < 0.002
    assert with_thing.uncertainty.max() > 0.019


def test_from_a_base_that_knows_no_bounds_nothing_is_subtracted(
    bare_discs, laden_discs, laden
):
    with_thing = updated(bare_discs, laden_discs.with_uncertainty(0.005), laden)
    on_it = above(with_thing, 0.02)
    np.testing.assert_allclose(with_thing.uncertainty[on_it], 0.005)
    assert with_thing.uncertainty.min() == 0


def test_an_uncertain_disc_covers_no_more_than_a_certain_one(
    bare_discs, laden_discs
):
    vague = find_covered(bare_discs.with_uncertainty(0.5), laden_discs.p_GK)
    np.testing.assert_array_equal(
        vague, find_covered(bare_discs, laden_discs.p_GK)
    )
