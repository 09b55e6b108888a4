"""Loads YAML into dataclasses, with errors that name file, line and field.

Each document is parsed into nodes with line numbers. The nodes are checked
against the dataclasses and the ranges of their fields (`ranges.py`). Then
several documents (layers), such as a file and a text from the command line, are
merged into one object.
"""

import copy
import dataclasses as dc
import re
import typing
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
import yaml

from remosplat_drake.base.drake_structs import is_record, is_struct, member
from remosplat_drake.base.errors import (
    FieldError,
    FileError,
    RemoSplatError,
    unknown_name,
)
from remosplat_drake.base.extensions import extension_name, find_extension
from remosplat_drake.base.ranges import (
    KINDS,
    Config,
    alternatives,
    choices,
    field_types,
    joined,
    range_problem,
    shown,
    split,
)
from remosplat_drake.base.yaml_nodes import (
    YAML_TAG,
    compose,
    fail,
    fields,
    is_null,
    read_text,
    scalar,
)

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
        path: The YAML file.
        child: Key of the entry to load; None loads the whole document.
        override: YAML text whose values replace those of the file.
        defaults: Values of the fields that neither the file nor `override`
            contains.

    Raises:
        FileError: The file is missing, is not YAML, or lacks the entry `child`.
        FieldError: A field is unknown, or its value is invalid. The error names
            the file, the line and the field.
    """
    node = compose(read_text(path), str(path))
    if child is not None:
        found = fields(node, "")
        if child not in found:
            raise FileError(path, unknown_name("entry", child, found))
        node = found[child][1]
    layers = [node]
    if override:
        layers.append(compose(override, "--scenario-text"))
    return _load(schema, layers, defaults, path.parent)


def load_text(schema: type[T], text: str, where: str, defaults: T) -> T:
    """Loads a YAML text into a dataclass.

    Args:
        schema: A dataclass whose fields all have defaults.
        text: YAML text, for example from the command line.
        where: Source of the text, such as a flag, for errors.
        defaults: Values of the fields that the text does not contain.

    Raises:
        FileError: The text is not YAML.
        FieldError: A field is unknown, or its value is invalid.
    """
    return _load(schema, [compose(text, where)], defaults)


def entries(path: Path) -> list[str]:
    """Returns the keys of a YAML file that holds a mapping, in order.

    Raises:
        FileError: The file is missing or not YAML.
        FieldError: The file holds something other than a mapping.
    """
    return list(fields(compose(read_text(path), str(path)), ""))


def _load(
    schema: type[T],
    layers: list[yaml.Node],
    defaults: T | None,
    folder: Path | None = None,
) -> T:
    layers = [layer for layer in layers if not is_null(layer)]
    if folder is not None and issubclass(schema, Config) and schema.MODULES:
        for layer in layers:
            _, node = fields(layer, "").get(schema.MODULES, (None, None))
            folder = folder / node.value if _is_text(node) else folder
    for layer in layers:
        _check_node(layer, schema, "", folder)
    defaults = copy.deepcopy(defaults)
    return _build_dataclass(layers, schema, defaults, "")


def _is_text(node: yaml.Node | None) -> bool:
    return node is not None and node.tag == YAML_TAG + "str"


# The functions below check one document (layer).


def _check_node(
    node: yaml.Node, expected: Any, field: str, folder: Path | None
) -> None:
    """Checks a node and its children against an annotation.

    Args:
        node: The node.
        expected: The annotation.
        field: Path of the field, for messages.
        folder: Folder that is searched for extensions after Python's import
            path.

    Raises:
        FieldError: The node does not fit the annotation. The error names the
            line and the field.
    """
    base, markers = split(expected)
    options = choices(base)
    if type(None) in options and is_null(node):
        return
    schema, node = _choose(node, base, field, folder)
    if schema is not base:
        return _check_node(node, schema, field, folder)
    if not node.tag.startswith(YAML_TAG):
        fail(node, field, f"must not have a tag, got {shown(node.tag)}")
    container = typing.get_origin(base)
    if is_record(base):
        return _check_fields(node, typing.cast(type, base), field, folder)
    value: Any
    if container is list:
        if not isinstance(node, yaml.SequenceNode):
            fail(node, field, "expected a list")
        value = node.value
        for i, item in enumerate(value):
            inner = typing.get_args(base)[0]
            _check_node(item, inner, f"{field}[{i}]", folder)
    elif container is dict:
        value = fields(node, field)
        for key, (_, item) in value.items():
            inner = typing.get_args(base)[1]
            _check_node(item, inner, joined(field, key), folder)
    else:
        value = _checked_scalar(node, base, field)
    problem = range_problem(value, markers)
    if problem:
        fail(node, field, problem)


def _choose(
    node: yaml.Node, base: Any, field: str, folder: Path | None = None
) -> tuple[Any, yaml.Node]:
    """Returns the class in a union that a tag names, and the node without tag.

    If there is no tag, the function returns the first class of the union. If
    the union contains a protocol, the tag may also name a class of another
    package.
    """
    options, protocols = alternatives(base)
    tag = "" if node.tag.startswith(YAML_TAG) else node.tag.removeprefix("!")
    if protocols:
        is_text = node.tag == YAML_TAG + "str"
        name = node.value if is_text else tag
        if ":" in name or not options:
            try:
                found = find_extension(name, protocols, folder)
            except RemoSplatError as error:
                fail(node, field, str(error))
            return found, _untagged(node, or_empty=True)
    if not tag or (len(options) == 1 and not protocols):
        return options[0], node
    by_name = {option.__name__: option for option in options}
    if tag not in by_name:
        fail(node, field, unknown_name("tag", tag, by_name))
    return by_name[tag], _untagged(node)


def _untagged(node: yaml.Node, or_empty: bool = False) -> yaml.Node:
    """Removes a node's tag; a tag without values becomes an empty mapping."""
    is_name = node.tag == YAML_TAG + "str" or node.value == ""
    if or_empty and is_name:
        marks = node.start_mark, node.end_mark
        return yaml.MappingNode(YAML_TAG + "map", [], *marks)
    untagged = copy.copy(node)
    is_mapping = isinstance(node, yaml.MappingNode)
    untagged.tag = YAML_TAG + ("map" if is_mapping else "other")
    return untagged


