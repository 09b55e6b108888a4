"""Joints at the root that stand for a base that drives are no arm's."""

from pathlib import Path
from xml.etree.ElementTree import SubElement

import pytest

from remosplat_drake.robot.importing.findings import Findings
from remosplat_drake.robot.importing.planar_base import without_planar_base
from remosplat_drake.robot.importing.urdf import Urdf

FAR = '<limit lower="-1000" upper="1000" effort="1" velocity="1"/>'


def robot(*joints: tuple[str, str, str]) -> Urdf:
    """A robot of joints in a row, each of a type, an axis and limits."""
    links = "".join(f'<link name="l{i}"/>' for i in range(len(joints) + 1))
    rows = "".join(
        f'<joint name="j{i}" type="{kind}"><parent link="l{i}"/>'
        f'<child link="l{i + 1}"/><axis xyz="{axis}"/>{limit}</joint>'
        for i, (kind, axis, limit) in enumerate(joints)
    )
    return Urdf(Path("a.urdf"), f'<robot name="a">{links}{rows}</robot>')


X, Y = ("prismatic", "1 0 0", FAR), ("prismatic", "0 1 0", FAR)
YAW, ROLL = ("revolute", "0 0 1", FAR), ("revolute", "1 0 0", FAR)
ENDLESS = [("prismatic", axis, "") for axis in ("1 0 0", "0 1 0")]
RAIL = ("prismatic", "1 0 0", FAR.replace("1000", "2"))


@pytest.mark.parametrize(
    "base", [(X, Y, YAW), (YAW, X, YAW), (YAW, X, Y), (*ENDLESS, YAW)]
)
def test_three_joints_in_the_plane_are_a_base(base):
    findings = Findings()
    urdf = without_planar_base(robot(*base, ROLL, ROLL), findings)
    assert urdf is not None
    moving = [name for name, joint in urdf.joints.items() if joint.moves]
    assert moving == ["j3", "j4"]
    assert findings.guessed == [
        ("base", "omni, as j0, j1, j2 move it in the plane")
    ]


def test_links_are_removed_only_if_they_are_mere_frames():
    """Their names are then free for the base that replaces them."""
    bare, findings = robot(X, Y, YAW, ROLL), Findings()
    urdf = without_planar_base(bare, findings)
    assert urdf is not None
    assert (urdf.base, list(urdf.joints)) == ("l3", ["j3"])
    bulky = robot(X, Y, YAW, ROLL)
    SubElement(bulky.links["l1"], "collision")
    urdf = without_planar_base(bulky, findings)
    assert urdf is not None
    assert (urdf.base, len(urdf.joints)) == ("l0", 4)


@pytest.mark.parametrize(
    "arm",
    [
        (X, RAIL, YAW, ROLL),  # A portal.
        (YAW, YAW, YAW, ROLL),  # A SCARA without its slide.
        (X, Y, ROLL, YAW),
        (X, Y),
    ],
)
def test_other_joints_are_an_arm(arm):
    findings = Findings()
    assert without_planar_base(robot(*arm), findings) is None
    assert not findings.guessed
