"""The end effector and the arm's joints, from files or by a guess."""

from pathlib import Path

import pytest
from toy_robot import FINGERS, toy_urdf

from remosplat_drake.base.errors import FieldError
from remosplat_drake.robot.importing.arm_choice import ArmChoice, choose_arm
from remosplat_drake.robot.importing.findings import Findings
from remosplat_drake.robot.importing.joint_roles import has_wheels
from remosplat_drake.robot.importing.srdf import Srdf
from remosplat_drake.robot.importing.urdf import Urdf

ARM = [f"joint_{i}" for i in range(1, 7)]


def chosen(text: str, srdf: Srdf | None = None, *wanted: str):
    findings = Findings()
    urdf = Urdf(Path("toy.urdf"), text)
    links = {"": wanted[0]} if wanted else {}
    choice = choose_arm(urdf, srdf or Srdf(), links, findings)
    return choice, dict(findings.found), dict(findings.guessed)


def only(choice: ArmChoice) -> str:
    (link,) = choice.end_effectors.values()
    return link


def test_a_tool_frame_is_known_by_its_name():
    choice, _, guessed = chosen(toy_urdf())
    assert only(choice) == "tool0"
    assert [joint.name for joint in choice.joints] == ARM
    assert "tool0, by its name" in guessed["end effector"]


def test_without_such_a_name_it_is_the_last_link_that_moves():
    text = toy_urdf().replace("tool0", "plate").replace("hand", "cap")
    choice, _, guessed = chosen(text)
    assert only(choice) == "cap"
    assert "the last link that moves" in guessed["end effector"]


def test_the_tip_of_an_srdf_is_found_not_guessed():
    choice, found, guessed = chosen(toy_urdf(), Srdf(tips=("wrist_2",)))
    assert only(choice) == "wrist_2"
    assert [joint.name for joint in choice.joints] == ARM[:5]
    assert "SRDF" in found["end effector"]
    assert "end effector" not in guessed
    # The last joint belongs to no arm, and stays.
    assert choice.locked == {"joint_6": 0.0}


def test_a_chain_through_a_finger_ends_before_it():
    srdf = Srdf(tips=("left_finger",))
    text = toy_urdf(FINGERS).replace("tool0", "plate").replace("hand", "cap")
    choice, _, guessed = chosen(text, srdf)
    assert only(choice) == "cap"
    assert "carries the fingers" in guessed["end effector"]


def test_what_is_wanted_wins():
    choice, _, guessed = chosen(toy_urdf(), Srdf(tips=("hand",)), "forearm")
    assert [joint.name for joint in choice.joints] == ARM[:3]
    assert "end effector" not in guessed


def test_fingers_are_not_the_arms_and_stay_open():
    choice, _, guessed = chosen(toy_urdf(FINGERS))
    assert [joint.name for joint in choice.joints] == ARM
    # The right one follows the left one, the other way.
    assert choice.locked == {
        "left_finger_joint": 0.03,
        "right_finger_joint": -0.03,
    }
    assert "left_finger_joint" in guessed["fingers that stay open"]


def test_an_end_effector_that_does_not_exist_is_told():
    with pytest.raises(
        FieldError,
        match=r"toy.urdf: --end-effector: unknown link 'tool' \(did you mean"
        r" 'tool0'\?\)",
    ):
        chosen(toy_urdf(), None, "tool")


def test_an_end_effector_that_nothing_moves_is_told():
    with pytest.raises(
        FieldError, match="'pedestal': is not moved by any joint"
    ):
        chosen(toy_urdf(), None, "pedestal")


def test_a_joint_that_follows_the_arm_is_told():
    text = toy_urdf(
        FINGERS.replace('joint="left_finger_joint"', 'joint="joint_2"')
    )
    with pytest.raises(
        FieldError,
        match=r"joint 'right_finger_joint' <mimic>: follows 'joint_2', which"
        r" the arm commands.*remove the <mimic>",
    ):
        chosen(text)


def test_joints_that_follow_each_other_are_told():
    left = '<mimic joint="right_finger_joint"/><axis xyz="0 1 0"/>'
    text = FINGERS.replace('<axis xyz="0 1 0"/>', left, 1)
    with pytest.raises(FieldError, match="follows itself"):
        chosen(toy_urdf(text))


def test_wheels_are_known_by_name_and_kind():
    wheel = (
        '<link name="{0}"/><joint name="wheel_{0}" type="continuous">'
        '<parent link="pedestal"/><child link="{0}"/></joint>'
    )
    text = toy_urdf(wheel.format("l") + wheel.format("r"))
    assert has_wheels(Urdf(Path("toy.urdf"), text))
    assert not has_wheels(Urdf(Path("toy.urdf"), toy_urdf()))
    choice, _, guessed = chosen(text)
    assert choice.locked == {"wheel_l": 0.0, "wheel_r": 0.0}
    assert "wheel_l" in guessed["joints that stay at zero"]


def test_both_arms_of_a_torso_are_driven_behind_its_joint():
    text = "".join(
        f'<link name="{link}"/><joint name="{joint}" type="revolute">'
        f'<parent link="{parent}"/><child link="{link}"/></joint>'
        for parent, link, joint in [
            ("base", "torso", "waist"),
            *(
                (f"{side}_{i}" if i else "torso", f"{side}_{i + 1}", name)
                for side in ("left", "right")
                for i, name in enumerate([f"{side}_a", f"{side}_b"])
            ),
        ]
    )
    text = f'<robot name="r"><link name="base"/>{text}</robot>'
    choice, found, guessed = chosen(text)
    assert choice.end_effectors == {"left": "left_2", "right": "right_2"}
    names = ["waist", "left_a", "left_b", "right_a", "right_b"]
    assert [joint.name for joint in choice.joints] == names
    assert "5 joints" in found["arms"]
    assert "left_2" in guessed["end effector left"]
    # One of them alone, where it is asked for.
    choice, _, _ = chosen(text, None, "right_2")
    assert [joint.name for joint in choice.joints] == [
        "waist",
        "right_a",
        "right_b",
    ]
    assert choice.locked == {"left_a": 0.0, "left_b": 0.0}


def test_other_joints_stay_where_the_likeliest_state_has_them():
    srdf = Srdf(
        states={
            "stow": {"wheel": 9.0},
            "arm_home": {"joint_6": 0.4, "joint_1": 0.2},
        }
    )
    choice, _, guessed = chosen(toy_urdf(), srdf, "wrist_2")
    assert choice.locked == {"joint_6": 0.4}
    assert guessed["joints that stay as in 'arm_home'"] == "joint_6"