def _check_fields(
    node: yaml.Node, schema: type, field: str, folder: Path | None
) -> None:
    types = _file_fields(schema)
    for name, (key, value) in fields(node, field).items():
        path = joined(field, name)
        if name not in types:
            fail(key, path, unknown_name("field", name, types))
        _check_node(value, types[name], path, folder)


def _file_fields(schema: type) -> dict[str, Any]:
    """Returns the annotations of the fields that a file may contain."""
    types = field_types(schema)
    if is_struct(schema):
        return types
    listed = (f for f in dc.fields(schema) if f.metadata.get("yaml", True))
    return {f.name: types[f.name] for f in listed}


def _checked_scalar(node: yaml.Node, base: Any, field: str) -> Any:
    name, _ = KINDS[base]
    if not isinstance(node, yaml.ScalarNode):
        fail(node, field, f"expected {name}")
    value = scalar(node, base, field)
    if value is None:
        hint = ""
        if base in (float, int, bool) and node.style:
            hint = " (remove the quotes: a value in quotes is text)"
        elif base is str and not is_null(node):
            hint = " (put it in quotes)"
        fail(node, field, f"expected {name}, got {shown(node.value)}{hint}")
    if base is float and value - value != 0.0:
        fail(node, field, f"must be finite, got {shown(node.value)}")
    return value


# The functions below build an object from checked documents (layers).


def _build(layers: list[yaml.Node], expected: Any, default: Any, field: str):
    """Builds a value from layers; later ones override earlier ones."""
    base, _ = split(expected)
    node = layers[-1]
    if is_null(node) and type(None) in choices(base):
        return None
    schema, _ = _choose(node, base, field)
    if schema is not base:
        alike = _alike(layers, base, field)
        is_laid_over = len(alike) == len(layers) and type(default) is schema
        start = default if is_laid_over else None
        return _build(alike, schema, start, field)
    container = typing.get_origin(base)
    if is_struct(base):
        return _build_struct(layers, typing.cast(type, base), default, field)
    if dc.is_dataclass(base):
        return _build_dataclass(layers, typing.cast(type, base), default, field)
    if container is list:
        item = typing.get_args(base)[0]
        return [
            _build([entry], item, None, f"{field}[{i}]")
            for i, entry in enumerate(node.value)
        ]
    if container is dict:
        item = typing.get_args(base)[1]
        return {
            key: _build([entry], item, None, joined(field, key))
            for key, (_, entry) in fields(node, field).items()
        }
    return scalar(typing.cast(yaml.ScalarNode, node), base, field)


def _alike(layers: list[yaml.Node], base: Any, field: str) -> list[yaml.Node]:
    """Returns the last layers, as long as they have the same type of value."""
    wanted, _ = _choose(layers[-1], base, field)
    alike: list[yaml.Node] = []
    for layer in reversed(layers):
        if is_null(layer):
            break
        schema, rest = _choose(layer, base, field)
        if schema is not wanted:
            break
        alike.insert(0, rest)
    return alike


