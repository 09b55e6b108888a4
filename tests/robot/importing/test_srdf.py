"""Files of MoveIt's setup assistant about a robot."""

from pathlib import Path

import pytest
from toy_robot import toy_urdf

from remosplat_drake.base.errors import FieldError, FileError
from remosplat_drake.robot.importing.srdf import find_srdf, read_srdf
from remosplat_drake.robot.importing.urdf import Urdf

SRDF = """
<robot name="toy">
  <group name="arm"><chain base_link="pedestal" tip_link="hand"/></group>
  <group name="lost"><chain base_link="pedestal" tip_link="nowhere"/></group>
  <group_state name="zero" group="arm"><joint name="joint_1" value="0"/>
  </group_state>
  <group_state name="arm_home" group="arm">
    <joint name="joint_1" value="0.5"/><joint name="joint_2" value="-1 0"/>
    <joint name="unknown" value="x"/>
  </group_state>
  <disable_collisions link1="hand" link2="forearm" reason="Never"/>
  <disable_collisions link1="forearm" link2="hand" reason="Never"/>
  <disable_collisions link1="hand" link2="gone"/>
</robot>"""


@pytest.fixture
def urdf() -> Urdf:
    return Urdf(Path("toy.urdf"), toy_urdf())


def test_what_is_about_the_robot_is_read(tmp_path, urdf):
    path = tmp_path / "toy.srdf"
    path.write_text(SRDF)
    srdf = read_srdf(path, urdf)
    assert srdf.tips == ("hand",)
    assert srdf.homes() == [
        ("arm_home", {"joint_1": 0.5, "joint_2": -1.0}),
        ("zero", {"joint_1": 0.0}),
    ]
    assert srdf.allowed_collisions == (("forearm", "hand"),)


@pytest.mark.parametrize(
    ("old", "new", "error", "message"),
    [
        ("</robot>", "", FileError, "toy.srdf: is not an SRDF"),
        ("robot", "group", FileError, "expected <robot>, got <group>"),
        ('"0.5"', '"half"', FieldError, "joint 'joint_1': expected a finite"),
    ],
)
def test_a_bad_srdf_is_told(tmp_path, urdf, old, new, error, message):
    path = tmp_path / "toy.srdf"
    path.write_text(SRDF.replace(old, new))
    with pytest.raises(error, match=message):
        read_srdf(path, urdf)


@pytest.mark.parametrize(
    "place", ["urdf/toy.srdf", "srdf/toy.srdf", "config/toy.srdf"]
)
def test_it_is_found_near_the_urdf(tmp_path, place):
    (tmp_path / place).parent.mkdir()
    (tmp_path / place).write_text(SRDF)
    assert find_srdf(tmp_path / "urdf" / "toy.urdf") == tmp_path / place


def test_one_of_another_robot_is_not_taken(tmp_path):
    (tmp_path / "srdf").mkdir()
    (tmp_path / "srdf" / "other.srdf").write_text(SRDF)
    assert find_srdf(tmp_path / "urdf" / "toy.urdf") is None
    (tmp_path / "srdf" / "toy.srdf").write_text(SRDF)
    found = find_srdf(tmp_path / "urdf" / "toy_with_gripper.urdf")
    assert found == tmp_path / "srdf" / "toy.srdf"


def test_a_gripper_belongs_to_the_link_that_carries_it(tmp_path, urdf):
    path = tmp_path / "toy.srdf"
    gripper = (
        '<group name="gripper"><link name="tool0"/><joint name="flange"/>'
        '</group><end_effector name="g" parent_link="hand" group="{}"/>'
        '<virtual_joint name="v" type="planar" child_link="pedestal"/></robot>'
    )
    path.write_text(SRDF.replace("</robot>", gripper.format("gripper")))
    srdf = read_srdf(path, urdf)
    assert srdf.tools == {"hand": ("tool0",)}
    assert srdf.is_planar
    # The arm's own group is no gripper: its links come before the hand.
    arm = gripper.format("all") + '<group name="all"><link name="wrist_1"/>'
    text = arm.replace("</robot>", "") + "</group></robot>"
    path.write_text(SRDF.replace("</robot>", text))
    assert read_srdf(path, urdf).tools == {"hand": ()}


def test_the_only_one_that_names_the_robot_is_taken(tmp_path):
    (tmp_path / "srdf").mkdir()
    path = tmp_path / "srdf" / "baxter_manipulation.srdf"
    path.write_text(SRDF.replace('"toy"', '"baxter"'))
    source = tmp_path / "urdf" / "baxter.urdf"
    assert find_srdf(source) is None
    assert find_srdf(source, "baxter") == path


def test_packed_away_is_no_home(tmp_path, urdf):
    path = tmp_path / "toy.srdf"
    state = '<group_state name="{}"><joint name="joint_1" value="1"/>'
    texts = [state.format(x) + "</group_state>" for x in ("tuck", "pick")]
    path.write_text(SRDF.replace("</robot>", "".join(texts) + "</robot>"))
    names = [name for name, _ in read_srdf(path, urdf).homes()]
    assert names == ["arm_home", "pick", "zero", "tuck"]
