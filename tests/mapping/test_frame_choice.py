"""The frames that a map is made of."""

import dataclasses as dc

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.capture.frames import Frame
from remosplat_drake.mapping.frame_choice import (
    SAME_POSITION,
    SAME_ROTATION,
    confirmed_frames,
    contradicting_frames,
    frames_to_keep,
    hides_view_of,
)
from remosplat_drake.reconstruction.surfels.surfels import (
    splat_of_surfels,
    surfels_from_capture,
)
from remosplat_drake.splat.gaussian_splat import GaussianSplat


def poses(*positions: float, turn: float = 0.0) -> np.ndarray:
    """Cameras along x, each turned by so much more than the one before."""
    X_WC = np.tile(np.eye(4), (len(positions), 1, 1))
    for i, x in enumerate(positions):
        X_WC[i, 0, 3] = x
        X_WC[i, :3, :3] = Rotation.from_rotvec([0, i * turn, 0]).as_matrix()
    return X_WC


def test_of_equal_poses_the_newest_is_kept():
    kept = frames_to_keep(poses(0, 1, 0.5 * SAME_POSITION, 2), 80)
    np.testing.assert_array_equal(kept, [1, 2, 3])


def test_a_turn_makes_another_view():
    kept = frames_to_keep(poses(0, 0, turn=1.1 * SAME_ROTATION), 80)
    np.testing.assert_array_equal(kept, [0, 1])
    kept = frames_to_keep(poses(0, 0, turn=0.9 * SAME_ROTATION), 80)
    np.testing.assert_array_equal(kept, [1])


def test_then_the_oldest_go():
    kept = frames_to_keep(poses(0, 1, 2, 3), 2)
    np.testing.assert_array_equal(kept, [2, 3])


def test_of_nothing_nothing_is_kept():
    assert not len(frames_to_keep(poses(), 2))


@settings(max_examples=30)
@given(st.lists(st.floats(0, 0.1), max_size=12), st.integers(1, 12))
def test_the_newest_is_kept_and_all_that_are_kept_differ(positions, most):
    kept = frames_to_keep(poses(*positions), most)
    assert len(kept) <= most
    assert (np.diff(kept) > 0).all()
    if positions:
        assert kept[-1] == len(positions) - 1
    where = np.sort(np.array(positions)[kept])
    assert (np.diff(where) >= SAME_POSITION).all()


def misplaced(capture, view: int):
    X_WC = capture.X_WC.copy()
    X_WC[view, :3, 3] += 0.25
    return dc.replace(capture, X_WC=X_WC)


@pytest.mark.parametrize("trusted", [0, 3])
@pytest.mark.parametrize("wrong", [3, 5])
def test_the_one_that_is_elsewhere_is_found(scene_capture, trusted, wrong):
    capture = misplaced(scene_capture, wrong)
    assert not len(contradicting_frames(scene_capture, trusted))
    found = contradicting_frames(capture, trusted)
    np.testing.assert_array_equal(found, [wrong])


def test_one_that_shares_nothing_with_others_is_not_judged(scene_capture):
    """View 4 is moved to where no other one looks."""
    capture = misplaced(scene_capture, 4)
    assert not len(contradicting_frames(capture, trusted=3))


def test_nothing_bears_it_out_but_a_map_that_shows_the_same(scene_capture):
    capture = misplaced(scene_capture, 4)
    assert confirmed_frames(scene_capture).all()
    others = np.arange(len(capture)) != 4
    np.testing.assert_array_equal(confirmed_frames(capture), others)
    alone = scene_capture.select(np.array([4]))
    assert not confirmed_frames(alone)
    assert not confirmed_frames(alone, GaussianSplat.empty())
    base = splat_of_surfels(surfels_from_capture(scene_capture, 8000))
    assert confirmed_frames(alone, base)
    assert not confirmed_frames(misplaced(alone, 0), base)


def test_what_is_in_a_map_is_not_judged_again(scene_capture):
    found = contradicting_frames(misplaced(scene_capture, 2), trusted=3)
    assert not len(found)


def test_of_two_it_is_unknown_which_is_wrong(bare):
    pair = misplaced(bare, 1).select(np.array([0, 1]))
    with pytest.raises(RemoSplatError, match="contradict each other"):
        contradicting_frames(pair, trusted=0)
    np.testing.assert_array_equal(contradicting_frames(pair, trusted=1), [1])


def test_a_frame_stays_whose_view_a_newer_one_hides():
    X_WC = poses(0, 0, 0)
    assert frames_to_keep(X_WC, 80, lambda newer, older: True).tolist() == [
        0,
        1,
        2,
    ]
    # The newest hides what the first shows; the second shows no more.
    asked = {(2, 1): False, (2, 0): True}
    kept = frames_to_keep(X_WC, 80, lambda i, j: asked[i, j])
    assert kept.tolist() == [0, 2]


def test_what_is_hidden_that_an_older_frame_shows():
    depth = np.ones((20, 30), np.float32)
    depth[:, :10] = 0.0
    older = Frame("older", np.eye(3), np.eye(4), np.zeros((20, 30, 3)), depth)
    hidden = np.zeros((20, 30), bool)
    assert not hides_view_of(older, older)
    assert not hides_view_of(dc.replace(older, hidden=hidden), older)
    hidden[:, :10] = True
    assert not hides_view_of(dc.replace(older, hidden=hidden), older)
    hidden[:, 11] = True
    assert hides_view_of(dc.replace(older, hidden=hidden), older)
