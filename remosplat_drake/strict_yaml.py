"""YAML into dataclasses, with errors that name file, line and field.

Drake's `yaml_load_typed` does the loading. It lets NaN and quoted numbers
pass and its messages are hard to read, so the document is checked against
the dataclasses first, on PyYAML's node tree, which knows line numbers.
"""

import dataclasses as dc
import math
import re
import types
import typing
from pathlib import Path
from typing import Any, TypeVar

import yaml
from pydrake.common.yaml import yaml_load_typed

from remosplat_drake.errors import FieldError, FileError, unknown_name

T = TypeVar("T")


def load_strict(
    schema: type[T],
    path: Path,
    child: str | None = None,
    override: str | None = None,
    defaults: T | None = None,
) -> T:
    """Loads a YAML file, or one named entry of it, into a dataclass.

    Args:
        schema: A dataclass whose fields all have defaults.
        path: The file.
        child: Key of the entry to load; None loads the whole document.
        override: Further YAML, laid over the file's values.
        defaults: Values for what neither names.

    Raises:
        FileError: The file is missing, not YAML, or has no such entry.
        FieldError: A field is unknown or its value has the wrong type.
    """
    result = _load(schema, read_text(path), str(path), child, defaults)
    if override:
        result = load_text(schema, override, "--scenario-text", result)
    return result


def load_text(schema: type[T], text: str, where: str, defaults: T) -> T:
    """Lays YAML over a dataclass's values.

    Args:
        schema: A dataclass whose fields all have defaults.
        text: YAML.
        where: What to blame, a flag for example.
        defaults: Values for what the text does not name.

    Raises:
        FileError: The text is not YAML.
        FieldError: A field is unknown or its value has the wrong type.
    """
    return _load(schema, text, where, None, defaults)


def read_text(path: Path) -> str:
    """The file's text.

    Raises:
        FileError: It is missing, unreadable or not text.
    """
    try:
        return path.read_text()
    except OSError as error:
        raise FileError(path, error.strerror or str(error)) from error
    except UnicodeDecodeError as error:
        raise FileError(path, "not a text file") from error


def entries(path: Path) -> list[str]:
    """The keys of a YAML mapping, in order."""
    node = _compose(read_text(path), str(path))
    return [key.value for key, _ in _mapping(node, str(path), "")]


def _load(
    schema: type[T],
    text: str,
    where: str,
    child: str | None,
    defaults: T | None,
) -> T:
    root = _compose(text, where)
    node = root
    if child is not None:
        found = {key.value: value for key, value in _mapping(root, where, "")}
        if child not in found:
            raise FileError(where, unknown_name("entry", child, found))
        node = found[child]
    if not _is_null(node):
        check_node(node, schema, where, "")
    try:
        return yaml_load_typed(
            schema=schema,
            data=text,
            child_name=child,
            defaults=defaults,
            retain_map_defaults=False,
        )
    except (RuntimeError, yaml.YAMLError) as error:
        raise FileError(where, " ".join(str(error).split())) from error


def _compose(text: str, where: str) -> yaml.Node:
    try:
        node = yaml.compose(text, Loader=yaml.SafeLoader)
    except yaml.YAMLError as error:
        raise FileError(
            where, "not YAML: " + " ".join(str(error).split())
        ) from error
    if node is None:
        raise FileError(where, "is empty")
    return node


def check_node(node: yaml.Node, expected: Any, where: str, field: str) -> None:
    """Checks one node against a type annotation, and what is below it.

    Raises:
        FieldError: It does not fit; names the line and the field.
    """
    origin = typing.get_origin(expected)
    if origin in (typing.Union, types.UnionType):
        _check_union(node, typing.get_args(expected), where, field)
        return
    _check_tag(node, where, field)
    if dc.is_dataclass(expected):
        _check_dataclass(node, typing.cast(type, expected), where, field)
    elif origin is list:
        if not isinstance(node, yaml.SequenceNode):
            _fail(node, where, field, "expected a list")
        for i, item in enumerate(node.value):
            check_node(
                item, typing.get_args(expected)[0], where, f"{field}[{i}]"
            )
    elif origin is dict:
        for key, value in _mapping(node, where, field):
            check_node(
                value,
                typing.get_args(expected)[1],
                where,
                _join(field, key.value),
            )
    else:
        _check_scalar(node, expected, where, field)


