"""A robot's URDF against our model: joints, limits, and axes as lines."""

import xml.etree.ElementTree as ElementTree

import pytest

from remosplat_drake.robot.robot_description import load_robot_description
from remosplat_drake.robot.urdf_agreement import urdf_problem

UR5E = load_robot_description("ur5e")
TEXT = UR5E.model_path.read_text()
FOREARM = '<origin xyz="0 -0.131 0.425" rpy="0 0 0"/>'


@pytest.mark.parametrize("name", ["ur5e", "fetch"])
def test_a_model_agrees_with_itself(name):
    description = load_robot_description(name)
    assert not urdf_problem(description.model_path.read_text(), description)


def test_other_frames_of_links_are_the_same_robot():
    """The base is turned and moved, and files of shapes are absent."""
    root = ElementTree.fromstring(TEXT)
    (child,) = [
        joint.find("origin")
        for joint in root.findall("joint")
        if joint.get("name") == UR5E.arm.joints[0]
    ]
    assert child is not None
    child.set("xyz", "3 -2 1")
    child.set("rpy", "0.3 1.0 -2")
    for mesh in root.iter("mesh"):
        mesh.set("filename", "package://absent/mesh.dae")
    assert not urdf_problem(ElementTree.tostring(root, "unicode"), UR5E)


@pytest.mark.parametrize(
    ("old", "new", "problem"),
    [
        ("elbow_joint", "elbow", "has no joint elbow_joint"),
        (
            'velocity="3.14159"',
            'velocity="2"',
            "shoulder_pan_joint: is limited to a speed of 2.00, but in",
        ),
        (
            'lower="-3.14159"',
            'lower="-2"',
            "elbow_joint: goes from -2.00 to 3.14, but in our model from -3.14",
        ),
        (
            'name="elbow_joint" type="revolute"',
            'name="elbow_joint" type="prismatic"',
            "elbow_joint: is prismatic, but revolute in our model",
        ),
        (FOREARM, FOREARM.replace("0.425", "0.432"), "differ from our model"),
        (FOREARM, FOREARM.replace('"0 0 0"', '"0.1 0 0"'), "differ from our"),
        ("</robot>", "", "is not a URDF: no"),
    ],
)
def test_a_difference_is_named(old, new, problem):
    assert problem in urdf_problem(TEXT.replace(old, new), UR5E)


def test_a_calibrated_arm_is_the_same_robot():
    """Its maker measured the upper arm 2 mm longer than planned."""
    text = TEXT.replace(FOREARM, FOREARM.replace("0.425", "0.427"))
    assert not urdf_problem(text, UR5E)
