"""Parses YAML into PyYAML nodes with line numbers.

The size of a file, its nesting and the expansion of its aliases are limited. So
reading takes a short time for any file.
"""

import functools
import re
import typing
from pathlib import Path
from typing import Any

import yaml

from remosplat_drake.base.errors import FieldError, FileError
from remosplat_drake.base.ranges import joined, shown

MOST_BYTES = 8 * 2**20
"""Largest accepted file size [bytes]. Larger files would take minutes to
parse."""

MOST_NODES = 2_000_000
"""Largest accepted number of values in a document, after aliases are
expanded."""

DEEPEST = 40
"""Largest accepted nesting depth of lists and mappings."""

YAML_TAG = "tag:yaml.org,2002:"
"""Prefix of the tags of YAML's own types."""


def read_text(path: Path) -> str:
    """Reads a text file (UTF-8).

    Raises:
        FileError: The file is missing, unreadable, too large or not text.
    """
    try:
        with path.open("rb") as file:
            data = file.read(MOST_BYTES + 1)
    except OSError as error:
        raise FileError(path, error.strerror or str(error)) from error
    except ValueError as error:
        raise FileError(path, str(error)) from error
    if len(data) > MOST_BYTES:
        raise FileError(
            path, f"is larger than {MOST_BYTES // 2**20} MiB, the limit"
        )
    try:
        return data.decode()
    except UnicodeDecodeError as error:
        raise FileError(path, "not a text file") from error


class _Loader(yaml.SafeLoader):
    """PyYAML loader whose nodes have file and line, with limited nesting."""

    def __init__(self, text: str, where: str):
        super().__init__(text)
        self.name = where
        self._depth = 0

    def compose_node(self, parent: Any, index: Any) -> Any:
        self._depth += 1
        if self._depth > DEEPEST:
            raise yaml.MarkedYAMLError(
                None,
                None,
                f"nested more than {DEEPEST} levels deep",
                self.peek_event().start_mark,
            )
        node = super().compose_node(parent, index)
        self._depth -= 1
        return node


@functools.lru_cache(maxsize=64)
def compose(text: str, where: str) -> yaml.Node:
    """Parses YAML into the root node of its document.

    The most recent documents are cached, since a search for a scenario's name
    reads all shipped files. Callers must not change the nodes.

    Args:
        text: YAML text.
        where: The file or flag that contains the text, for errors.

    Raises:
        FileError: The text is not YAML, is empty, or has aliases that expand to
            too many values.
    """
    try:
        loader = _Loader(text, where)
        try:
            node = loader.get_single_node()
        finally:
            loader.dispose()
    # PyYAML raises errors of other packages for some invalid values.
    except (yaml.YAMLError, ValueError, OverflowError) as error:
        problem = " ".join(str(error).split())
        raise FileError(where, f"not YAML: {problem}") from error
    if node is None:
        raise FileError(where, "is empty")
    if _size(node, {}, where) > MOST_NODES:
        raise FileError(
            where, f"its aliases expand to more than {MOST_NODES} values"
        )
    return node


def _size(node: yaml.Node, known: dict[int, int], where: str) -> int:
    """Returns the number of nodes after expansion of aliases."""
    if isinstance(node, yaml.ScalarNode):
        return 1
    if id(node) not in known:
        known[id(node)] = -1
        total = 1
        for item in node.value:
            parts = item if isinstance(item, tuple) else (item,)
            total += sum(_size(part, known, where) for part in parts)
        known[id(node)] = total
    if known[id(node)] < 0:
        raise FileError(
            where, ("an alias refers to a value that contains the alias")
        )
    return known[id(node)]


def fields(node: yaml.Node, field: str) -> dict[str, tuple[Any, Any]]:
    """Returns a mapping's key and value nodes, keyed by the key's text.

    Args:
        node: The mapping.
        field: Path of the mapping inside its document, for errors.

    Raises:
        FieldError: The node is not a mapping, or a key is invalid.
    """
    name = field or "the document"
    if not isinstance(node, yaml.MappingNode):
        fail(node, name, "expected a mapping `key: value`")
    found: dict[str, tuple[Any, Any]] = {}
    for key, value in node.value:
        if not isinstance(key, yaml.ScalarNode):
            fail(key, name, "a key must be plain text")
        path = joined(field, key.value)
        if key.tag != YAML_TAG + "str":
            problem = f"a key must be text, got {shown(key.value)}"
            fail(key, path, f"{problem} (put it in quotes)")
        if key.value in found:
            fail(key, path, "appears twice")
        found[key.value] = key, value
    return found


def is_null(node: yaml.Node) -> bool:
    """Returns whether a node is null."""
    return node.tag == YAML_TAG + "null"


def line_of(node: yaml.Node) -> str:
    """Returns the file and line of a node, as `file:line`."""
    mark = node.start_mark
    return f"{mark.name}:{mark.line + 1}"


def fail(node: yaml.Node, field: str, problem: str) -> typing.NoReturn:
    """Raises a `FieldError` that names a node's file and line."""
    raise FieldError(line_of(node), " ".join(field.split()), problem)


# The functions below convert scalars, which PyYAML's nodes contain as text.

_SPECIAL = re.compile(r"^([-+]?)\.(?=inf|nan)", re.IGNORECASE)
"""Regular expression for the dot in YAML's spellings .inf, -.inf and .nan."""

_OCTAL = re.compile(r"[-+]?0[0-9_]+")

_SWITCHES = yaml.SafeLoader.bool_values


def scalar(node: yaml.ScalarNode, kind: type, field: str) -> Any:
    """Converts a scalar node to a Python value.

    Args:
        node: The scalar.
        kind: One of float, int, bool, str and Path.
        field: Path of the field, for errors.

    Returns:
        The value; None if the scalar is of another kind.

    Raises:
        FieldError: A number is written with leading zeros, which YAML reads as
            octal.
    """
    tag = node.tag.removeprefix(YAML_TAG)
    if kind in (float, int) and not node.style and _OCTAL.fullmatch(node.value):
        fail(
            node,
            field,
            (
                f"{shown(node.value)}: YAML reads a number with "
                "leading zeros as octal; remove the zeros"
            ),
        )
    if kind is float:
        return _number(node)
    if kind is int and tag == "int":
        return _whole_number(node)
    if kind is bool and tag == "bool":
        return _SWITCHES.get(node.value.lower())
    if kind in (str, Path) and tag == "str":
        return kind(node.value)
    return None


def _number(node: yaml.ScalarNode) -> float | None:
    """Returns the number that a plain scalar represents.

    The function accepts 1e-3, which is a number in YAML 1.2 but not in YAML
    1.1.
    """
    if node.style:
        return None
    try:
        return float(_SPECIAL.sub(r"\1", node.value))
    except ValueError:
        return None


def _whole_number(node: yaml.ScalarNode) -> int | None:
    try:
        return int(node.value.replace("_", ""), 0)
    except ValueError:
        return None
