"""A target and its ghost say by their colour what is so."""

import numpy as np
import pytest

viser = pytest.importorskip("viser")

from remosplat_drake.cockpit.ghost import COLOURS, Ghost
from remosplat_drake.cockpit.reach import (
    BLOCKED,
    OUT_OF_REACH,
    REACHABLE,
    UNSEEN_THERE,
    Reach,
)
from remosplat_drake.cockpit.robot_shapes import robot_shapes
from remosplat_drake.robot.robot_model import load_robot


@pytest.fixture(scope="module")
def frankie():
    return load_robot("frankie")


@pytest.fixture
def scene():
    server = viser.ViserServer(host="127.0.0.1", port=0, verbose=False)
    yield server.scene
    server.stop()


def test_every_verdict_has_its_own_colour():
    verdicts = REACHABLE, BLOCKED, UNSEEN_THERE, OUT_OF_REACH
    assert len({COLOURS[verdict] for verdict in verdicts}) == len(verdicts)


def test_target_and_robot_take_the_verdicts_colour(frankie, scene):
    ghost = Ghost(scene, frankie, robot_shapes(frankie))
    q = frankie.q_home
    X_WT = frankie.end_effector_pose(q)
    target, hand = ghost._target, ghost._links["panda_hand"]
    assert not target.visible and not hand.visible
    ghost.show(Reach(BLOCKED, "", q), X_WT)
    for part in (target, hand):
        assert part.visible and tuple(part.color) == COLOURS[BLOCKED]
    np.testing.assert_allclose(target.position, X_WT[:3, 3])
    p_WHand = frankie.body_poses(q)[frankie.tree.index("panda_hand")][:3, 3]
    np.testing.assert_allclose(hand.position, p_WHand, atol=1e-9)
    # No robot can stand there: the target alone says so.
    ghost.show(Reach(OUT_OF_REACH, ""), X_WT)
    assert target.visible and tuple(target.color) == COLOURS[OUT_OF_REACH]
    assert not hand.visible
    ghost.hide()
    assert not target.visible
    ghost.remove()
