"""Fingers of a robot's model follow the width of its hand."""

import numpy as np
import pytest
from pydrake.multibody.plant import MultibodyPlant

from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.robot.fitting.link_spheres import LinkSpheres
from remosplat_drake.robot.model_file import add_robot_model
from remosplat_drake.robot.payload import Payload
from remosplat_drake.robot.robot_model import load_robot
from remosplat_drake.robot.self_collision.pairs import self_collision_pairs

WIDTH = 0.03


@pytest.fixture(scope="module")
def panda():
    return load_robot("panda")


def spheres_in_hand(robot, link):
    """Centres of a link's spheres in the hand's frame, at home, (n, 3)."""
    X_WL = robot.body_poses(robot.q_home)
    X_WH = X_WL[robot.tree.index("panda_hand")]
    X_HL = np.linalg.inv(X_WH) @ X_WL[robot.tree.index(link)]
    p_LS = robot.spheres.on_link(link).p_LS
    return p_LS @ X_HL[:3, :3].T + X_HL[:3, 3]


def test_each_finger_moves_by_half_of_the_width(panda):
    """From 80 to 30 mm: 25 mm inwards along y, nothing else."""
    narrow = panda.with_hand_width(WIDTH)
    assert (panda.hand_width, narrow.hand_width) == (0.08, WIDTH)
    for link, way in (
        ("panda_leftfinger", -0.025),
        ("panda_rightfinger", 0.025),
        ("panda_hand", 0.0),
        ("panda_link7", 0.0),
    ):
        moved = spheres_in_hand(narrow, link) - spheres_in_hand(panda, link)
        np.testing.assert_allclose(moved, [[0, way, 0]] * len(moved), atol=1e-9)
    np.testing.assert_array_equal(
        narrow.end_effector_pose(panda.q_home),
        panda.end_effector_pose(panda.q_home),
    )


def test_poses_are_those_of_the_plant(panda):
    narrow, plant = panda.with_hand_width(WIDTH), MultibodyPlant(0.0)
    add_robot_model(panda.description, plant)
    plant.Finalize()
    context = plant.CreateDefaultContext()
    position = dict(zip(panda.joint_names, panda.q_home, strict=True))
    positions = plant.GetPositions(context)
    for name, value in (position | narrow.description.locked).items():
        positions[plant.GetJointByName(name).position_start()] = value
    plant.SetPositions(context, positions)
    X_WL = narrow.body_poses(narrow.q_home)
    for i, name in enumerate(narrow.tree.names[1:], start=1):
        body = plant.GetBodyByName(name)
        expected = plant.EvalBodyPoseInWorld(context, body).GetAsMatrix4()
        np.testing.assert_allclose(X_WL[i], expected, atol=1e-12)


def test_fingers_keep_from_the_arm_where_they_are(panda):
    """The same pairs of links, at the distances of a model made for it."""
    narrow = panda.with_hand_width(WIDTH)
    pairs = self_collision_pairs(narrow, 0.01)
    q = np.array([0, -0.6, 0, -2.9, 0.4, 0.6, 0.8])
    made = type(panda)(narrow.description, panda.spheres)
    expected = self_collision_pairs(made, 0.01)
    assert pairs.found.watched == expected.found.watched
    np.testing.assert_allclose(pairs.distances(q), expected.distances(q))
    wide = self_collision_pairs(panda, 0.01).distances(q)
    assert abs(pairs.distances(q) - wide).max() > 0.01


def test_models_of_one_width_are_one_object(panda):
    narrow = panda.with_hand_width(WIDTH)
    assert panda.with_hand_width(WIDTH) is narrow
    assert narrow.with_hand_width(WIDTH) is narrow
    assert narrow.with_hand_width(0.05) is panda.with_hand_width(0.05)
    assert narrow.as_described is panda


def test_a_payload_stays_in_the_hand(panda):
    ball = LinkSpheres(np.zeros((1, 3)), np.array([0.015]))
    corners = 0.01 * np.eye(3)
    payload = Payload("ball", "panda_hand", np.eye(4), ball, (corners,), 0.1)
    one = panda.holding(payload).with_hand_width(WIDTH)
    assert one is panda.with_hand_width(WIDTH).holding(payload)
    assert (one.payload, one.hand_width) == (payload, WIDTH)
    assert one.holding(None) is panda.with_hand_width(WIDTH)


@pytest.mark.parametrize("width", [-0.01, 0.081])
def test_a_hand_opens_only_so_far(panda, width):
    with pytest.raises(RemoSplatError, match=r"opens from 0 to 0\.08 m, not"):
        panda.with_hand_width(width)


def test_an_arm_without_a_hand_has_no_width():
    arm = load_robot("ur5e")
    assert arm.hand_width is None
    with pytest.raises(RemoSplatError, match="no hand"):
        arm.with_hand_width(WIDTH)
