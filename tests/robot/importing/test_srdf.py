"""What MoveIt's setup assistant has written about a robot."""

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
    <joint name="nobodys" value="x"/>
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
    assert srdf.home() == ("arm_home", {"joint_1": 0.5, "joint_2": -1.0})
    assert srdf.allowed_collisions == (("forearm", "hand"),)


@pytest.mark.parametrize(
    ("old", "new", "error", "message"),
    [
        ("</robot>", "", FileError, "toy.srdf: is no SRDF"),
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
