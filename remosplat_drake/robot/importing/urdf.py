"""`Urdf`: a robot's URDF, read and checked for parts that cannot be driven."""

import dataclasses as dc
import math
from pathlib import Path
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

from remosplat_drake.base.atomic_file import write_atomically
from remosplat_drake.base.errors import FieldError, FileError, unknown_name
from remosplat_drake.robot.importing.dialects import URDF, Dialect

REVOLUTE, CONTINUOUS, PRISMATIC, FIXED = (
    "revolute",
    "continuous",
    "prismatic",
    "fixed",
)
"""Types of joints that can be driven or stand still."""

MOVING = (REVOLUTE, CONTINUOUS, PRISMATIC)
"""Types of joints that can move."""

ElementTree.register_namespace("drake", "http://drake.mit.edu")


@dc.dataclass(frozen=True, eq=False)
class UrdfJoint:
    """A joint of a URDF.

    Attributes:
        name: Name of the joint.
        kind: One of `MOVING`, or `FIXED`.
        parent: Name of the link that carries it.
        child: Name of the link that it moves.
        lower: Lower limit [rad, m]; nan if the file names none.
        upper: Upper limit [rad, m]; nan if the file names none.
        velocity: Largest speed [rad/s, m/s]; nan if the file names none.
        effort: Largest effort of its motor [N m, N]; nan if the file names
            none.
        mimics: Name of the joint that it follows; empty for none.
        multiplier: Factor on the position of the followed joint.
        offset: Offset that is added to this product [rad, m].
        element: Element of the joint in the document.
    """

    name: str
    kind: str
    parent: str
    child: str
    lower: float
    upper: float
    velocity: float
    effort: float
    mimics: str
    multiplier: float
    offset: float
    element: Element

    @property
    def moves(self) -> bool:
        """Whether the joint can move on its own."""
        return self.kind in MOVING and not self.mimics


@dc.dataclass(frozen=True)
class Loop:
    """A constraint between two links, in addition to their joints.

    Attributes:
        where: Element of the constraint, for errors.
        first: Name of one link.
        second: Name of the other.
    """

    where: str
    first: str
    second: str


@dc.dataclass(frozen=True)
class Mimic:
    """The law of a joint that follows a leader: multiplier * q_leader + offset.

    Attributes:
        leader: Name of the joint that is followed.
        multiplier: Text of the factor.
        offset: Text of the added offset [rad, m].
    """

    leader: str
    multiplier: str
    offset: str


