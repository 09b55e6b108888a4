"""Two end effectors: where they are, and what moves them."""

import numpy as np
import pytest

from remosplat_drake.base.errors import FieldError
from remosplat_drake.robot.robot_description import Hand, RobotDescription
from remosplat_drake.robot.robot_model import RobotModel


@pytest.fixture
def q(two_arms) -> np.ndarray:
    return two_arms.q_home + np.random.default_rng(3).normal(0, 0.3, 13)


def test_they_have_names_and_places(two_arms):
    assert two_arms.effectors == ("left", "right")
    left, right = two_arms.end_effector_poses(two_arms.q_home)
    np.testing.assert_allclose(left[:3, 3] * [1, -1, 1], right[:3, 3])
    np.testing.assert_array_equal(
        two_arms.end_effector_pose(two_arms.q_home, 1), right
    )


def test_each_has_its_own_jacobian(two_arms, q):
    state, h = two_arms.state(q), 1e-6
    for effector in (0, 1):
        J = state.J_WE(effector)
        for j in range(two_arms.n_u):
            u = np.eye(two_arms.n_u)[j]
            before, after = (
                two_arms.end_effector_pose(
                    two_arms.advance(q, u, sign * h), effector
                )
                for sign in (-1, 1)
            )
            v = (after - before)[:3, 3] / (2 * h)
            W = (after - before)[:3, :3] @ state.X_WEs[effector, :3, :3].T
            w = np.array([W[2, 1], W[0, 2], W[1, 0]]) / (2 * h)
            np.testing.assert_allclose(J[:, j], [*w, *v], atol=1e-6)
    # The torso moves both, an arm only its own hand.
    moves = np.array([np.abs(state.J_WE(e)).max(axis=0) > 0 for e in (0, 1)])
    assert moves[:, 0].all()
    assert not (moves[0] & moves[1])[1:].any()


def test_each_hand_leads_with_its_own_spheres(two_arms):
    links = np.array(two_arms.spheres.links)
    left, right = two_arms.hands
    assert set(links[left]) == {"left_hand"}
    assert set(links[right]) == {"right_hand"}
    np.testing.assert_array_equal(two_arms.leading_spheres, left | right)


def test_an_only_one_has_no_name(frankie):
    assert frankie.effectors == ("",)
    assert frankie.hands.shape == (1, len(frankie.spheres))


def test_both_ways_to_name_them_are_one_too_many():
    with pytest.raises(FieldError, match="not both"):
        RobotDescription(
            end_effector_frame="tip", end_effectors={"left": "tip"}
        )


GRIPPER = Hand(name="left", joints=["a", "b"])


def test_hands_belong_to_end_effectors(frankie):
    frames = {"left": "l", "right": "r"}
    description = RobotDescription(
        end_effectors=frames, hands={"right": GRIPPER}
    )
    assert description.effector_hands == {"right": GRIPPER}
    (only,) = frankie.description.effector_hands.items()
    assert only == ("", frankie.description.hand)
    assert RobotDescription(end_effectors=frames).effector_hands == {}


@pytest.mark.parametrize(
    ("fields", "message"),
    [
        ({"hand": GRIPPER, "hands": {"left": GRIPPER}}, "not both"),
        ({"hands": {"middle": GRIPPER}}, "unknown end effector 'middle'"),
        (
            {"hands": {"left": GRIPPER, "right": GRIPPER}},
            "hands: each gripper needs its own name",
        ),
    ],
)
def test_hands_that_belong_to_none_are_refused(fields, message):
    with pytest.raises(FieldError, match=message):
        RobotDescription(end_effectors={"left": "l", "right": "r"}, **fields)


def test_a_frame_that_is_not_there_is_named(two_arms):
    description = RobotDescription(**vars(two_arms.description))
    description.end_effectors = {"left": "left_tip", "right": "nose"}
    with pytest.raises(FieldError, match=r"end_effectors.right.*'nose'"):
        RobotModel(description, two_arms.spheres)
