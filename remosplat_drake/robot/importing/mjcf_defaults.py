"""Writes the attributes of MJCF's default classes into the elements.

Drake's parser treats default classes differently from MuJoCo: if a class's
parent has no joint defaults, the class does not inherit the joint defaults of
its grandparent.
"""

from pathlib import Path
from xml.etree.ElementTree import Element

from remosplat_drake.base.errors import FieldError, unknown_name

_TAGS = ("geom", "joint", "material", "mesh", "site")
"""The relevant elements that have defaults."""

_MAIN = "main"
"""Name of the root class."""

_ROTATIONS = {"quat", "axisangle", "xyaxes", "zaxis", "euler"}
"""Attributes that exclude each other."""

_Attributes = dict[str, dict[str, str]]


def write_out_defaults(path: Path, root: Element) -> None:
    """Copies attributes of classes to their elements; removes the classes.

    Args:
        path: The file, for errors.
        root: The document, which is changed.

    Raises:
        FieldError: An element names a class that does not exist.
    """
    classes: dict[str, _Attributes] = {_MAIN: {}}
    for default in root.findall("default"):
        # The outermost class applies to all elements, for any name.
        _collect(default, _MAIN, classes[_MAIN], classes)
        classes[default.get("class", _MAIN)] = classes[_MAIN]
        root.remove(default)
    _apply(path, root, _MAIN, classes)


def _collect(
    default: Element,
    name: str,
    inherited: _Attributes,
    classes: dict[str, _Attributes],
) -> None:
    """Adds a class and the classes inside it, which inherit its attributes."""
    own = {tag: dict(attributes) for tag, attributes in inherited.items()}
    for element in default:
        if element.tag in _TAGS:
            attributes = own.setdefault(element.tag, {})
            own[element.tag] = _overlaid(attributes, dict(element.attrib))
    classes[name] = own
    for inner in default.findall("default"):
        _collect(inner, inner.get("class", ""), own, classes)


def _overlaid(
    defaults: dict[str, str], attributes: dict[str, str]
) -> dict[str, str]:
    if _ROTATIONS & attributes.keys():
        defaults = {
            key: value
            for key, value in defaults.items()
            if key not in _ROTATIONS
        }
    return defaults | attributes


def _apply(
    path: Path, element: Element, name: str, classes: dict[str, _Attributes]
) -> None:
    for child in element:
        given = child.attrib.pop("class", name)
        if child.tag in _TAGS:
            if given not in classes:
                problem = unknown_name("class", given, classes)
                label = child.get("name", "")
                where = f"{child.tag} {label!r}" if label else f"<{child.tag}>"
                raise FieldError(str(path), where, problem)
            defaults = classes[given].get(child.tag, {})
            attributes = _overlaid(defaults, dict(child.attrib))
            child.attrib.clear()
            child.attrib.update(attributes)
        inner = child.attrib.pop("childclass", name)
        _apply(path, child, inner, classes)
