"""A mobile base as three joints between the world and a URDF's base link."""

from xml.etree.ElementTree import Element, SubElement

import numpy as np

from remosplat_drake.robot import robot_description
from remosplat_drake.robot.importing.completion import JointLimits
from remosplat_drake.robot.importing.findings import Findings
from remosplat_drake.robot.importing.urdf import Urdf

FIXED, DIFFERENTIAL, OMNI = "fixed", "differential", "omni"
BASES = (FIXED, DIFFERENTIAL, OMNI)
"""Choices of how a robot moves about."""

DRIVES = {
    DIFFERENTIAL: robot_description.DIFFERENTIAL,
    OMNI: robot_description.OMNIDIRECTIONAL,
}
"""Names of the drives in descriptions, by kind of mobile base."""

JOINTS = ("base_x", "base_y", "base_yaw")
"""Names of the joints of a mobile base."""

SPEED, YAW_RATE = 0.5, 0.8
"""Speeds that are taken for a base's limits [m/s, rad/s]."""

ACCELERATION, YAW_ACCELERATION = 0.5, 1.5
"""Assumed rates of their change [m/s^2, rad/s^2]."""

EFFORT = 400.0
"""Assumed efforts of its motors [N, N m]."""

ROAM = 20.0
"""How far the model has a base drive from where it started [m]."""


def base_limits(base: str, findings: Findings) -> list[JointLimits]:
    """Guesses the limits of a base's commands.

    Args:
        base: One of `BASES`.
        findings: Where the guess is noted.

    Returns:
        Those of the forward speed and the yaw rate of a differential base, with
        that to the left between them of an omnidirectional one, none of a fixed
        one.
    """
    if base == FIXED:
        return []
    findings.guess(
        "base",
        f"{SPEED:g} m/s and {YAW_RATE:g} rad/s, {ACCELERATION:g} m/s^2"
        f" and {YAW_ACCELERATION:g} rad/s^2; no model contains them",
    )
    drive = JointLimits(-ROAM, ROAM, SPEED, ACCELERATION, EFFORT)
    turn = JointLimits(
        -8 * np.pi, 8 * np.pi, YAW_RATE, YAW_ACCELERATION, EFFORT
    )
    return [drive, turn] if base == DIFFERENTIAL else [drive, drive, turn]


def add_base_joints(urdf: Urdf, base: str, height: float) -> str:
    """Puts a mobile base's joints before a robot's base link.

    Args:
        urdf: The robot; its document is changed. Where its base link is called
            `world`, what that carries is moved.
        base: `DIFFERENTIAL` or `OMNI`.
        height: Height of the robot's base link above the floor [m].

    Returns:
        Name of the link that drives.

    Raises:
        FieldError: The world carries several links, or one that can move, or
            a name is taken.
    """
    carried, origin = urdf.base, None
    if carried == "world":
        joints = urdf.outboard("world")
        if len(joints) != 1 or joints[0].moves:
            raise urdf.fail(
                "link 'world'",
                "carries more than one fixed link; a base needs one to drive",
            )
        carried, origin = joints[0].child, joints[0].element.find("origin")
        urdf.root.remove(joints[0].element)
        urdf.root.remove(urdf.links["world"])
    links = ("base_origin", "base_x_slide", "base_y_slide")
    for name in (*links, *JOINTS):
        if name in urdf.links or name in urdf.joints:
            raise urdf.fail(f"name {name!r}", "is taken; rename it")
    for name in links:
        SubElement(urdf.root, "link", name=name)
    children = (*links[1:], carried)
    axes = ("1 0 0", "0 1 0", "0 0 1")
    for name, parent, child, axis in zip(
        JOINTS, links, children, axes, strict=True
    ):
        slides = name != "base_yaw"
        kind = "prismatic" if slides else "revolute"
        joint = SubElement(urdf.root, "joint", name=name, type=kind)
        SubElement(joint, "parent", link=parent)
        SubElement(joint, "child", link=child)
        SubElement(joint, "axis", xyz=axis)
        if not slides:
            joint.append(_raised(origin, height))
        reach = ROAM if slides else 8 * np.pi
        SubElement(
            joint,
            "limit",
            lower=f"{-reach:.6g}",
            upper=f"{reach:.6g}",
            velocity=f"{SPEED if slides else YAW_RATE:g}",
            effort=f"{EFFORT:g}",
        )
    return carried


def _raised(origin: Element | None, height: float) -> Element:
    """An <origin> that is higher by what the base link lies above the floor."""
    xyz = [0.0, 0.0, 0.0]
    element = Element("origin", {} if origin is None else dict(origin.attrib))
    if "xyz" in element.attrib:
        xyz = [float(x) for x in element.attrib["xyz"].split()]
    xyz[2] += height
    element.set("xyz", " ".join(f"{x:.6g}" for x in xyz))
    return element
