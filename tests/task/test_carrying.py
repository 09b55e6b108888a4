"""A robot with something in its hand: all that is computed of it follows."""

import pickle

import numpy as np
import pytest
from carried import HALF_HEIGHT, RADIUS, around_can, can_at, can_in_hand
from pydrake.math import RigidTransform

from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.controller.controller_config import (
    ReactiveControllerConfig,
)
from remosplat_drake.controller.tick.reactive_law import ReactiveLaw
from remosplat_drake.robot.fitting.link_spheres import LinkSpheres
from remosplat_drake.robot.hand_links import hand_links
from remosplat_drake.robot.payload import Payload
from remosplat_drake.robot.self_collision.pairs import self_collision_pairs
from remosplat_drake.scene.objects.scene_object import SceneObject
from remosplat_drake.scene.primitive_scene import Box
from remosplat_drake.task.carrying import hull_pieces
from remosplat_drake.task.object_spheres import fit_object, overhang


@pytest.fixture(scope="module")
def payload(frankie):
    return can_in_hand(frankie, frankie.q_home)


def test_the_object_is_a_link_that_moves_with_the_hand(frankie, payload):
    held = frankie.holding(payload)
    assert held.spheres.links[-3:] == ("can",) * 3
    q = frankie.q_home + 0.1
    X_WL = held.body_poses(q)
    X_WE = frankie.end_effector_pose(q)
    assert X_WL[held.tree.index("can")] == pytest.approx(X_WE)
    spheres = held.spheres_at(q)
    assert spheres.p_WS[-2] == pytest.approx(X_WE[:3, 3])
    assert spheres.index.tolist() == list(range(len(held.spheres)))
    assert (held.hands[:, -3:]).all()


def test_a_payload_is_taken_and_put_down(frankie, payload):
    held = frankie.holding(payload)
    assert frankie.holding(payload) is held
    assert held.holding(None) is frankie
    assert frankie.holding(None) is frankie
    # Another process has another object of equal content.
    again = pickle.loads(pickle.dumps(payload))
    assert again == payload and frankie.holding(again) is held


def test_its_jacobians_are_those_of_its_spheres(frankie, payload):
    held, q = frankie.holding(payload), frankie.q_home.copy()
    bound, step = held.jacobian_bound, 1e-6
    assert bound.shape == (len(held.spheres), held.n_u)
    before = held.spheres_at(q).p_WS
    for j in range(held.n_u):
        u = np.zeros(held.n_u)
        u[j] = 1.0
        after = held.spheres_at(held.advance(q, u, step)).p_WS
        speed = np.linalg.norm(after - before, axis=1) / step
        assert (speed <= bound[:, j] + 1e-4).all()
        assert speed[-1] == pytest.approx(speed[-1])


def test_the_arm_bears_its_weight(frankie, payload):
    q, rest = frankie.q_home[None], np.zeros((1, 1, frankie.n_q))
    empty = frankie.dynamics.torques(q, rest, rest)[0, 0]
    held = frankie.holding(payload).dynamics.torques(q, rest, rest)[0, 0]
    X_WE = frankie.end_effector_pose(q[0])
    # The second joint is a hinge across the plane in which the arm stands.
    shoulder = frankie.body_poses(q[0])[frankie.tree.index("panda_link2")]
    lever = X_WE[0, 3] - shoulder[0, 3]
    assert held[1] - empty[1] == pytest.approx(-0.3 * 9.81 * lever)


def test_it_is_kept_off_the_robot_but_not_off_the_hand(frankie, payload):
    held = frankie.holding(payload)
    pairs = self_collision_pairs(held, 0.01)
    mine = {a for a, b in pairs.found.watched if b == "can"}
    assert {"base_link", "panda_link3", "panda_link6"} <= mine
    assert not mine & {*hand_links(frankie), "panda_link7"}
    # Those of the robot itself are what they were.
    own = self_collision_pairs(frankie, 0.01).found.watched
    assert pairs.found.watched[: len(own)] == own
    law = ReactiveLaw.make(ReactiveControllerConfig(), frankie, 0.01)
    more = law.holding(payload)
    assert more.robot is held and law.holding(payload) is more
    assert len(more.self_clearance.pairs) > len(law.self_clearance.pairs)
    assert law.holding(None) is law


def test_a_link_s_name_is_taken(frankie, payload):
    named = Payload("panda_hand", payload.link, np.eye(4), around_can(), ())
    with pytest.raises(RemoSplatError, match="a link 'panda_hand' already"):
        frankie.holding(named)


def test_the_hand_is_its_fingers_and_its_palm(frankie, three_link):
    fingers = {"panda_leftfinger", "panda_rightfinger"}
    assert hand_links(frankie) == {"panda_hand", *fingers}
    assert len(hand_links(three_link)) == 1


def test_pieces_and_spheres_enclose_the_object():
    can = can_at(RigidTransform())
    angle = np.linspace(0.0, 2.0 * np.pi, 50)
    rim = RADIUS * np.column_stack([np.cos(angle), np.sin(angle)])
    ends = [np.insert(rim, 2, z, axis=1) for z in (-HALF_HEIGHT, HALF_HEIGHT)]
    points = np.concatenate(ends)
    assert around_can().outside(points).max() < 1e-12
    fitted = fit_object(can)
    assert fitted.outside(points).max() < 0.0
    assert 0.0 < overhang(can, fitted) < 0.015
    (prism,) = hull_pieces(can.solid)
    assert np.linalg.norm(prism[:, :2], axis=1).min() > RADIUS


def test_the_overhang_is_what_sticks_out():
    box = SceneObject("box", Box(RigidTransform(), np.array([0.1, 0.1, 0.1])))
    one = LinkSpheres(np.zeros((1, 3)), np.array([0.13]))
    assert overhang(box, one) == pytest.approx(0.03)
