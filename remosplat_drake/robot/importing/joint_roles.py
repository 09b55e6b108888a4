"""Guesses roles of joints from names: arm, gripper, wheel, leg, head.

No file format states the roles of joints, but the joints' names nearly always
do.
"""

import re

from remosplat_drake.robot.importing.urdf import CONTINUOUS, Urdf, UrdfJoint

_FINGERS = re.compile("finger|knuckle|thumb|jaw|claw|pinch")
"""Parts of names that only fingers' joints and links have."""

_HANDS = frozenset(
    {
        "gripper",
        "hand",
        "index",
        "middle",
        "ring",
        "little",
        "pinky",
    }
)
"""Words in names of a hand's joints, unless the name also has a word of
`_WRISTS`."""

_WRISTS = frozenset(
    {
        "wrist",
        "roll",
        "pitch",
        "yaw",
        "rotate",
        "flex",
        "pan",
        "lift",
        "shoulder",
        "elbow",
        "arm",
    }
)
"""Words in names of wrist joints, which carry a hand."""

_WHEELS = re.compile("wheel|caster|suspension")
"""Parts of the names of wheels and their mounts."""

_LEGS = frozenset(
    {
        "hip",
        "knee",
        "ankle",
        "leg",
        "foot",
        "thigh",
        "calf",
        "toe",
        "haa",
        "hfe",
        "kfe",
        "sole",
    }
)
"""Words in names of a leg's joints."""

_HEADS = frozenset(
    {
        "head",
        "neck",
        "eye",
        "eyes",
        "camera",
        "laser",
        "lidar",
        "velodyne",
        "display",
    }
)
"""Words in names of joints that turn a head or a sensor."""

_WORD = re.compile(r"[A-Z]+(?![a-z])|[A-Z]?[a-z]+|\d+")

_LEFT, _RIGHT = "left", "right"

_SIDES = {"left": _LEFT, "l": _LEFT, "right": _RIGHT, "r": _RIGHT}
"""Words for the sides of the body, and the side that each means."""


def words(name: str) -> list[str]:
    """Splits a name into lower-case words: `LHipYaw` and `l_hip_yaw` alike.

    Args:
        name: The name of a link or a joint.
    """
    return [word.lower() for word in _WORD.findall(name)]


def is_wheel(joint: UrdfJoint) -> bool:
    """Returns whether a joint turns or steers a wheel, or is its suspension."""
    return bool(_WHEELS.search(joint.name.lower()))


def has_wheels(urdf: Urdf) -> bool:
    """Returns whether a robot has at least two joints that turn wheels."""
    joints = urdf.joints.values()
    return sum(j.kind == CONTINUOUS and is_wheel(j) for j in joints) >= 2


def is_finger(urdf: Urdf, joint: UrdfJoint) -> bool:
    """Returns whether a joint opens or closes a hand.

    If a joint follows another joint on the same link, both are fingers,
    regardless of their names.

    Args:
        urdf: The robot.
        joint: One of its joints.
    """
    if _FINGERS.search(joint.name.lower()) or _FINGERS.search(
        joint.child.lower()
    ):
        return True
    said = set(words(joint.name))
    if said & _HANDS and not said & _WRISTS:
        return True
    pairs = (
        other
        for other in urdf.joints.values()
        if other.parent == joint.parent and other is not joint
    )
    return any(
        joint.mimics == other.name or other.mimics == joint.name
        for other in pairs
    )


def is_of_arm(urdf: Urdf, joint: UrdfJoint) -> bool:
    """Returns whether a joint may belong to an arm or its carrier.

    Args:
        urdf: The robot.
        joint: One of its joints.
    """
    said = set(words(joint.name))
    other = said & (_LEGS | _HEADS) or is_wheel(joint)
    return joint.moves and not other and not is_finger(urdf, joint)


def side_names(names: list[str]) -> list[str]:
    """Returns short distinct names for several hands: left and right, arm_1.

    Args:
        names: For each hand, the name of its link, or names of link and joints.
    """
    split = [words(name) for name in names]
    sides = [[_SIDES[w] for w in some if w in _SIDES] for some in split]
    found = [some[0] if some else "" for some in sides]
    if all(found) and len(set(found)) == len(found):
        return found
    shared = set.intersection(*map(set, split))
    own = [[word for word in some if word not in shared] for some in split]
    called = ["_".join(dict.fromkeys(some)) for some in own]
    called = [f"arm_{x}" if x.isdigit() else x for x in called]
    if all(called) and len(set(called)) == len(called):
        return called
    return [f"arm_{i + 1}" for i in range(len(names))]
