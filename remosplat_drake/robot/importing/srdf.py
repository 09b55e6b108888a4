"""`Srdf`: what MoveIt's setup assistant has written about a robot."""

import dataclasses as dc
import math
from pathlib import Path
from xml.etree import ElementTree

from remosplat_drake.base.errors import FieldError, FileError
from remosplat_drake.robot.importing.urdf import Urdf

HOMES = ("home", "ready", "rest", "default", "up")
"""Names of states that a robot may start from, the likeliest first."""


@dc.dataclass(frozen=True)
class Srdf:
    """The part of an SRDF that says how a robot is driven.

    Attributes:
        tips: Last links of the chains of its groups.
        states: Positions of joints by name, for each named state [rad, m].
        allowed_collisions: Pairs of links that may touch, each sorted.
    """

    tips: tuple[str, ...] = ()
    states: dict[str, dict[str, float]] = dc.field(default_factory=dict)
    allowed_collisions: tuple[tuple[str, str], ...] = ()

    def home(self) -> tuple[str, dict[str, float]] | None:
        """Returns the name and positions of the likeliest start, if any."""
        for wanted in HOMES:
            for name, positions in self.states.items():
                if wanted in name.lower():
                    return name, positions
        return None


def find_srdf(urdf: Path) -> Path | None:
    """Finds the SRDF of a robot, beside its URDF or in a folder beside it.

    Args:
        urdf: The URDF's path.
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
    return None


def read_srdf(path: Path, urdf: Urdf) -> Srdf:
    """Reads an SRDF; what is about other links and joints is left out.

    Args:
        path: The file.
        urdf: The robot that it is about.

    Raises:
        FileError: It cannot be read, or is no SRDF.
        FieldError: A position is no number.
    """
    try:
        root = ElementTree.parse(path).getroot()
    except (OSError, ElementTree.ParseError) as error:
        raise FileError(path, f"is no SRDF: {error}") from error
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
        tuple(tip for tip in tips if tip in urdf.links),
        states,
        tuple(sorted(pairs)),
    )


def _position(path: Path, joint: str, text: str) -> float:
    try:
        # Some write several values for a joint of several axes.
        value = float(text.split()[0])
    except (ValueError, IndexError):
        value = math.nan
    if not math.isfinite(value):
        problem = f"expected a finite number, got {text!r}"
        raise FieldError(str(path), f"<group_state> joint {joint!r}", problem)
    return value
