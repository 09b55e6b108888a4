"""Which joints are the arm's, and which frame leads: read, or guessed."""

import dataclasses as dc
import math
import re

from remosplat_drake.base.errors import unknown_name
from remosplat_drake.robot.importing.findings import Findings, listed
from remosplat_drake.robot.importing.srdf import Srdf
from remosplat_drake.robot.importing.urdf import (
    CONTINUOUS,
    FIXED,
    PRISMATIC,
    REVOLUTE,
    Urdf,
    UrdfJoint,
)

TOOLS = (
    r"(.*_)?tcp",
    r"(.*_)?tool0",
    r"(.*_)?grasping_frame",
    r"(.*_)?(ee|eef|end_effector)(_?link|_?frame|_?site)?",
    r"(.*_)?tool(_?link|_?frame)?",
    r"(.*_)?(gripper|grasp|hand)_?(frame|center|centre)(_?link)?",
    r"(.*_)?(attachment|grip|grasp|pinch)_?site",
)
"""What frames at a tool are called, the likeliest first."""

_FINGER = re.compile(
    r"finger|gripper|jaw|knuckle|thumb|claw|pinch|"
    r"(^|_)(index|middle|ring|little|pinky)(_|$)"
)
_WHEEL = re.compile(r"wheel|caster")


@dc.dataclass(frozen=True)
class ArmChoice:
    """What of a robot is driven.

    Attributes:
        end_effector: Name of the link whose frame is driven to targets.
        joints: The arm's joints, the inmost first.
        locked: Positions at which all other moving joints stay, by name [rad,
            m].
    """

    end_effector: str
    joints: tuple[UrdfJoint, ...]
    locked: dict[str, float]


def choose_arm(
    urdf: Urdf, srdf: Srdf, wanted: str | None, findings: Findings
) -> ArmChoice:
    """Chooses the end effector, and with it the joints of the arm.

    Args:
        urdf: The robot.
        srdf: What its SRDF says; may be empty.
        wanted: Name of the end effector's frame; None guesses it.
        findings: Where choices are noted.

    Raises:
        FieldError: There is no such frame, no joint moves it, or joints of
            the arm carry others with them.
    """
    tip = wanted or _guessed_tip(urdf, srdf, findings)
    if tip not in urdf.links:
        problem = unknown_name("link", tip, urdf.links)
        raise urdf.fail("--end-effector", problem)
    joints = tuple(joint for joint in urdf.chain(tip) if joint.moves)
    if not joints:
        problem = "is moved by no joint; name another one with --end-effector"
        raise urdf.fail(f"link {tip!r}", problem)
    for joint in urdf.joints.values():
        if joint.mimics:
            _check_follower(urdf, joint, joints)
    _check_loops(urdf, joints, findings)
    findings.find(
        "arm", f"{len(joints)} joints: {listed([j.name for j in joints], 8)}"
    )
    return ArmChoice(tip, joints, _locked(urdf, joints, findings))


def has_wheels(urdf: Urdf) -> bool:
    """Tells whether a robot has at least two joints that look like wheels'."""
    return (
        sum(
            joint.kind == CONTINUOUS and bool(_WHEEL.search(joint.name.lower()))
            for joint in urdf.joints.values()
        )
        >= 2
    )


def is_wheel(joint: UrdfJoint) -> bool:
    """Tells whether a joint turns or steers a wheel, by its name."""
    return bool(_WHEEL.search(joint.name.lower()))


def _is_finger(joint: UrdfJoint) -> bool:
    names = joint.name.lower(), joint.child.lower()
    return any(_FINGER.search(name) for name in names)


def _before_fingers(urdf: Urdf, link: str) -> str:
    """The link that carries the fingers, where a chain goes on through one."""
    for joint in urdf.chain(link):
        if joint.moves and _is_finger(joint):
            return joint.parent
    return link


