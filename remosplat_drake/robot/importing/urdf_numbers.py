"""Checks the numbers of a URDF before it is processed."""

import math
from xml.etree.ElementTree import Element

from remosplat_drake.robot.importing.urdf import Urdf

_SIZES = {
    "box": {"size": 3},
    "cylinder": {"radius": 1, "length": 1},
    "sphere": {"radius": 1},
}
"""Attributes of shapes that must be positive, and their numbers of entries."""


def check_numbers(urdf: Urdf) -> None:
    """Checks the numbers of origins, axes and primitive shapes.

    Args:
        urdf: The robot.

    Raises:
        FieldError: A number is missing, invalid or impossible; the text names
            link or joint and element.
    """
    for name, joint in urdf.joints.items():
        where = f"joint {name!r}"
        _check_origin(urdf, joint.element, where)
        axis = joint.element.find("axis")
        if axis is not None and joint.moves:
            xyz = _numbers(urdf, axis, "xyz", 3, f"{where} <axis>")
            if xyz is not None and not any(xyz):
                problem = "is zero; write the direction, such as 0 0 1"
                raise urdf.fail(f"{where} <axis> xyz", problem)
    for name, link in urdf.links.items():
        for tag in ("visual", "collision", "inertial"):
            for element in link.findall(tag):
                where = f"link {name!r} <{tag}>"
                _check_origin(urdf, element, where)
                for shape in element.iterfind("geometry/*"):
                    _check_size(urdf, shape, where)


def _check_origin(urdf: Urdf, element: Element, where: str) -> None:
    origin = element.find("origin")
    if origin is not None:
        for key in ("xyz", "rpy"):
            _numbers(urdf, origin, key, 3, f"{where} <origin>")


def _check_size(urdf: Urdf, shape: Element, where: str) -> None:
    for key, count in _SIZES.get(shape.tag, {}).items():
        at = f"{where} <{shape.tag}>"
        values = _numbers(urdf, shape, key, count, at)
        if values is None:
            raise urdf.fail(at, f"has no {key}; write {key}=... in m")
        if min(values) <= 0:
            problem = f"must be positive, got {shape.get(key)!r}"
            raise urdf.fail(f"{at} {key}", problem)


def _numbers(
    urdf: Urdf, element: Element, key: str, count: int, where: str
) -> list[float] | None:
    """Returns the numbers of an attribute; None if it is missing."""
    text = element.get(key)
    if text is None:
        return None
    try:
        values = [float(x) for x in text.split()]
    except ValueError:
        values = []
    if len(values) != count or not all(map(math.isfinite, values)):
        counted = "a number" if count == 1 else f"{count} numbers"
        raise urdf.fail(f"{where} {key}", f"expected {counted}, got {text!r}")
    return values
