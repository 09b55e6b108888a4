"""Finds the arms of a robot, and the tool frame of each.

The tool is found by the SRDF's groups, by its name, or else as the point where
the fingers meet.
"""

import dataclasses as dc
import re
from collections.abc import Iterable, Iterator

import numpy as np
from pydrake.math import RigidTransform

from remosplat_drake.robot.importing.findings import listed
from remosplat_drake.robot.importing.joint_roles import is_finger, is_of_arm
from remosplat_drake.robot.importing.srdf import Srdf
from remosplat_drake.robot.importing.urdf import FIXED, Urdf, UrdfJoint
from remosplat_drake.robot.importing.urdf_elements import origin_pose

TOOLS = (
    r"(.*_)?tcp(_?link|_?frame)?",
    r"(.*_)?tool0",
    r"(.*_)?grasp(ing)?_?(frame|target|point|link)",
    r"(.*_)?(ee|eef|end_?effector)(_?gripper)?(_?link|_?frame|_?site)?",
    r"(.*_)?(gripper|hand)_?(frame|center|centre|tip|tool)(_?link|_?frame)?",
    r"(.*_)?(attachment|grip|grasp|pinch)_?site",
    r"(.*_)?tool(_?link|_?frame)?",
    r"(.*_)?(gripper|hand|palm)(_?link)?",
    r"(.*_)?flange(_?link)?",
)
"""Usual names of tool frames, the likeliest first."""

_SAME_PLACE = 1e-3
"""Frames count as one tool if their origins are at most this far apart [m]."""

_ARM_SHARE = 0.6
"""In an SRDF, a chain is an arm if it has at least this fraction of the longest
chain's number of joints. Shorter chains belong to a torso, a sensor or a wheel.
"""


@dc.dataclass(frozen=True)
class Tool:
    """The frame of an arm that the controller drives to targets.

    Attributes:
        link: Name of the link whose frame it is.
        why: Reason why this frame was chosen.
        is_said: Whether a file states it; otherwise it was guessed.
    """

    link: str
    why: str
    is_said: bool


def find_tools(urdf: Urdf, srdf: Srdf) -> list[Tool]:
    """Finds the tool of each arm. The arms are the one or two longest chains.

    Args:
        urdf: The robot.
        srdf: Content of its SRDF; may be empty.

    Raises:
        FieldError: More than two chains of joints may be the arm, or two
            distant frames of an arm have names of tools.
    """
    ends = _said_ends(urdf, srdf) or _longest_ends(urdf)
    if len(ends) > 2:
        raise urdf.fail(
            "--end-effector",
            f"is needed, once for each arm: {len(ends)} chains are equally "
            f"long; they end at {listed([end.child for end in ends])}",
        )
    if not ends:
        return [Tool(urdf.base, "nothing moves", False)]
    return [_tool(urdf, srdf, end) for end in ends]


def before_fingers(urdf: Urdf, link: str) -> str:
    """Returns the link that carries the fingers, given a finger's link.

    Args:
        urdf: The robot.
        link: Name of a link; it is returned if no finger carries it.
    """
    for joint in urdf.chain(link):
        if joint.moves and is_finger(urdf, joint):
            return joint.parent
    return link


def _arm_joints(urdf: Urdf, link: str) -> list[UrdfJoint]:
    """Returns the joints from the base to a link; empty if not of an arm."""
    moving = [joint for joint in urdf.chain(link) if joint.moves]
    return moving if all(is_of_arm(urdf, joint) for joint in moving) else []


def _longest_ends(urdf: Urdf) -> list[UrdfJoint]:
    """Returns the last joints of the chains with the most joints."""
    ends: dict[str, tuple[UrdfJoint, int]] = {}
    for link in urdf.links:
        joints = _arm_joints(urdf, link)
        if joints:
            ends[joints[-1].name] = joints[-1], len(joints)
    most = max((count for _, count in ends.values()), default=0)
    return [joint for joint, count in ends.values() if count == most]


def _said_ends(urdf: Urdf, srdf: Srdf) -> list[UrdfJoint]:
    """Returns the last joints of the arms that an SRDF names."""
    named = [*srdf.tips, *srdf.tools]
    chains = [_arm_joints(urdf, before_fingers(urdf, tip)) for tip in named]
    longest = [len(_arm_joints(urdf, end.child)) for end in _longest_ends(urdf)]
    least = _ARM_SHARE * max(longest, default=0)
    ends = {c[-1].name: c for c in chains if c and len(c) >= least}
    return [
        chain[-1]
        for name, chain in ends.items()
        # A chain that another chain extends is a part of that chain.
        if not any(chain[-1] in other[:-1] for other in ends.values())
    ]


