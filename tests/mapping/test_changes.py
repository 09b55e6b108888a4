"""Changes between older and newer frames."""

import numpy as np
import pytest
from laden_table import joined

from remosplat_drake.capture.capture import Capture
from remosplat_drake.mapping.changes import (
    coherent,
    find_changes,
    without,
)


def on_thing(capture: Capture) -> np.ndarray:
    """Pixels that show the thing, more than 5 cm above the table."""
    p_W = np.array([capture.points_W(i) for i in range(len(capture))])
    with np.errstate(invalid="ignore"):
        return p_W[..., 2] > 0.48


def test_nothing_changes_where_views_agree(bare, laden):
    for capture in (bare, laden):
        assert not find_changes(capture).outdated.any()


def test_a_thing_that_has_gone_is_hidden_in_the_older_views(laden, bare):
    changes = find_changes(joined(laden, bare))
    n = len(laden)
    shown = on_thing(laden)
    assert shown.sum() > 1000
    assert changes.gone[:n][shown].all()
    # Little else goes with it: its foot, and a border of two pixels.
    assert changes.gone[:n].sum() < 1.6 * shown.sum()
    assert not changes.outdated[n:].any()
    assert not changes.hidden_now.any()


def test_views_that_look_through_what_has_come_are_blind_there(bare, laden):
    changes = find_changes(joined(bare, laden))
    n = len(bare)
    assert not changes.gone.any()
    assert not changes.outdated[n:].any()
    # Of the thing's middle the first view now sees nothing.
    K, X_WC = bare.K[0], bare.X_WC[0]
    p_C = X_WC[:3, :3].T @ (np.array([1, 0, 0.6]) - X_WC[:3, 3])
    column, row = np.floor((K @ p_C)[:2] / p_C[2]).astype(int)
    assert changes.hidden_now[0, row, column]
    assert 0.03 < changes.hidden_now[:n].mean() < 0.5


def test_what_comes_back_is_there(laden, bare):
    """The newest look counts, not the most frequent one."""
    again = joined(laden, bare, laden)
    changes = find_changes(again)
    newest = len(laden) + len(bare)
    assert not changes.outdated[newest:].any()
    assert changes.hidden_now[len(laden) : newest].any()


def test_hidden_pixels_have_no_depth(laden, bare):
    both = joined(laden, bare)
    outdated = find_changes(both).outdated
    dut = without(both, find_changes(both).outdated)
    assert dut.hidden is not None
    np.testing.assert_array_equal(dut.hidden, outdated)
    assert (dut.depth[outdated] == 0).all()
    np.testing.assert_array_equal(dut.depth[~outdated], both.depth[~outdated])
    more = without(dut, np.ones(outdated.shape, bool))
    assert (more.depth == 0).all()
    assert more.hidden is not None and more.hidden.all()


def test_what_the_robot_hides_says_nothing(laden, bare):
    both = joined(laden, bare)
    robot = np.zeros(both.depth.shape, bool)
    robot[len(laden) :] = True
    assert not find_changes(without(both, robot)).outdated.any()


def test_noise_and_slivers_are_no_changes(bare):
    noisy = joined(bare, bare)
    rng = np.random.default_rng(0)
    wrong = rng.random(bare.depth.shape) < 0.02
    noisy.depth[len(bare) :][wrong] += 0.3
    noisy.depth[len(bare) :, :, 80:82] += 0.3
    assert not find_changes(noisy).outdated.any()


@pytest.mark.parametrize(("width", "kept"), [(4, False), (5, True)])
def test_a_region_counts_as_a_whole_if_it_is_wide_somewhere(width, kept):
    pixels = np.zeros((120, 160), bool)
    pixels[50 : 50 + width, 30 : 30 + width] = True
    tail = pixels.copy()
    tail[50, 30:90] = True
    np.testing.assert_array_equal(coherent(tail), tail & kept)