def _guessed_tip(urdf: Urdf, srdf: Srdf, findings: Findings) -> str:
    tips = {_before_fingers(urdf, tip) for tip in srdf.tips}
    if len(tips) == 1:
        (tip,) = tips
        findings.find("end effector", f"{tip} (SRDF)")
        return tip

    def drives(link: str) -> int:
        chain = urdf.chain(link)
        if any(_is_finger(joint) and joint.moves for joint in chain):
            return 0
        return sum(joint.moves and not is_wheel(joint) for joint in chain)

    most = max(map(drives, urdf.links))
    ends = [link for link in urdf.links if drives(link) == most]
    for pattern in TOOLS:
        for link in ends:
            if re.fullmatch(pattern, link.lower()):
                findings.guess(
                    "end effector",
                    f"{link}, by its name; --end-effector names another",
                )
                return link
    # The last link that moves: further ones are fixed to it.
    moved = [joint.child for joint in urdf.chain(ends[-1]) if joint.moves]
    tip = moved[-1] if moved else ends[0]
    findings.guess(
        "end effector",
        f"{tip}, the last link that moves; --end-effector names another",
    )
    return tip


def _check_follower(
    urdf: Urdf, joint: UrdfJoint, arm: tuple[UrdfJoint, ...]
) -> None:
    """Refuses joints that move whenever a joint of the arm does."""
    leader, seen = joint, {joint.name}
    mimic = urdf.dialect.mimic
    while leader.mimics:
        leader = urdf.joints[leader.mimics]
        if leader.name in seen:
            problem = f"follows itself; remove a {mimic}"
            raise urdf.fail(f"joint {joint.name!r} {mimic}", problem)
        seen.add(leader.name)
    if leader in arm:
        raise urdf.fail(
            f"joint {joint.name!r} {mimic}",
            f"follows {leader.name!r}, which the arm commands; coupled joints"
            f" cannot be driven: remove the {mimic} or {urdf.dialect.fixed}",
        )


def _check_loops(
    urdf: Urdf, arm: tuple[UrdfJoint, ...], findings: Findings
) -> None:
    """Refuses loops that a joint of the arm would move; others stay open."""
    for loop in urdf.loops:
        between = set(urdf.chain(loop.first)) ^ set(urdf.chain(loop.second))
        moved = [joint.name for joint in arm if joint in between]
        if moved:
            raise urdf.fail(
                loop.where,
                f"closes a loop in which {moved[0]!r} is, which the arm"
                " commands; loops cannot be driven: remove it",
            )
    if urdf.loops:
        findings.guess(
            "loops that are left open, as their joints stay",
            listed([f"{loop.first}-{loop.second}" for loop in urdf.loops], 3),
        )


def _locked(
    urdf: Urdf, arm: tuple[UrdfJoint, ...], findings: Findings
) -> dict[str, float]:
    """Positions at which all joints stay that are not the arm's."""
    locked: dict[str, float] = {}
    opened = []
    for joint in urdf.joints.values():
        if joint.moves and joint not in arm:
            lower, upper = (
                0.0 if math.isnan(limit) else limit
                for limit in (joint.lower, joint.upper)
            )
            locked[joint.name] = 0.0
            if joint.kind == PRISMATIC and _is_finger(joint):
                locked[joint.name] = upper
                opened.append(joint.name)
            elif joint.kind == REVOLUTE and lower < upper:
                locked[joint.name] = min(max(0.0, lower), upper)
    for joint in urdf.joints.values():
        if joint.mimics and joint.kind != FIXED:
            locked[joint.name] = _followed(urdf, joint, locked)
    still = [name for name in locked if name not in opened]
    if still:
        findings.guess("joints that stay at zero", listed(still))
    if opened:
        findings.guess("fingers that stay open", listed(opened))
    return locked


def _followed(urdf: Urdf, joint: UrdfJoint, locked: dict[str, float]) -> float:
    leader = urdf.joints[joint.mimics]
    position = locked.get(leader.name)
    if position is None:
        position = _followed(urdf, leader, locked) if leader.mimics else 0.0
    return joint.multiplier * position + joint.offset
