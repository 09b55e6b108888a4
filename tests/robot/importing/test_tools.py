"""The arms of a robot, and the frame of each that is its tool."""

import dataclasses as dc
from pathlib import Path

import pytest
from toy_robot import FINGERS, toy_urdf

from remosplat_drake.base.errors import FieldError
from remosplat_drake.robot.importing.srdf import Srdf
from remosplat_drake.robot.importing.tools import find_tools
from remosplat_drake.robot.importing.urdf import Urdf


def frame(name: str, parent: str, xyz: str = "0 0 0.05") -> str:
    return (
        f'<link name="{name}"/><joint name="{name}_mount" type="fixed">'
        f'<parent link="{parent}"/><child link="{name}"/>'
        f'<origin xyz="{xyz}"/></joint>'
    )


def one(extra: str = "", srdf: Srdf | None = None) -> tuple[str, str, bool]:
    """The tool of the toy arm, whose own tool frame has another name."""
    text = toy_urdf(extra).replace("tool0", "plate")
    (tool,) = find_tools(Urdf(Path("toy.urdf"), text), srdf or Srdf())
    return dc.astuple(tool)


def chain(name: str, count: int, parent: str = "base") -> str:
    text = ""
    for i in range(count):
        link = f"{name}_link_{i + 1}"
        text += (
            f'<link name="{link}"/>'
            f'<joint name="{name}_joint_{i + 1}" type="revolute">'
            f'<parent link="{parent}"/><child link="{link}"/></joint>'
        )
        parent = link
    return text


def robot(*chains: str) -> Urdf:
    text = f'<robot name="r"><link name="base"/>{"".join(chains)}</robot>'
    return Urdf(Path("r.urdf"), text)


@pytest.mark.parametrize(
    "name",
    [
        "gripper_frame_link",
        "/ee_gripper_link",
        "panda_grasptarget",
        "link_eef",
        "hand_tcp",
        "right_hand",
        "l_gripper_tool_frame",
        "arm_tool_link",
        "robot:attachment_site",
    ],
)
def test_frames_are_known_by_what_makers_call_them(name):
    assert one(frame(name, "hand")) == (name, "by its name", False)


def test_a_likelier_name_comes_first():
    frames = frame("flange", "hand") + frame("x_tcp", "hand")
    assert one(frames)[0] == "x_tcp"


def test_of_two_with_one_name_the_outer_one_is_the_tool():
    frames = frame("arm_tool", "hand") + frame("sensor", "arm_tool")
    assert one(frames + frame("sensor_tool", "sensor"))[0] == "sensor_tool"


def test_or_the_one_where_the_fingers_meet():
    frames = frame("far_tool", "hand", "0.1 0 0")
    frames += frame("near_tool", "hand", "0 0 0.01")
    assert one(frames + FINGERS)[0] == "near_tool"


def test_two_that_are_as_good_are_asked_for_in_one_line():
    frames = frame("a_tool", "hand", "0.1 0 0")
    frames += frame("b_tool", "hand", "-0.1 0 0")
    with pytest.raises(
        FieldError,
        match=r"--end-effector: is needed: a_tool and b_tool both have the"
        r" name of a tool, and are 200 mm apart$",
    ):
        one(frames)
    # In one place either will do.
    same = frame("a_tool", "hand") + frame("b_tool", "hand")
    assert one(same)[0] == "a_tool"


def test_without_a_name_it_is_what_carries_the_fingers():
    text = toy_urdf(frame("thing", "hand") + FINGERS)
    text = text.replace("tool0", "plate")
    # The fingers alone are on it.
    text = text.replace(
        '<parent link="hand"/><child link="left_finger"/>',
        '<parent link="thing"/><child link="left_finger"/>',
    ).replace(
        '<parent link="hand"/><child link="right_finger"/>',
        '<parent link="thing"/><child link="right_finger"/>',
    )
    text = text.replace('"hand"', '"cap"')
    (tool,) = find_tools(Urdf(Path("toy.urdf"), text), Srdf())
    assert dc.astuple(tool) == ("thing", "which carries the fingers", False)


def test_the_gripper_of_an_srdf_is_found_not_guessed():
    frames = frame("thing", "hand") + frame("some_tcp", "hand")
    srdf = Srdf(tools={"hand": ("thing",)})
    assert one(frames, srdf) == ("thing", "the SRDF's gripper", True)
    # A group that names a tool means that.
    srdf = Srdf(tools={"hand": ("thing", "some_tcp")})
    assert one(frames, srdf)[0] == "some_tcp"


def test_two_arms_have_a_tool_each():
    arms = chain("left", 6) + chain("right", 6)
    hands = frame("left_hand", "left_link_6") + frame(
        "right_hand", "right_link_6"
    )
    tools = find_tools(robot(arms, hands), Srdf())
    assert [tool.link for tool in tools] == ["left_hand", "right_hand"]


def test_neither_legs_nor_a_head_are_arms():
    urdf = robot(
        chain("left", 5), chain("right", 5), chain("leg", 6), chain("head", 7)
    )
    tools = find_tools(urdf, Srdf())
    assert [tool.link for tool in tools] == ["left_link_5", "right_link_5"]


def test_an_srdf_says_which_arm_is_meant():
    urdf = robot(chain("left", 6), chain("right", 6), chain("mast", 2))
    tools = find_tools(urdf, Srdf(tips=("right_link_6", "mast_link_2")))
    assert [tool.link for tool in tools] == ["right_link_6"]


def test_three_arms_are_asked_for_in_one_line():
    urdf = robot(chain("a", 6), chain("b", 6), chain("c", 6))
    with pytest.raises(
        FieldError,
        match=r"--end-effector: is needed, once for each arm: 3 chains are"
        r" equally long; they end at a_link_6, b_link_6, c_link_6",
    ):
        find_tools(urdf, Srdf())