def _build_dataclass(
    layers: list[yaml.Node], schema: type[T], default: T | None, field: str
) -> T:
    given = _given(layers, field)
    types = field_types(schema)
    start = _start(schema, given, default)
    values = {name: getattr(start, name) for name in types}
    for name, nodes in given.items():
        path = joined(field, name)
        values[name] = _build(nodes, types[name], values[name], path)
    try:
        return schema(**values)
    except FieldError as error:
        # Each value has been checked before, so only relations between fields
        # can be invalid here.
        path = joined(field, error.field)
        if not layers:
            raise FieldError(schema.__name__, path, error.problem) from error
        name, *rest = re.findall(r"[^.\[\]]+", error.field)
        node = _deepest(given.get(name, layers)[-1], rest)
        fail(node, path, error.problem)


def _build_struct(
    layers: list[yaml.Node], struct: type[T], default: T | None, field: str
) -> T:
    built = struct() if default is None else copy.deepcopy(default)
    for name, nodes in _given(layers, field).items():
        path, expected = joined(field, name), field_types(struct)[name]
        value = _build(nodes, expected, member(built, name), path)
        try:
            setattr(built, name, value)
        except (TypeError, ValueError, RuntimeError):
            fail(nodes[-1], path, f"Drake does not accept {shown(value)} here")
    return built


def _given(layers: list[yaml.Node], field: str) -> dict[str, list[yaml.Node]]:
    """Returns the nodes of all layers, keyed by field."""
    given: dict[str, list[yaml.Node]] = {}
    for layer in layers:
        for name, (_, node) in fields(layer, field).items():
            given.setdefault(name, []).append(node)
    return given


def _deepest(node: yaml.Node, path: list[str]) -> yaml.Node:
    """Returns the node at a path; if it does not exist, its closest parent."""
    for name in path:
        if isinstance(node, yaml.MappingNode):
            found = {key.value: value for key, value in node.value}
            node = found.get(name, node)
        elif isinstance(node, yaml.SequenceNode):
            node = node.value[int(name)]
    return node


def _start(
    schema: type[T], given: dict[str, list[yaml.Node]], default: T | None
) -> T:
    """Returns the object that has the values of fields absent in all layers."""
    if issubclass(schema, Config) and schema.PRESET in given:
        node = given[schema.PRESET][-1]
        return schema.preset(node.value)
    return schema() if default is None else default


# Functions that write YAML.


def dump(name: str, config: Any) -> str:
    """Returns a configuration as YAML under one key, with default values."""
    key = yaml.ScalarNode(YAML_TAG + "str", name)
    root = yaml.MappingNode(
        YAML_TAG + "map", [(key, _node(config, type(config)))]
    )
    return yaml.serialize(root, Dumper=yaml.SafeDumper, allow_unicode=True)


def _node(value: Any, expected: Any) -> yaml.Node:
    base, _ = split(expected)
    options, protocols = alternatives(base)
    kind = type(value)
    if protocols and issubclass(kind, Config) and kind not in options:
        return _mapping_node(value, f"!{extension_name(kind)}")
    container = typing.get_origin(split(options[0])[0])
    if is_record(kind):
        tag = f"!{type(value).__name__}" if len(options) > 1 else ""
        return _mapping_node(value, tag)
    if value is not None and container is list:
        item = typing.get_args(split(options[0])[0])[0]
        nodes = [_node(entry, item) for entry in value]
        flow = all(isinstance(node, yaml.ScalarNode) for node in nodes)
        return yaml.SequenceNode(YAML_TAG + "seq", nodes, flow_style=flow)
    if value is not None and container is dict:
        item = typing.get_args(split(options[0])[0])[1]
        pairs = [(_scalar(key), _node(v, item)) for key, v in value.items()]
        return yaml.MappingNode(YAML_TAG + "map", pairs, flow_style=not pairs)
    return _scalar(str(value) if isinstance(value, Path) else value)


def _mapping_node(config: Any, tag: str) -> yaml.Node:
    """Returns an object's fields as a node, except fields that are None."""
    values = {
        name: (member(config, name), expected)
        for name, expected in _file_fields(type(config)).items()
    }
    pairs = [
        (_scalar(name), _node(value, expected))
        for name, (value, expected) in values.items()
        if value is not None or not is_struct(type(config))
    ]
    return yaml.MappingNode(tag or YAML_TAG + "map", pairs)


def _scalar(value: Any) -> yaml.Node:
    plain = value.item() if isinstance(value, np.generic) else value
    return yaml.representer.SafeRepresenter().represent_data(plain)
