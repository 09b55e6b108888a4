"""Removes planar bases that a robot's file models as joints.

In some files, joints at the robot's root move it over the floor. They are
prismatic joints along x and y and a revolute joint; or a revolute, a prismatic
and another revolute joint. These joints model a mobile base, and do not belong
to the arm.
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
"""A component of an axis counts as zero if its size is at most this."""


def without_planar_base(urdf: Urdf, findings: Findings) -> Urdf | None:
    """Removes the joints that model a robot's planar base.

    If the joints' links are only frames at the same place, these links are
    removed, too. Otherwise the joints are fixed.

    Args:
        urdf: The robot, whose document is changed.
        findings: Receives the joints' names.

    Returns:
        The robot without these joints; None if it has none.
    """
    chain = _planar_chain(urdf)
    if chain is None:
        return None
    joints = [joint for joint in chain if joint.kind != FIXED]
    if all(_is_frame(urdf, joint) for joint in chain):
        for joint in chain:
            urdf.root.remove(urdf.links[joint.parent])
            urdf.root.remove(joint.element)
    for joint in joints:
        joint.element.set("type", FIXED)
        for tag in ("axis", "limit"):
            for element in joint.element.findall(tag):
                joint.element.remove(element)
    names = listed([joint.name for joint in joints])
    findings.guess("base", f"omni, as {names} move it in the plane")
    text = tostring(urdf.root, encoding="unicode")
    return Urdf(urdf.path, text, urdf.dialect, urdf.loops)


def _is_frame(urdf: Urdf, joint: UrdfJoint) -> bool:
    """Whether a joint's parent has no parts, and is at the child's pose."""
    at_child = origin_pose(joint.element).IsNearlyIdentity(0.0)
    return at_child and not len(urdf.links[joint.parent])


def _planar_chain(urdf: Urdf) -> list[UrdfJoint] | None:
    """Returns a robot's joints up to the third that moves, if that is a base.

    Prismatic joints are horizontal, with the range of a base or without
    limits; revolute joints are vertical.
    """
    link, X_WL, chain, found = urdf.base, RigidTransform(), [], []
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
        chain.append(joint)
        link = joint.child
    slides = sum(joint.kind == PRISMATIC for joint in found)
    return chain if slides in (1, 2) else None


def _is_planar(joint: UrdfJoint, X_WJ: RigidTransform) -> bool:
    element = joint.element.find("axis")
    text = "1 0 0" if element is None else element.get("xyz", "1 0 0")
    axis = X_WJ.rotation() @ np.array([float(x) for x in text.split()])
    up = abs(axis[2]) / np.linalg.norm(axis)
    if joint.kind != PRISMATIC:
        return up > 1 - _ALONG
    # A missing limit is nan, which does not limit the range.
    is_bounded = joint.lower > -ROAM or joint.upper < ROAM
    return up < _ALONG and not is_bounded
