"""Removes planar bases that a robot's file models as joints.

Some files move the robot over the floor by joints at its root: prismatic joints
along x and y and a revolute one, or a revolute, a prismatic and another
revolute one. These model a mobile base, and do not belong to the arm.
"""

from xml.etree.ElementTree import tostring

import numpy as np
from pydrake.math import RigidTransform

from remosplat_drake.robot.importing.findings import Findings, listed
from remosplat_drake.robot.importing.mobile_base import ROAM
from remosplat_drake.robot.importing.urdf import (
    FIXED,
    PRISMATIC,
    Urdf,
    UrdfJoint,
)
from remosplat_drake.robot.importing.urdf_elements import origin_pose

_ALONG = 1e-3
"""Largest component of an axis that counts as zero."""


def without_planar_base(urdf: Urdf, findings: Findings) -> Urdf | None:
    """Fixes the joints that model a robot's planar base.

    Args:
        urdf: The robot, whose document is changed.
        findings: Receives the joints' names.

    Returns:
        The robot without these joints; None if it has none.
    """
    joints = _planar_joints(urdf)
    if joints is None:
        return None
    for joint in joints:
        joint.element.set("type", FIXED)
        for tag in ("axis", "limit"):
            for element in joint.element.findall(tag):
                joint.element.remove(element)
    names = listed([joint.name for joint in joints])
    findings.guess("base", f"omni, as {names} move it in the plane")
    text = tostring(urdf.root, encoding="unicode")
    return Urdf(urdf.path, text, urdf.dialect, urdf.loops)


def _planar_joints(urdf: Urdf) -> list[UrdfJoint] | None:
    """Returns the first three joints of a robot if they form a planar base.

    Prismatic joints are horizontal, with the range of a base; revolute joints
    are vertical.
    """
    link, X_WL, found = urdf.base, RigidTransform(), []
    while len(found) < 3:
        ahead = urdf.outboard(link)
        if len(ahead) != 1:
            return None
        joint = ahead[0]
        X_WL = X_WL @ origin_pose(joint.element)
        if joint.kind != FIXED:
            if not joint.moves or not _is_planar(joint, X_WL):
                return None
            found.append(joint)
        link = joint.child
    slides = sum(joint.kind == PRISMATIC for joint in found)
    return found if slides in (1, 2) else None


def _is_planar(joint: UrdfJoint, X_WJ: RigidTransform) -> bool:
    element = joint.element.find("axis")
    text = "1 0 0" if element is None else element.get("xyz", "1 0 0")
    axis = X_WJ.rotation() @ np.array([float(x) for x in text.split()])
    up = abs(axis[2]) / np.linalg.norm(axis)
    if joint.kind != PRISMATIC:
        return up > 1 - _ALONG
    roams = joint.lower <= -ROAM and joint.upper >= ROAM
    return up < _ALONG and roams
