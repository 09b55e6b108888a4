"""Roles of joints, by the names that makers give them."""

from pathlib import Path

import pytest
from toy_robot import FINGERS, toy_urdf

from remosplat_drake.robot.importing.joint_roles import (
    is_finger,
    is_of_arm,
    side_names,
    words,
)
from remosplat_drake.robot.importing.urdf import Urdf


def urdf_with(joint: str, child: str = "part", extra: str = "") -> Urdf:
    text = (
        f'<link name="{child}"/><joint name="{joint}" type="revolute">'
        f'<parent link="hand"/><child link="{child}"/></joint>{extra}'
    )
    return Urdf(Path("toy.urdf"), toy_urdf(text))


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("LHipYaw", ["l", "hip", "yaw"]),
        ("l_hip_yaw", ["l", "hip", "yaw"]),
        ("jointGripper", ["joint", "gripper"]),
        ("Left_GRIPPER_X1", ["left", "gripper", "x", "1"]),
        ("LF_HAA", ["lf", "haa"]),
        ("arm2_6", ["arm", "2", "6"]),
    ],
)
def test_names_are_words_however_they_are_joined(name, expected):
    assert words(name) == expected


@pytest.mark.parametrize(
    ("joint", "child"),
    [
        ("jointGripper", "gripperMover"),  # Unitree Z1.
        ("gripper", "moving_jaw_so101_v1_link"),
        ("hand_mrl_joint", "hand_mrl_link"),  # TIAGo's hand.
        ("drive_joint", "left_outer_knuckle"),  # xArm's gripper.
        ("LHand", "LFinger11Link"),  # Romeo.
        ("left_hand_middle_0_joint", "left_hand_middle_0_link"),  # G1.
    ],
)
def test_these_open_a_hand(joint, child):
    urdf = urdf_with(joint, child)
    assert is_finger(urdf, urdf.joints[joint])


@pytest.mark.parametrize(
    ("joint", "child"),
    [
        ("wrist_roll", "gripper_link"),  # SO-101.
        ("wrist_rotate", "/gripper_link"),  # WidowX 250.
        ("LeftGripperYaw", "LeftGripperYawLink"),  # Alex.
        ("panda_joint7", "panda_link7"),
        ("gripper_to_arm", "base_link"),
    ],
)
def test_these_carry_one(joint, child):
    urdf = urdf_with(joint, child)
    assert not is_finger(urdf, urdf.joints[joint])
    assert is_of_arm(urdf, urdf.joints[joint])


@pytest.mark.parametrize(
    "joint", ["LHipYaw", "LF_HAA", "head_1_joint", "caster_wheel", "NeckYaw"]
)
def test_these_are_no_arms(joint):
    urdf = urdf_with(joint)
    assert not is_of_arm(urdf, urdf.joints[joint])


def test_joints_that_follow_each_other_on_a_link_are_fingers():
    text = FINGERS.replace("finger", "plate")
    urdf = Urdf(Path("toy.urdf"), toy_urdf(text))
    for name in ("left_plate_joint", "right_plate_joint"):
        assert is_finger(urdf, urdf.joints[name])
    assert not is_finger(urdf, urdf.joints["joint_6"])


@pytest.mark.parametrize(
    ("links", "expected"),
    [
        (["left_gripper", "right_gripper"], ["left", "right"]),
        (["r_gripper_tool_frame", "l_gripper_tool_frame"], ["right", "left"]),
        (["LeftSakePalm", "RightSakePalm"], ["left", "right"]),
        (["panda_1_hand", "panda_2_hand"], ["arm_1", "arm_2"]),
        (["upper_tcp", "lower_tcp"], ["upper", "lower"]),
        (["hand", "hand_link"], ["arm_1", "arm_2"]),
    ],
)
def test_hands_are_called_by_what_tells_them_apart(links, expected):
    assert side_names(links) == expected
