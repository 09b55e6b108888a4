"""Parses untrusted JSON, with bounds on nesting and on the size of numbers.

Python's own parser raises a RecursionError on deep nesting, accepts duplicate
keys, and returns integers of thousands of digits, which neither a float nor an
array can hold. This module reports deep nesting and duplicate keys as a
`FileError`, and converts integers of more than 64 bits to floats.
"""

import json
import math
import reprlib
from pathlib import Path
from typing import Any

from remosplat_drake.base.errors import FieldError, FileError

MAX_DEPTH = 32
"""Largest accepted nesting depth of lists and objects. All supported file
formats have fewer than ten levels."""

_WHOLE = range(-(2**63), 2**63)
_LONGEST = len(str(_WHOLE.start))


def parse_json(text: str | bytes, where: str | Path) -> Any:
    """Parses a JSON text.

    Integers that do not fit into 64 bits (int64) become floats. NaN and
    infinities are accepted, so that a later check can name the field in its
    error.

    Args:
        text: The text; bytes are UTF-8.
        where: The file; errors name it.

    Raises:
        FileError: The text is not JSON, is nested too deeply, or has a
            duplicate key.
    """
    try:
        document = json.loads(
            text, parse_int=_whole_number, object_pairs_hook=_object
        )
    except RecursionError as error:
        raise FileError(where, _TOO_DEEP) from error
    except ValueError as error:
        raise FileError(where, f"not JSON: {error}") from error
    if _is_deeper(document, MAX_DEPTH):
        raise FileError(where, _TOO_DEEP)
    return document


def read_json_object(path: Path) -> dict[str, Any]:
    """Reads a JSON file (UTF-8) that holds an object.

    Raises:
        FileError: The file cannot be read, is not valid JSON, or holds
            something other than an object; see `parse_json`.
    """
    try:
        data = path.read_bytes()
    except OSError as error:
        raise FileError(path, error.strerror or str(error)) from error
    return parse_json_object(data, path)


def parse_json_object(text: str | bytes, where: str | Path) -> dict[str, Any]:
    """Parses a JSON text that holds an object.

    Raises:
        FileError: The text is not valid JSON, or holds something other than an
            object; see `parse_json`.
    """
    document = parse_json(text, where)
    if not isinstance(document, dict):
        raise FileError(where, "expected a JSON object")
    return document


def as_number(where: object, field: str, value: object) -> float:
    """Returns a value of a JSON document, which must be a finite number.

    Raises:
        FieldError: The value is not a finite number. The error names `where`
            and `field`.
    """
    if (
        isinstance(value, bool)
        or not isinstance(value, (int, float))
        or not math.isfinite(value)
    ):
        raise FieldError(
            str(where), field, f"expected a number, got {shown(value)}"
        )
    return float(value)


def as_whole_number(
    where: object, field: str, value: object, least: int, most: int
) -> int:
    """Returns a value of a JSON document, a whole number in [least, most].

    Raises:
        FieldError: The value is not a whole number, or is out of range. The
            error names `where` and `field`.
    """
    if (
        isinstance(value, bool)
        or not isinstance(value, int)
        or not least <= value <= most
    ):
        raise FieldError(
            str(where),
            field,
            f"expected a whole number from {least} to {most},"
            f" got {shown(value)}",
        )
    return value


def shown(value: object) -> str:
    """Formats a value for messages, shortened to one line."""
    return reprlib.repr(value)


_TOO_DEEP = (
    "not JSON that this program reads: it is "
    f"nested more than {MAX_DEPTH} levels deep"
)


def _whole_number(digits: str) -> int | float:
    if len(digits) <= _LONGEST and int(digits) in _WHOLE:
        return int(digits)
    return float(digits)


def _object(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    document = dict(pairs)
    if len(document) < len(pairs):
        seen: set[str] = set()
        for key, _ in pairs:
            if key in seen:
                raise ValueError(f"the key {shown(key)} appears twice")
            seen.add(key)
    return document


def _is_deeper(document: Any, levels: int) -> bool:
    """Whether lists and objects are nested deeper than `levels`."""
    containers = [document] if isinstance(document, (dict, list)) else []
    for _ in range(levels):
        containers = [
            child
            for container in containers
            for child in (
                container.values() if isinstance(container, dict) else container
            )
            if isinstance(child, (dict, list))
        ]
    return bool(containers)
