"""Targets that are offered where the operator's does not work."""

import numpy as np
import pytest

from remosplat_drake.cockpit.offers import (
    BACK_OFF,
    HIGHER,
    LABELS,
    LOOK_THERE,
    NEARER,
    OTHER_SIDE,
    SETTLES,
    OfferSearch,
    Trouble,
    candidates,
    place_at_home,
)
from remosplat_drake.robot.pose_error import pose_error
from remosplat_drake.robot.robot_model import load_robot

FIELD = object()
X_WE, X_WT = np.eye(4), np.diag([1.0, -1.0, -1.0, 1.0])
X_WT[:3, 3] = 0.8, 0.1, 0.4
P_HOME = np.zeros(3)
P_UNSEEN = np.array([1.0, 0.3, 0.2])


class Clock:
    """A clock that a test sets."""

    def __init__(self):
        self.time = 0.0

    def __call__(self) -> float:
        return self.time


def free_above(height: float):
    return lambda X_WT: X_WT[2, 3] > height


def searched(
    trouble: Trouble | None, works, search=None, field=FIELD
) -> OfferSearch:
    clock = Clock()
    search = search or OfferSearch(clock)
    search._clock = clock
    search.begin(trouble, field)
    clock.time += 2 * SETTLES
    for _ in range(50):
        search.step(works)
    return search


def test_tests_begin_late_and_take_half_of_the_time():
    clock, tests = Clock(), []

    def works(X_WT: np.ndarray) -> bool:
        tests.append(clock.time)
        clock.time += 0.2
        return False

    search = OfferSearch(clock)
    for k in range(100):
        clock.time = max(clock.time, 0.05 * k)
        if k < 20:  # A gizmo is dragged for a second.
            X_WT = np.eye(4)
            X_WT[0, 3] = k
        search.begin(Trouble(X_WT, X_WE, P_HOME), FIELD)
        search.step(works)
    assert tests[0] >= 0.95 + SETTLES
    assert np.diff(tests).min() >= 0.4 - 1e-9
    assert len(tests) > 5


def test_the_smallest_change_that_works_is_offered():
    offers = {
        offer.label: offer.X_WT
        for offer in searched(
            Trouble(X_WT, X_WE, P_HOME), free_above(0.44)
        ).offers
    }
    # The hand points down, so backing off is up, too; home is below.
    assert set(offers) == {BACK_OFF, HIGHER}
    for offered in offers.values():
        np.testing.assert_allclose(offered[:3, 3], [0.8, 0.1, 0.46])
        np.testing.assert_array_equal(offered[:3, :3], X_WT[:3, :3])


def test_all_that_works_is_offered_once():
    trouble = Trouble(X_WT, X_WE, P_HOME, P_UNSEEN, np.eye(4))
    offers = searched(trouble, free_above(-1.0)).offers
    assert {offer.label for offer in offers} == set(LABELS)
    assert len(offers) == len(LABELS)


@pytest.mark.parametrize("label", LABELS)
def test_the_candidates_are_poses(label):
    trouble = Trouble(X_WT, X_WE, P_HOME, P_UNSEEN, np.eye(4))
    poses = [X for name, X in candidates(trouble) if name == label]
    assert poses
    for X in poses:
        np.testing.assert_allclose(
            X[:3, :3] @ X[:3, :3].T, np.eye(3), atol=1e-9
        )
        error = pose_error(X_WT, X)
        if label == OTHER_SIDE:
            assert error.distance < 1e-12 and error.angle > 1.5
        elif label in (BACK_OFF, HIGHER, NEARER):
            assert error.distance > 0.02 and error.angle < 1e-6


@pytest.mark.parametrize("label", [LOOK_THERE])
def test_the_camera_looks_at_what_is_unseen(label):
    X_EC = np.eye(4)
    X_EC[:3, 3] = 0.05, 0.0, 0.1
    trouble = Trouble(X_WT, X_WE, P_HOME, P_UNSEEN, X_EC)
    for name, X_WT_offered in candidates(trouble):
        if name == label:
            X_WC = X_WT_offered @ X_EC
            p_C = X_WC[:3, :3].T @ (P_UNSEEN - X_WC[:3, 3])
            np.testing.assert_allclose(p_C[:2], 0, atol=1e-9)
            assert p_C[2] > 0.1


def test_a_search_goes_on_while_nothing_changes():
    search = searched(Trouble(X_WT, X_WE, P_HOME), free_above(0.44))
    offers = search.offers
    drifted = X_WE.copy()
    drifted[0, 3] += 1e-4
    searched(Trouble(X_WT, drifted, P_HOME), free_above(10), search)
    assert search.offers is offers
    moved = X_WT.copy()
    moved[0, 3] += 0.1
    searched(Trouble(moved, X_WE, P_HOME), free_above(10), search)
    assert search.offers == ()
    searched(None, free_above(0), search)
    assert search.offers == ()


def test_another_map_is_searched_anew():
    search = searched(Trouble(X_WT, X_WE, P_HOME), free_above(10))
    assert search.offers == ()
    trouble = Trouble(X_WT, X_WE, P_HOME)
    assert searched(trouble, free_above(-1), search).offers == ()
    assert searched(trouble, free_above(-1), search, object()).offers


def test_where_no_path_leads_only_what_is_nearer_is_tested():
    trouble = Trouble(X_WT, X_WE, P_HOME, is_cut_off=True)
    offers = searched(trouble, free_above(-1)).offers
    assert [offer.label for offer in offers] == [NEARER]
    assert not trouble.is_like(Trouble(X_WT, X_WE, P_HOME))


def test_home_goes_along_with_the_base():
    robot = load_robot("frankie")
    q = robot.q_home.copy()
    at_start = place_at_home(robot, q)
    q[0] += 1.0
    q[3:] += 0.3
    moved = place_at_home(robot, q) - at_start
    np.testing.assert_allclose(moved, [1, 0, 0], atol=1e-9)


def test_home_turns_with_the_base():
    robot = load_robot("frankie")
    q = robot.q_home.copy()
    x, y, z = place_at_home(robot, q)
    q[2] = np.pi / 2
    turned = place_at_home(robot, q)
    np.testing.assert_allclose(turned, [-y, x, z], atol=1e-9)
