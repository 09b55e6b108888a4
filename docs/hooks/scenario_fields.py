"""Generation of the reference of all scenario fields from dataclasses."""

import ast
import dataclasses as dc
import inspect
import math
import re
import textwrap
import typing
from collections.abc import Iterator
from typing import Any

from annotated_types import Len

from remosplat_drake.base import ranges
from remosplat_drake.base.drake_structs import is_struct
from remosplat_drake.base.ranges import OneOf, Unbounded

_PLAIN = {
    bool: "true or false",
    float: "number",
    int: "whole number",
    str: "text",
}
_UNIT = re.compile(r"\s*\[([\w/^%, ]+)\](?:,(?= \[))?")
"""Pattern of units in a comment, such as "Bounds on speeds [m/s], [rad/s]."."""


@dc.dataclass(frozen=True)
class FieldRow:
    """One field of a configuration, as text.

    Attributes:
        name: The field's name in a scenario.
        kind: The kind of its value, for example "number".
        default: The default value.
        range: The valid values.
        unit: The unit of its numbers.
        meaning: The comment above the field in the source.
        configs: The dataclasses that the field may contain.
    """

    name: str
    kind: str
    default: str
    range: str
    unit: str
    meaning: str
    configs: tuple[type, ...]


def reference_of(root: type) -> str:
    """Returns Markdown with one section for each dataclass within `root`."""
    places: dict[type, list[str]] = {}
    for schema, place in _walk(root, ""):
        places.setdefault(schema, []).append(place)
    return "\n".join(_section(schema, at) for schema, at in places.items())


def _walk(schema: type, place: str) -> Iterator[tuple[type, str]]:
    yield schema, place
    for row in field_rows(schema):
        for config in row.configs:
            yield from _walk(config, ranges.joined(place, row.name))


def _section(schema: type, places: list[str]) -> str:
    name = schema.__name__
    lines = [f"## {name} {{ #{name} }}", "", _first_paragraph(schema), ""]
    where = ", ".join(f"`{place}`" for place in places if place)
    if where:
        lines += [f"Found at {where}.", ""]
    lines += [
        "| field | holds | default | range | meaning |",
        "|---|---|---|---|---|",
    ]
    for row in field_rows(schema):
        kind = f"{row.kind} [{row.unit}]" if row.unit else row.kind
        cells = [f"`{row.name}`", kind, row.default, row.range, row.meaning]
        lines.append("| " + " | ".join(map(_cell, cells)) + " |")
    return "\n".join([*lines, ""])


def _cell(text: str) -> str:
    return text.replace("|", "\\|")


def _first_paragraph(schema: type) -> str:
    text = inspect.getdoc(schema) or ""
    return " ".join(text.partition("\n\n")[0].split())


def field_rows(schema: type) -> list[FieldRow]:
    """Returns all fields that a file may set, in the order of the source."""
    comments = field_comments(schema)
    rows = []
    for field in dc.fields(schema):
        if field.metadata.get("yaml") is False:
            continue
        expected = ranges.field_types(schema)[field.name]
        kind, configs = _kind(expected)
        meaning, unit = _split_unit(comments.get(field.name, ""))
        if not meaning:
            meaning = " ".join(map(_first_paragraph, configs))
        rows.append(
            FieldRow(
                field.name,
                kind,
                _default(field, configs),
                _range(expected),
                unit,
                meaning,
                configs,
            )
        )
    return rows


def field_comments(schema: type) -> dict[str, str]:
    """Returns the comment above each field, inherited fields first.

    A field without a comment has the comment of the previous field, if both
    are of the same kind.
    """
    comments: dict[str, str] = {}
    for base in reversed(schema.__mro__):
        if dc.is_dataclass(base):
            comments |= _own_comments(base)
    return comments


def _own_comments(schema: type) -> dict[str, str]:
    source = textwrap.dedent(inspect.getsource(schema))
    lines = source.splitlines()
    comments: dict[str, str] = {}
    end, last, shared_by = 0, "", None
    for node in typing.cast(ast.ClassDef, ast.parse(source).body[0]).body:
        if isinstance(node, ast.AnnAssign):
            name = typing.cast(ast.Name, node.target).id
            above = (line.strip(" #") for line in lines[end : node.lineno - 1])
            text = " ".join(filter(None, above))
            kind = _kind(ranges.field_types(schema)[name])
            if text or kind != shared_by:
                last, shared_by = text, kind
            comments[name] = last
        end = node.end_lineno or 0
    return comments