def _check_union(node: yaml.Node, options, where: str, field: str) -> None:
    if type(None) in options and _is_null(node):
        return
    classes = [option for option in options if option is not type(None)]
    if len(classes) == 1:
        return check_node(node, classes[0], where, field)
    tag = node.tag.removeprefix("!")
    if node.tag.startswith(_YAML_TAG):
        return check_node(node, classes[0], where, field)
    by_name = {option.__name__: option for option in classes}
    if tag not in by_name:
        _fail(node, where, field, unknown_name("tag", tag, by_name))
    _check_dataclass(node, by_name[tag], where, field)


def _check_tag(node: yaml.Node, where: str, field: str) -> None:
    """Only a choice between classes takes a tag."""
    if not node.tag.startswith(_YAML_TAG):
        _fail(node, where, field, f"takes no tag, got {node.tag!r}")


def _check_dataclass(node: yaml.Node, schema: type, where: str, field: str):
    hints = typing.get_type_hints(schema)
    names = [f.name for f in dc.fields(schema) if f.metadata.get("yaml", True)]
    for key, value in _mapping(node, where, field):
        path = _join(field, key.value)
        if key.value not in names:
            _fail(key, where, path, unknown_name("field", key.value, names))
        check_node(value, hints[key.value], where, path)


_YAML_TAG = "tag:yaml.org,2002:"
_KINDS = {
    float: ("a number", ("float", "int")),
    int: ("a whole number", ("int",)),
    bool: ("true or false", ("bool",)),
    str: ("text", ("str",)),
    Path: ("a path", ("str",)),
}
_OCTAL = re.compile(r"[-+]?0[0-9_]+")


def _check_scalar(node: yaml.Node, expected: Any, where: str, field: str):
    name, kinds = _KINDS.get(expected, (str(expected), ()))
    if not isinstance(node, yaml.ScalarNode):
        _fail(node, where, field, f"expected {name}")
    is_kind = node.tag.removeprefix(_YAML_TAG) in kinds
    number = _number(node)
    if expected is float:
        is_kind = number is not None
    if not is_kind:
        hint = ""
        if expected in (float, int, bool) and node.style:
            hint = " (in quotes it is text)"
        elif expected is str and not _is_null(node):
            hint = " (put it in quotes)"
        problem = f"expected {name}, got {node.value!r}{hint}"
        _fail(node, where, field, problem)
    if expected in (float, int) and _OCTAL.fullmatch(node.value):
        _fail(node, where, field, f"{node.value}: YAML reads this as octal")
    if expected is float and not math.isfinite(number or 0.0):
        _fail(node, where, field, f"must be finite, got {node.value}")


def _number(node: yaml.ScalarNode) -> float | None:
    """The number that a plain scalar stands for.

    Plain 1e-3 is a number to people and YAML 1.2, not to YAML 1.1.
    """
    if node.style:
        return None
    try:
        return float(_SPECIAL.sub(r"\1", node.value))
    except ValueError:
        return None


_SPECIAL = re.compile(r"^([-+]?)\.(?=inf|nan)", re.IGNORECASE)
"""The dot of YAML's own spellings .inf, -.inf and .nan."""


def _mapping(node: yaml.Node, where: str, field: str) -> list[tuple]:
    """The key and value nodes of a mapping; each key occurs once."""
    name = field or "the document"
    if not isinstance(node, yaml.MappingNode):
        _fail(node, where, name, "expected a mapping `key: value`")
    seen: set[str] = set()
    for key, _ in node.value:
        if not isinstance(key, yaml.ScalarNode):
            _fail(key, where, name, "a key must be plain text")
        if key.value in seen:
            _fail(key, where, _join(field, key.value), "appears twice")
        seen.add(key.value)
    return node.value


def _is_null(node: yaml.Node) -> bool:
    return node.tag == _YAML_TAG + "null"


def _join(field: str, key: str) -> str:
    return f"{field}.{key}" if field else key


def _fail(
    node: yaml.Node, where: str, field: str, problem: str
) -> typing.NoReturn:
    line = node.start_mark.line + 1 if node.start_mark else 0
    raise FieldError(f"{where}:{line}", field, problem)