def _tool(urdf: Urdf, srdf: Srdf, end: UrdfJoint) -> Tool:
    """Returns the tool among the frames fixed to an arm's last joint."""
    frames = _rigid(urdf, end.child)
    groups = [
        link
        for parent, links in srdf.tools.items()
        if parent in frames
        for link in links
        if link in frames
    ]
    fingers = [
        joint
        for frame in frames
        for joint in urdf.outboard(frame)
        if joint.kind != FIXED and is_finger(urdf, joint)
    ]
    p_meet = _meeting_point(urdf, frames, fingers)
    if groups:
        link = _by_name(urdf, frames, groups, p_meet)
        palms = [joint.parent for joint in fingers if joint.parent in groups]
        return Tool(link or [*palms, *groups][0], "the SRDF's gripper", True)
    tips = [before_fingers(urdf, tip) for tip in [*srdf.tips, *srdf.tools]]
    tips = [tip for tip in tips if tip in frames]
    further = [tip for tip in tips if tip != end.child]
    if further:
        return Tool(further[0], "the SRDF's tip", True)
    link = _by_name(urdf, frames, frames, p_meet)
    if link:
        return Tool(link, "by its name", False)
    if fingers:
        return Tool(fingers[0].parent, "which carries the fingers", False)
    if tips:
        return Tool(tips[0], "the SRDF's tip", True)
    return Tool(end.child, "the last link that moves", False)


def _by_name(
    urdf: Urdf,
    frames: dict[str, RigidTransform],
    among: Iterable[str],
    p_meet: np.ndarray | None,
) -> str | None:
    """Returns the frame with the likeliest name.

    If several frames have such a name, frames that carry another such frame are
    ignored. The result is the remaining frame that is nearest to the fingers'
    meeting point.
    """
    for pattern in TOOLS:
        fits = [link for link in among if re.fullmatch(pattern, _plain(link))]
        if not fits:
            continue
        inner = {joint.parent for x in fits for joint in urdf.chain(x)}
        fits = sorted((x for x in fits if x not in inner), key=len)
        p = {link: frames[link].translation() for link in fits}
        if p_meet is not None:
            return min(fits, key=lambda link: _apart(p[link], p_meet))
        others = [x for x in fits if _apart(p[x], p[fits[0]]) > _SAME_PLACE]
        if others:
            raise urdf.fail(
                "--end-effector",
                f"is needed: {fits[0]} and {others[0]} both have the name of "
                "a tool, and are "
                f"{1e3 * _apart(p[fits[0]], p[others[0]]):.0f} mm apart",
            )
        return fits[0]
    return None


def _plain(link: str) -> str:
    """A link's name in lower case, without its namespace."""
    return re.split(r"[/:]", link)[-1].lower()


def _apart(p: np.ndarray, other: np.ndarray) -> float:
    return float(np.linalg.norm(p - other))


def _rigid(urdf: Urdf, link: str) -> dict[str, RigidTransform]:
    """Returns the poses, in a link, of all links fixed to it, itself first."""
    frames = {link: RigidTransform()}
    for carrier in _in_order(urdf, link):
        for joint in urdf.outboard(carrier):
            if joint.kind == FIXED:
                frames[joint.child] = frames[carrier] @ origin_pose(
                    joint.element
                )
    return frames


def _in_order(urdf: Urdf, link: str) -> Iterator[str]:
    """Returns a link and all links fixed to it, each after its parent."""
    yield link
    for joint in urdf.outboard(link):
        if joint.kind == FIXED:
            yield from _in_order(urdf, joint.child)


def _meeting_point(
    urdf: Urdf, frames: dict[str, RigidTransform], fingers: list[UrdfJoint]
) -> np.ndarray | None:
    """Returns the mean of the fingers' last origins, in the arm's last link."""
    tips = []
    for joint in fingers:
        X, link = frames[joint.parent] @ origin_pose(joint.element), joint.child
        while ahead := urdf.outboard(link):
            X, link = X @ origin_pose(ahead[0].element), ahead[0].child
        tips.append(X.translation())
    return np.mean(tips, axis=0) if tips else None
