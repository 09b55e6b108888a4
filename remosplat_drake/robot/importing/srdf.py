"""`Srdf`: a robot's groups and states, as MoveIt's assistant writes them."""

import dataclasses as dc
import math
from pathlib import Path
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

from remosplat_drake.base.errors import FieldError, FileError
from remosplat_drake.robot.importing.urdf import Urdf

HOMES = (
    "home",
    "ready",
    "rest",
    "default",
    "neutral",
    "nominal",
    "up",
    "sitting",
    "standing",
    "init",
)
"""Names of states that are suitable as home, the likeliest first."""

PACKED = ("stow", "tuck", "fold", "park", "transport", "zero")
"""Names of states that are not suitable as home."""


@dc.dataclass(frozen=True)
class Srdf:
    """The relevant content of an SRDF.

    Attributes:
        tips: Last link of each chain in the groups of the SRDF.
        tools: Links of each end effector's group, keyed by the link that
            carries them; empty if the group is the arm.
        is_planar: Whether the robot moves in the plane, also sideways.
        states: Positions of joints by name, for each named state [rad, m].
        allowed_collisions: Pairs of links that may touch, each sorted.
    """

    tips: tuple[str, ...] = ()
    tools: dict[str, tuple[str, ...]] = dc.field(default_factory=dict)
    is_planar: bool = False
    states: dict[str, dict[str, float]] = dc.field(default_factory=dict)
    allowed_collisions: tuple[tuple[str, str], ...] = ()

    def homes(self) -> list[tuple[str, dict[str, float]]]:
        """Returns names and positions of all states, the likeliest start first.

        States in which a robot is packed come last.
        """

        def rank(state: tuple[str, dict[str, float]]) -> int:
            name = state[0].lower()
            for i, wanted in enumerate(HOMES):
                if wanted in name:
                    return i
            packed = any(word in name for word in PACKED)
            return len(HOMES) + packed

        return sorted(self.states.items(), key=rank)


def find_srdf(urdf: Path, robot: str = "") -> Path | None:
    """Finds the SRDF of a robot, beside the URDF or in a folder beside it.

    The SRDF has the URDF's name or a prefix of it. Otherwise it is the only
    SRDF in these folders that names the robot.

    Args:
        urdf: The URDF's path.
        robot: The name that the URDF gives the robot.
    """
    stem = urdf.name.partition(".")[0]
    folder = urdf.absolute().parent
    folders = [folder, folder / "srdf", folder.parent / "srdf"]
    folders += [folder.parent / "config"]
    for place in folders:
        named = place / f"{stem}.srdf"
        if named.is_file():
            return named
    for place in folders[:-1]:
        found = sorted(place.glob("*.srdf"))
        related = [p for p in found if stem.startswith(p.stem)]
        if related:
            return max(related, key=lambda path: len(path.stem))
        named = [p for p in found if robot and _robot_name(p) == robot]
        if len(named) == 1:
            return named[0]
    return None


def _robot_name(path: Path) -> str | None:
    try:
        return ElementTree.parse(path).getroot().get("name")
    except (OSError, ElementTree.ParseError):
        return None


def read_srdf(path: Path, urdf: Urdf) -> Srdf:
    """Reads an SRDF; parts about other links and joints are ignored.

    Args:
        path: The file.
        urdf: The robot that the SRDF describes.

    Raises:
        FileError: The file cannot be read, or is not an SRDF.
        FieldError: A position is not a number.
    """
    try:
        root = ElementTree.parse(path).getroot()
    except (OSError, ElementTree.ParseError) as error:
        raise FileError(path, f"is not an SRDF: {error}") from error
    if root.tag != "robot":
        raise FileError(path, f"expected <robot>, got <{root.tag}>")
    states: dict[str, dict[str, float]] = {}
    for state in root.findall("group_state"):
        positions = states.setdefault(state.get("name", ""), {})
        for joint in state.findall("joint"):
            name = joint.get("name", "")
            if name in urdf.joints:
                positions[name] = _position(path, name, joint.get("value", ""))
    pairs = set()
    for pair in root.findall("disable_collisions"):
        first, second = sorted((pair.get("link1", ""), pair.get("link2", "")))
        if {first, second} <= set(urdf.links):
            pairs.add((first, second))
    tips = [
        chain.get("tip_link", "")
        for group in root.findall("group")
        for chain in group.findall("chain")
    ]
    return Srdf(
        tips=tuple(tip for tip in tips if tip in urdf.links),
        tools=_tools(root, urdf),
        is_planar=any(
            joint.get("type") == "planar"
            for joint in root.findall("virtual_joint")
        ),
        states=states,
        allowed_collisions=tuple(sorted(pairs)),
    )


def _tools(root: Element, urdf: Urdf) -> dict[str, tuple[str, ...]]:
    """Maps each link that carries a gripper to the gripper's links."""
    groups = {group.get("name", ""): group for group in root.findall("group")}
    tools = {}
    for effector in root.findall("end_effector"):
        parent = effector.get("parent_link", "")
        group = groups.get(effector.get("group", ""))
        if parent not in urdf.links:
            continue
        links = [] if group is None else _group_links(group, urdf)
        # Some SRDFs name the arm itself, or the whole robot.
        is_gripper = all(
            any(joint.parent == parent for joint in urdf.chain(link))
            for link in links
        )
        tools[parent] = tuple(links) if is_gripper else ()
    return tools


def _group_links(group: Element, urdf: Urdf) -> list[str]:
    """Returns the links that a group names, and those that its joints move."""
    links = [link.get("name", "") for link in group.findall("link")]
    for joint in group.findall("joint"):
        if joint.get("name") in urdf.joints:
            links.append(urdf.joints[joint.get("name", "")].child)
    for chain in group.findall("chain"):
        links.append(chain.get("tip_link", ""))
    return [link for link in dict.fromkeys(links) if link in urdf.links]


def _position(path: Path, joint: str, text: str) -> float:
    try:
        # Joints with several axes have several values.
        value = float(text.split()[0])
    except (ValueError, IndexError):
        value = math.nan
    if not math.isfinite(value):
        problem = f"expected a finite number, got {text!r}"
        raise FieldError(str(path), f"<group_state> joint {joint!r}", problem)
    return value
