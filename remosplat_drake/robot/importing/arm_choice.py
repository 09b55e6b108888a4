"""Chooses the arm's joints and end effectors, as stated or guessed."""

import dataclasses as dc
import math
from collections.abc import Mapping

from remosplat_drake.base.errors import unknown_name
from remosplat_drake.robot.importing.findings import Findings, listed
from remosplat_drake.robot.importing.joint_roles import is_finger, side_names
from remosplat_drake.robot.importing.srdf import Srdf
from remosplat_drake.robot.importing.tools import Tool, find_tools
from remosplat_drake.robot.importing.urdf import (
    FIXED,
    PRISMATIC,
    REVOLUTE,
    Urdf,
    UrdfJoint,
)


@dc.dataclass(frozen=True)
class ArmChoice:
    """The part of a robot that the controller drives.

    Attributes:
        end_effectors: Names of the links whose frames are driven to targets,
            keyed by the names of the end effectors. If there is only one end
            effector, its name is empty.
        joints: The arms' joints, each after the joints that carry it.
        locked: Constant positions of all other moving joints, by name [rad, m].
    """

    end_effectors: dict[str, str]
    joints: tuple[UrdfJoint, ...]
    locked: dict[str, float]


def choose_arm(
    urdf: Urdf, srdf: Srdf, wanted: Mapping[str, str], findings: Findings
) -> ArmChoice:
    """Chooses the end effectors, which determine the joints of the arms.

    Args:
        urdf: The robot.
        srdf: Content of its SRDF; may be empty.
        wanted: Names of the end effectors' links, by the end effectors' names;
            empty: they are found in the SRDF or guessed.
        findings: Receives the choices.

    Raises:
        FieldError: There is no such link, no joint moves it, other joints
            follow joints of the arm, or several frames are equally good.
    """
    tips = dict(wanted) or _found_tips(urdf, srdf, findings)
    joints: dict[str, UrdfJoint] = {}
    for tip in tips.values():
        if tip not in urdf.links:
            problem = unknown_name("link", tip, urdf.links)
            raise urdf.fail("--end-effector", problem)
        moving = [joint for joint in urdf.chain(tip) if joint.moves]
        if not moving:
            raise urdf.fail(
                f"link {tip!r}",
                f"is not moved by any joint: it is fixed to {urdf.base!r}; "
                "name another one with --end-effector",
            )
        joints |= {joint.name: joint for joint in moving}
    arm = tuple(joints.values())
    for joint in urdf.joints.values():
        if joint.mimics:
            _check_follower(urdf, joint, arm)
    _check_loops(urdf, arm, findings)
    findings.find(
        "arm" if len(tips) == 1 else "arms",
        f"{len(arm)} joints: {listed(list(joints), 8)}",
    )
    return ArmChoice(tips, arm, _locked(urdf, srdf, arm, findings))


def _found_tips(urdf: Urdf, srdf: Srdf, findings: Findings) -> dict[str, str]:
    tools = find_tools(urdf, srdf)
    links = [tool.link for tool in tools]
    names = [""]
    if len(tools) > 1:
        moved_by = [
            [joint.name for joint in urdf.chain(link) if joint.moves][-1]
            for link in links
        ]
        pairs = zip(moved_by, links, strict=True)
        names = side_names([" ".join(pair) for pair in pairs])
    for name, tool in zip(names, tools, strict=True):
        _note(name, tool, findings)
    return dict(zip(names, links, strict=True))


def _note(name: str, tool: Tool, findings: Findings) -> None:
    what = f"end effector {name}".rstrip()
    if tool.is_said:
        findings.find(what, f"{tool.link}, {tool.why}")
    else:
        findings.guess(
            what, f"{tool.link}, {tool.why}; --end-effector names another"
        )


def _check_follower(
    urdf: Urdf, joint: UrdfJoint, arm: tuple[UrdfJoint, ...]
) -> None:
    """Raises an error if another joint follows a joint of the arm."""
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
    """Raises an error for loops that the arm moves; other loops stay open."""
    for loop in urdf.loops:
        between = set(urdf.chain(loop.first)) ^ set(urdf.chain(loop.second))
        moved = [joint.name for joint in arm if joint in between]
        if moved:
            raise urdf.fail(
                loop.where,
                f"closes a loop that contains {moved[0]!r}, a joint of the arm;"
                " such loops cannot be driven: remove this element",
            )
    if urdf.loops:
        findings.guess(
            "loops left open, since their joints do not move",
            listed([f"{loop.first}-{loop.second}" for loop in urdf.loops], 3),
        )


def _locked(
    urdf: Urdf, srdf: Srdf, arm: tuple[UrdfJoint, ...], findings: Findings
) -> dict[str, float]:
    """Returns the constant positions of all joints that are not the arm's.

    They are the positions of the likeliest named state, or else zero. Prismatic
    fingers are open.
    """
    locked: dict[str, float] = {}
    opened, named = [], []
    name, positions = next(iter(srdf.homes()), ("", {}))
    for joint in urdf.joints.values():
        if joint.moves and joint not in arm:
            lower, upper = (
                0.0 if math.isnan(limit) else limit
                for limit in (joint.lower, joint.upper)
            )
            locked[joint.name] = positions.get(joint.name, 0.0)
            if joint.kind == PRISMATIC and is_finger(urdf, joint):
                locked[joint.name] = upper
                opened.append(joint.name)
                continue
            if joint.kind == REVOLUTE and lower < upper:
                held = min(max(locked[joint.name], lower), upper)
                locked[joint.name] = held
            if positions.get(joint.name):
                named.append(joint.name)
    for joint in urdf.joints.values():
        if joint.mimics and joint.kind != FIXED:
            locked[joint.name] = _followed(urdf, joint, locked)
    still = [x for x in locked if x not in (*opened, *named)]
    if still:
        findings.guess("joints that stay at zero", listed(still))
    if named:
        findings.guess(f"joints that stay as in {name!r}", listed(named))
    if opened:
        findings.guess("fingers that stay open", listed(opened))
    return locked


def _followed(urdf: Urdf, joint: UrdfJoint, locked: dict[str, float]) -> float:
    leader = urdf.joints[joint.mimics]
    position = locked.get(leader.name)
    if position is None:
        position = _followed(urdf, leader, locked) if leader.mimics else 0.0
    return joint.multiplier * position + joint.offset
