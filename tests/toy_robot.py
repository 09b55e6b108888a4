"""A small arm of six joints with a gripper, in a ROS package of its own."""

from itertools import pairwise
from pathlib import Path

import trimesh

PACKAGE = "<package><name>toy_description</name></package>"

_LINK = """
  <link name="{name}">
    <inertial><mass value="1"/>
      <inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/>
    </inertial>
    <collision><origin xyz="0 0 {middle}"/>
      <geometry>{shape}</geometry>
    </collision>
  </link>"""

_JOINT = """
  <joint name="{name}" type="{kind}">
    <parent link="{parent}"/><child link="{child}"/>
    <origin xyz="{xyz}"/><axis xyz="{axis}"/>
    {limit}
  </joint>"""

_CYLINDER = '<cylinder radius="0.04" length="{}"/>'
_MESH = '<mesh filename="package://toy_description/meshes/{}" scale="{}"/>'
LIMIT = '<limit lower="-2.6" upper="2.6" velocity="2" effort="50"/>'


def toy_urdf(gripper: str = "") -> str:
    """The text of the URDF: shoulder, elbow and wrist along the z axis.

    Args:
        gripper: Further elements, such as fingers on `hand`.
    """
    lengths = {
        "pedestal": 0.1,
        "shoulder": 0.1,
        "upper_arm": 0.35,
        "forearm": 0.3,
        "wrist_1": 0.1,
        "wrist_2": 0.1,
    }
    parts = [
        _LINK.format(
            name=name, middle=length / 2, shape=_CYLINDER.format(length)
        )
        for name, length in lengths.items()
    ]
    # In millimetres, as many CAD programs write them.
    shape = _MESH.format("hand.stl", "0.001 0.001 0.001")
    parts.append(_LINK.format(name="hand", middle=0.04, shape=shape))
    parts.append('<link name="tool0"/>')
    links = [*lengths, "hand"]
    axes = ("0 0 1", "0 1 0", "0 1 0", "0 1 0", "0 0 1", "0 1 0")
    for i, (parent, child) in enumerate(pairwise(links)):
        parts.append(
            _JOINT.format(
                name=f"joint_{i + 1}",
                kind="continuous" if i == 4 else "revolute",
                parent=parent,
                child=child,
                xyz=f"0 0 {lengths[parent]}",
                axis=axes[i],
                limit='<limit velocity="3" effort="9"/>' if i == 4 else LIMIT,
            )
        )
    parts.append(
        _JOINT.format(
            name="flange",
            kind="fixed",
            parent="hand",
            child="tool0",
            xyz="0 0 0.08",
            axis="0 0 1",
            limit="",
        )
    )
    return f'<robot name="toy">{"".join(parts)}{gripper}</robot>'


FINGERS = """
  <link name="left_finger"/><link name="right_finger"/>
  <joint name="left_finger_joint" type="prismatic">
    <parent link="hand"/><child link="left_finger"/><axis xyz="0 1 0"/>
    <limit lower="0" upper="0.03" velocity="0.1" effort="9"/>
  </joint>
  <joint name="right_finger_joint" type="prismatic">
    <parent link="hand"/><child link="right_finger"/><axis xyz="0 1 0"/>
    <limit lower="-0.03" upper="0" velocity="0.1" effort="9"/>
    <mimic joint="left_finger_joint" multiplier="-1"/>
  </joint>"""


def write_toy(folder: Path, text: str | None = None) -> Path:
    """Writes the package, and returns the path of its URDF."""
    package = folder / "toy_description"
    (package / "urdf").mkdir(parents=True)
    (package / "meshes").mkdir()
    (package / "package.xml").write_text(PACKAGE)
    hand = trimesh.creation.box((60, 40, 80))
    hand.export(package / "meshes" / "hand.stl")
    urdf = package / "urdf" / "toy.urdf"
    urdf.write_text(toy_urdf(FINGERS) if text is None else text)
    return urdf