class Urdf:
    """The links and joints of a URDF, which form a tree.

    Attributes:
        path: The file that contains the document, for errors.
        dialect: Format of that file.
        loops: Elements that close loops of links.
        name: Name of the robot.
        root: The document's root element.
        links: The links' elements by name.
        joints: The joints by name, in the order of the file.
        base: Name of the link that no joint carries.
    """

    def __init__(
        self,
        path: Path,
        text: str,
        dialect: Dialect = URDF,
        loops: tuple[Loop, ...] = (),
    ):
        """Reads the text of a URDF.

        Args:
            path: The file that contains the document, for errors.
            text: The text.
            dialect: Format of that file, for errors.
            loops: Elements of that file that close loops, which a URDF cannot
                contain.

        Raises:
            FileError: The text is not XML, or not a URDF.
            FieldError: An element is unusable, or the links are not a tree.
        """
        self.path = path
        self.dialect = dialect
        self.loops = loops
        self.root = _parsed(path, text)
        self.name = self.root.get("name") or path.stem
        self.links = self._named("link")
        if not self.links:
            raise FileError(path, "<robot> has no <link>")
        self.joints = {
            name: self._joint(name, element)
            for name, element in self._named("joint").items()
        }
        self._check_mimics()
        self.inboard = self._inboard()
        self.base = self._base()

    def fail(self, element: str, problem: str) -> FieldError:
        """Returns an error about an element of the file."""
        return FieldError(str(self.path), element, problem)

    def write(self, path: Path) -> None:
        """Writes the document, with its changes.

        Args:
            path: The file.
        """
        ElementTree.indent(self.root)
        text = ElementTree.tostring(self.root, encoding="unicode")
        write_atomically(path, f'<?xml version="1.0"?>\n{text}\n')

    def chain(self, link: str) -> list[UrdfJoint]:
        """Returns the joints from the base to a link, in this order."""
        joints = []
        while link in self.inboard:
            joints.append(self.inboard[link])
            link = joints[-1].parent
        return joints[::-1]

    def outboard(self, link: str) -> list[UrdfJoint]:
        """Returns the joints that a link carries."""
        return [j for j in self.joints.values() if j.parent == link]

    def rigid_root(self, link: str) -> str:
        """Returns the link nearest to the root that a link is fixed to."""
        while link in self.inboard and self.inboard[link].kind == FIXED:
            link = self.inboard[link].parent
        return link

    def _named(self, tag: str) -> dict[str, Element]:
        elements = {}
        for i, element in enumerate(self.root.findall(tag)):
            name = element.get("name")
            if not name:
                raise self.fail(f"{tag} {i + 1}", "has no name; write name=...")
            if name in elements:
                problem = "occurs twice; rename or remove one"
                raise self.fail(f"{tag} {name!r}", problem)
            elements[name] = element
        return elements

    def _joint(self, name: str, element: Element) -> UrdfJoint:
        where = f"joint {name!r}"
        kind = element.get("type", "")
        if kind in ("floating", "planar"):
            raise self.fail(
                where,
                f"is {kind}, which cannot be driven; write type='fixed', and"
                " use --base to say how the robot moves",
            )
        if kind not in (*MOVING, FIXED):
            valid = [*MOVING, FIXED]
            raise self.fail(where, unknown_name("type", kind, valid))
        parent, child = (
            self._end(element, tag, where) for tag in ("parent", "child")
        )
        limit, mimic = element.find("limit"), element.find("mimic")
        lower, upper, velocity, effort = (
            self._number(limit, key, math.nan, f"{where} <limit>")
            for key in ("lower", "upper", "velocity", "effort")
        )
        return UrdfJoint(
            name,
            kind,
            parent,
            child,
            lower,
            upper,
            velocity,
            effort,
            "" if mimic is None else mimic.get("joint", ""),
            self._number(mimic, "multiplier", 1.0, f"{where} <mimic>"),
            self._number(mimic, "offset", 0.0, f"{where} <mimic>"),
            element,
        )

    def _end(self, element: Element, tag: str, where: str) -> str:
        found = element.find(tag)
        link = "" if found is None else found.get("link", "")
        if link not in self.links:
            problem = unknown_name("link", link, self.links)
            raise self.fail(f"{where} <{tag}>", problem)
        return link

    def _number(
        self, element: Element | None, key: str, absent: float, where: str
    ) -> float:
        text = None if element is None else element.get(key)
        if text is None:
            return absent
        try:
            value = float(text)
        except ValueError:
            value = math.nan
        if not math.isfinite(value):
            problem = f"expected a finite number, got {text!r}"
            raise self.fail(f"{where} {key}", problem)
        return value

    def _check_mimics(self) -> None:
        for joint in self.joints.values():
            if joint.mimics and joint.mimics not in self.joints:
                problem = unknown_name("joint", joint.mimics, self.joints)
                raise self.fail(
                    f"joint {joint.name!r} {self.dialect.mimic}", problem
                )

    def _inboard(self) -> dict[str, UrdfJoint]:
        inboard: dict[str, UrdfJoint] = {}
        for joint in self.joints.values():
            other = inboard.setdefault(joint.child, joint)
            if other is not joint:
                raise self.fail(
                    f"link {joint.child!r}",
                    f"is the child of {other.name!r} and of {joint.name!r}: a"
                    " loop, which cannot be driven; remove one of the joints",
                )
        return inboard

    def _base(self) -> str:
        bases = [link for link in self.links if link not in self.inboard]
        if len(bases) > 1:
            raise self.fail(
                f"link {bases[1]!r}",
                f"has no parent joint, and neither has {bases[0]!r}; join them"
                f" by {self.dialect.weld} or remove one",
            )
        seen = set(bases)
        for link in seen.copy():
            level = [link]
            while level:
                level = [j.child for x in level for j in self.outboard(x)]
                seen.update(level)
        lost = next((link for link in self.links if link not in seen), None)
        if lost is not None:
            problem = "is part of a loop of joints; remove one of them"
            raise self.fail(f"link {lost!r}", problem)
        return bases[0]


def parse_xml(path: Path, text: str) -> Element:
    """Parses XML into its root element.

    Args:
        path: The file that contains the document, for errors.
        text: The text.

    Raises:
        FileError: The text is not valid XML.
    """
    try:
        return ElementTree.fromstring(text)
    except ElementTree.ParseError as error:
        hint = ""
        if "xacro:" in text:
            hint = "; is it xacro? Then name it .xacro"
        elif "prefix" in str(error):
            hint = "; declare it, as in xmlns:drake='http://drake.mit.edu'"
        raise FileError(path, f"is broken XML: {error}{hint}") from error


def _parsed(path: Path, text: str) -> Element:
    root = parse_xml(path, text)
    if root.tag != "robot":
        raise FileError(path, f"expected <robot>, got <{root.tag}>")
    return root