def _split_unit(comment: str) -> tuple[str, str]:
    """Splits a comment into the text without units, and the units."""
    return _UNIT.sub("", comment), ", ".join(_UNIT.findall(comment))


def _kind(expected: Any) -> tuple[str, tuple[type, ...]]:
    base, _ = ranges.split(expected)
    kinds, configs = [], []
    for option in ranges.choices(base):
        option, _ = ranges.split(option)
        if option is type(None):
            continue
        if dc.is_dataclass(option):
            name = typing.cast(type, option).__name__
            tag = "!" if len(ranges.choices(base)) > 1 else ""
            is_choice = tag and type(None) not in ranges.choices(base)
            shown = f"`!{name}`" if is_choice else name
            kinds.append(f"[{shown}](#{name})")
            configs.append(option)
        elif typing.get_origin(option) in (list, dict):
            *_, inner = typing.get_args(option)
            kind, found = _kind(inner)
            holder = "list" if typing.get_origin(option) is list else "mapping"
            kinds.append(f"{holder} of {_plural(kind)}")
            configs += found
        else:
            kinds.append(_PLAIN.get(option) or _foreign(option))
    return " or ".join(kinds), tuple(configs)


def _foreign(option: Any) -> str:
    name = getattr(option, "__name__", "any")
    if is_struct(option):
        return f"Drake's `{name}`"
    is_protocol = getattr(option, "_is_protocol", False)
    return f"one's own {name}" if is_protocol else name


def _plural(kind: str) -> str:
    if kind in ("number", "whole number"):
        return kind + "s"
    if kind.startswith("list of"):
        return "lists" + kind.removeprefix("list")
    return kind


def _default(field: dc.Field, configs: tuple[type, ...]) -> str:
    if field.default is not dc.MISSING:
        value = field.default
    elif field.default_factory is not dc.MISSING:
        value = field.default_factory()
    else:
        return "required"
    if dc.is_dataclass(value):
        name = type(value).__name__
        return f"`!{name}`" if len(configs) > 1 else ""
    return _value(value)


def _value(value: Any) -> str:
    if value is None:
        return "absent"
    if isinstance(value, bool):
        return f"`{str(value).lower()}`"
    if value == "":
        return "empty"
    if isinstance(value, float):
        return f"`{value:g}`" if math.isfinite(value) else f"`{value}`"
    if isinstance(value, list):
        items = (_value(item).strip("`") for item in value)
        return f"`[{', '.join(items)}]`"
    return f"`{value}`"


def _range(expected: Any) -> str:
    base, markers = ranges.split(expected)
    found = [text for text in map(_in_words, markers) if text]
    for option in ranges.choices(base):
        if option is base:
            inner = typing.get_args(option)[-1:]
            found += [f"each {text}" for text in map(_range, inner) if text]
        else:
            found += [text for text in [_range(option)] if text]
    return "; ".join(dict.fromkeys(found))


def _in_words(marker: Any) -> str:
    if isinstance(marker, OneOf):
        return ", ".join(f"`{name}`" for name in marker.names)
    if isinstance(marker, Unbounded):
        return f"any: {marker.reason}"
    if isinstance(marker, Len):
        return _length(marker)
    bounds = [_bound(marker, *two) for two in (("gt", "ge"), ("lt", "le"))]
    return _interval(*bounds)


def _length(length: Len) -> str:
    least, most = length.min_length, length.max_length
    if least == most:
        return f"{least} of them"
    if most is None:
        return f"at least {least} of them"
    return f"{least} to {most:,} of them"


def _bound(marker: Any, open_end: str, closed_end: str) -> tuple[bool, Any]:
    """Returns whether the bound itself is valid, and the bound."""
    closed = getattr(marker, closed_end, None)
    return closed is not None, (
        getattr(marker, open_end, None) if closed is None else closed
    )


def _interval(lower: tuple[bool, Any], upper: tuple[bool, Any]) -> str:
    (has_low, low), (has_high, high) = lower, upper
    if low is None and high is None:
        return ""
    if high is None:
        return f"{'≥' if has_low else '>'} {low:g}"
    if low is None:
        return f"{'≤' if has_high else '<'} {high:g}"
    return (
        f"{'[' if has_low else '('}{low:g}, {high:g}{']' if has_high else ')'}"
    )
