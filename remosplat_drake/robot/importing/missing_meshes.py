"""Replaces missing meshes that a robot's files name.

Some packages lack visual meshes, other packages lack collision meshes. If a
link has shapes of the other kind, these shapes replace the missing meshes.
"""

from collections.abc import Callable, Iterable
from xml.etree.ElementTree import Element

from remosplat_drake.base.errors import FieldError
from remosplat_drake.robot.importing.findings import Findings, listed
from remosplat_drake.robot.importing.packages import Packages
from remosplat_drake.robot.importing.urdf import Urdf

VISUAL, COLLISION = "visual", "collision"
"""Tags of a link's visual and collision elements."""

_SHARED = ("origin", "pose", "geometry")
"""Child elements that visual and collision elements have in common."""


def replace_missing(urdf: Urdf, packages: Packages, findings: Findings) -> None:
    """Replaces elements of a URDF whose meshes are missing.

    Args:
        urdf: The robot; its links' elements are changed.
        packages: Resolves references to ROS packages.
        findings: Receives the names of links with replaced meshes.
    """

    def is_there(element: Element) -> bool:
        for mesh in element.iter("mesh"):
            try:
                place = packages.place(mesh.get("filename", ""), element.tag)
            except FieldError:
                # If a package is not found, a missing collision mesh raises the
                # error that asks for the package, but a missing visual mesh
                # does not.
                return element.tag == COLLISION
            if not place.is_file():
                return False
        return True

    note_replaced(replace_by_others(urdf.links.values(), is_there), findings)


def replace_by_others(
    links: Iterable[Element], is_there: Callable[[Element], bool]
) -> dict[str, list[str]]:
    """Removes missing meshes from links.

    A link's elements of the other kind replace the missing meshes. A link
    without usable elements is not changed, so that a later error names the
    mesh.

    Args:
        links: The links' elements, which are changed.
        is_there: Function that returns True if an element has no mesh, or if
            its mesh exists.

    Returns:
        Names of the links by the tag of the missing meshes.
    """
    replaced: dict[str, list[str]] = {VISUAL: [], COLLISION: []}
    for link in links:
        kinds = {tag: link.findall(tag) for tag in (VISUAL, COLLISION)}
        there = {tag: [x for x in kinds[tag] if is_there(x)] for tag in kinds}
        for tag, other in ((VISUAL, COLLISION), (COLLISION, VISUAL)):
            lacking = [x for x in kinds[tag] if x not in there[tag]]
            if not lacking or not there[other]:
                continue
            for element in kinds[tag]:
                link.remove(element)
            link.extend(_twin(element, tag) for element in there[other])
            replaced[tag].append(link.get("name", ""))
    return replaced


def note_replaced(replaced: dict[str, list[str]], findings: Findings) -> None:
    """Adds findings about links with replaced meshes.

    Args:
        replaced: Names of the links by the tag of the missing meshes.
        findings: Receives the names.
    """
    if replaced[VISUAL]:
        findings.doubt(
            "pictures",
            "meshes are missing; collision shapes replace those of"
            f" {listed(replaced[VISUAL])}",
        )
    if replaced[COLLISION]:
        findings.doubt(
            "collision shapes",
            "meshes are missing; visual shapes replace those of"
            f" {listed(replaced[COLLISION])}",
        )


def _twin(element: Element, tag: str) -> Element:
    twin = Element(tag, dict(element.attrib))
    if "name" in twin.attrib:
        twin.set("name", f"{twin.get('name')}_{tag}")
    twin.extend(_copy(child) for child in element if child.tag in _SHARED)
    return twin


def _copy(element: Element) -> Element:
    twin = Element(element.tag, dict(element.attrib))
    twin.text = element.text
    twin.extend(_copy(child) for child in element)
    return twin
