"""Implicit settings of MuJoCo are written out, by the rules of its manual."""

from pathlib import Path
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

import pytest

from remosplat_drake.base.errors import FieldError
from remosplat_drake.robot.importing.mjcf import SaidOfJoints, prepare_mjcf
from remosplat_drake.robot.importing.urdf import Loop, Mimic


def prepared(text: str) -> tuple[Element, SaidOfJoints]:
    root = ElementTree.fromstring(f"<mujoco>{text}</mujoco>")
    said = prepare_mjcf(Path("arm.xml"), root, lambda file: f"/found/{file}")
    return root, said


def joint(defaults: str, body: str = '<joint name="j"/>') -> Element:
    inner = f'<worldbody><body name="b">{body}</body></worldbody>'
    found = prepared(f"{defaults}{inner}")[0].find(".//joint")
    assert found is not None
    return found


def test_a_class_inherits_over_one_that_says_nothing():
    # As in the models of Universal Robots of MuJoCo Menagerie.
    j = joint(
        '<default><default class="arm"><joint axis="0 1 0" range="-2 2"/>'
        '<default class="size3"><default class="size3_limited">'
        '<joint range="-1 1"/></default></default></default></default>',
        '<joint name="j" class="size3_limited"/>',
    )
    assert j.attrib == {"name": "j", "axis": "0 1 0", "range": "-1 1"}


def test_the_nearest_childclass_is_meant():
    defaults = (
        '<default><joint damping="1" axis="1 0 0"/>'
        '<default class="outer"><joint axis="0 1 0"/></default>'
        '<default class="inner"><joint axis="0 0 1"/></default></default>'
    )
    j = joint(
        defaults,
        '<body childclass="outer"><body childclass="inner"><body>'
        '<joint name="j"/></body></body></body>',
    )
    assert j.attrib == {"name": "j", "axis": "0 0 1", "damping": "1"}
    own = joint(
        defaults,
        '<body childclass="inner"><joint name="j" class="outer"/></body>',
    )
    assert own.get("axis") == "0 1 0"


def test_the_outermost_class_is_meant_everywhere_whatever_its_name():
    j = joint('<default class="all"><joint range="-1 1"/></default>')
    assert j.get("range") == "-1 1"


def test_defaults_in_several_places_are_one():
    j = joint(
        '<default><joint axis="1 0 0" range="0 1"/></default>'
        '<default><joint axis="0 1 0"/></default>'
    )
    assert (j.get("axis"), j.get("range")) == ("0 1 0", "0 1")


def test_an_orientation_takes_the_place_of_any_other():
    root, _ = prepared(
        '<default><geom euler="0 0 1" size="1"/></default><worldbody>'
        '<body name="b"><geom quat="1 0 0 0"/></body></worldbody>'
    )
    geom = root.find(".//geom")
    assert geom is not None
    assert geom.attrib == {"size": "1", "quat": "1 0 0 0"}


def test_nothing_of_a_class_is_left_for_drake():
    root, _ = prepared(
        '<default><default class="a"><geom size="1"/></default></default>'
        '<worldbody><body childclass="a"><geom class="a"/></body></worldbody>'
        '<actuator><motor class="a"/></actuator>'
    )
    assert root.find("default") is None
    assert not [
        e for e in root.iter() if {"class", "childclass"} & e.attrib.keys()
    ]


def test_an_unknown_class_is_told_with_its_element():
    with pytest.raises(
        FieldError,
        match=r"arm.xml: joint 'j': unknown class 'aarm' .did you mean 'arm'",
    ):
        joint(
            '<default><default class="arm"/></default>',
            '<joint name="j" class="aarm"/>',
        )


def test_meshes_are_called_by_their_files():
    root, _ = prepared(
        '<compiler meshdir="shapes"/><asset><mesh file="hand.v2.stl"/>'
        '<mesh name="arm" file="a.obj"/></asset>'
    )
    meshes = [mesh.attrib for mesh in root.iter("mesh")]
    assert meshes == [
        {"name": "hand.v2", "file": "/found/shapes/hand.v2.stl"},
        {"name": "arm", "file": "/found/shapes/a.obj"},
    ]
    assert not root.find("compiler").attrib


def test_a_site_becomes_a_frame_unless_a_body_has_its_name():
    root, _ = prepared(
        '<default><site pos="0 0 1"/></default><worldbody><body name="hand">'
        '<site name="hand"/><site name="tip" quat="0 1 0 0" size="1"/>'
        '<site name="ray" fromto="0 0 0 0 0 1"/><site/></body></worldbody>'
    )
    bodies = [body.attrib for body in root.iter("body")]
    assert bodies == [
        {"name": "hand"},
        {"name": "tip", "pos": "0 0 1", "quat": "0 1 0 0"},
    ]
    assert next(root.iter("site"), None) is None


def test_each_joint_has_a_body_of_its_own():
    root, _ = prepared(
        '<worldbody><body name="b" pos="1 0 0"><inertial mass="1"/>'
        '<joint name="j"/><joint name="k"/><joint name="l"/><geom size="1"/>'
        "</body></worldbody>"
    )
    bodies = list(root.iter("body"))
    assert [body.attrib for body in bodies] == [
        {"pos": "1 0 0", "name": "b_j"},
        {"name": "b_k"},
        {"name": "b"},
    ]
    assert [[child.tag for child in body] for body in bodies] == [
        ["joint", "body"],
        ["joint", "body"],
        ["joint", "inertial", "geom"],
    ]
    assert [joint.get("name") for joint in root.iter("joint")] == [*"jkl"]


def test_an_inertia_without_mass_is_none():
    root, _ = prepared(
        '<worldbody><body name="a"><inertial mass="0" diaginertia="0 0 0"/>'
        '<geom size="1"/></body></worldbody>'
    )
    assert next(root.iter("inertial"), None) is None
    assert next(root.iter("geom")).get("mass") == "0"


def test_what_couples_joints_is_taken_out():
    root, said = prepared(
        '<equality><joint joint1="b" joint2="a" polycoef="0.1 -1 0 0 0"/>'
        '<joint joint1="d" joint2="c"/><joint joint1="e"/>'
        '<connect body1="x" body2="y" anchor="0 0 0"/><weld body1="x"/>'
        "</equality>"
    )
    assert said.mimics == {
        "b": Mimic("a", "-1", "0.1"),
        "d": Mimic("c", "1", "0"),
    }
    assert said.loops == [
        Loop("<equality> <connect> x", "x", "y"),
        Loop("<equality> <weld> x", "x", "world"),
    ]
    # A joint that is held follows none.
    assert [e.get("joint1") for e in root.find("equality")] == ["e"]


def test_a_weld_by_which_a_body_is_dragged_closes_no_loop():
    root, said = prepared(
        '<worldbody><body name="mouse" mocap="true"/></worldbody>'
        '<equality><weld body1="mouse" body2="hand"/></equality>'
    )
    assert not said.loops
    assert next(root.iter("weld"), None) is None


def test_keyframes_name_the_positions_of_all_joints():
    _, said = prepared(
        '<worldbody><body><joint name="a"/><body><joint name="b"/></body>'
        "</body></worldbody><keyframe>"
        '<key name="home" qpos="1 -2"/><key name="short" qpos="1"/>'
        '<key name="odd" qpos="1 x"/></keyframe>'
    )
    assert said.states == {"home": {"a": 1.0, "b": -2.0}}
