"""Adds a mobile base as three joints between world and base link."""

from xml.etree.ElementTree import Element, SubElement

import numpy as np

from remosplat_drake.robot import robot_description
from remosplat_drake.robot.importing.completion import JointLimits
from remosplat_drake.robot.importing.findings import Findings
from remosplat_drake.robot.importing.urdf import Urdf

FIXED, DIFFERENTIAL, OMNI = "fixed", "differential", "omni"
BASES = (FIXED, DIFFERENTIAL, OMNI)
"""Valid kinds of a robot's base."""

DRIVES = {
    DIFFERENTIAL: robot_description.DIFFERENTIAL,
    OMNI: robot_description.OMNIDIRECTIONAL,
}
"""Name of the drive in a robot description, for each kind of mobile base."""

JOINTS = ("base_x", "base_y", "base_yaw")
"""Names of the joints of a mobile base."""

SPEED, YAW_RATE = 0.5, 0.8
"""Assumed speed limits of a base [m/s, rad/s]."""

ACCELERATION, YAW_ACCELERATION = 0.5, 1.5
"""Assumed acceleration limits of a base [m/s^2, rad/s^2]."""

EFFORT = 400.0
"""Assumed effort limits of a base's motors [N, N m]."""

ROAM = 20.0
"""In the model, x and y of a base may differ from the start by this much [m].
"""


def base_limits(base: str, findings: Findings) -> list[JointLimits]:
    """Guesses the limits of a base's commands.

    Args:
        base: One of `BASES`.
        findings: Receives the guess.

    Returns:
        Limits of the base's commands in the order of u: forward speed, speed to
        the left (omnidirectional only) and yaw rate; empty for a fixed base.
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
    """Adds a mobile base's joints between the world and the base link.

    Args:
        urdf: The robot; its document is changed. If the base link is named
            `world`, the joints move the link that it carries.
        base: `DIFFERENTIAL` or `OMNI`.
        height: Height of the robot's base link above the floor [m].

    Returns:
        Name of the link that the base's joints move.

    Raises:
        FieldError: A link named `world` carries several links, or a link that
            can move; or a name already exists.
    """
    carried, origin = urdf.base, None
    if carried == "world":
        joints = urdf.outboard("world")
        if len(joints) != 1 or joints[0].moves:
            raise urdf.fail(
                "link 'world'",
                "must carry exactly one link, by a fixed joint: the base moves"
                " that link",
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
    """Returns an <origin> that is raised by the base link's height."""
    xyz = [0.0, 0.0, 0.0]
    element = Element("origin", {} if origin is None else dict(origin.attrib))
    if "xyz" in element.attrib:
        xyz = [float(x) for x in element.attrib["xyz"].split()]
    xyz[2] += height
    element.set("xyz", " ".join(f"{x:.6g}" for x in xyz))
    return element
