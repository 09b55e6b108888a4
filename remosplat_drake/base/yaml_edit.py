"""Sets values in a YAML text, and preserves all other characters."""

from pathlib import Path

import yaml

from remosplat_drake.base.errors import FieldError


def with_values(
    text: str, path: tuple[str, ...], values: dict[str, str], where: Path | str
) -> str:
    """Returns a YAML text with new values in one of its mappings.

    Comments, and the order and notation of all other values, are preserved. A
    missing mapping or field is added before its siblings.

    Args:
        text: A YAML document.
        path: Keys that lead to the mapping; the last one may be missing.
        values: The values as YAML text, keyed by field.
        where: The file, for errors.

    Raises:
        FieldError: The path leads to something other than a mapping.
    """
    root = yaml.compose(text, Loader=yaml.SafeLoader)
    node = _mapping(root, (), where)
    for depth, key in enumerate(path):
        found = _value(node, key)
        if found is None or _is_empty(found):
            content = ", ".join(f"{k}: {v}" for k, v in values.items())
            if found is None:
                return _with_fields(text, node, [f"{key}: {{{content}}}"])
            at = found.start_mark.index
            end = found.end_mark.index
            return f"{text[:at]} {{{content}}}{text[end:]}"
        node = _mapping(found, path[: depth + 1], where)
    # Replacements are made from the end of the text to its beginning, so that
    # the positions of later replacements stay valid.
    present = {k: v for k in values if (v := _value(node, k)) is not None}
    new = [f"{k}: {v}" for k, v in values.items() if k not in present]
    for key, old in sorted(
        present.items(), key=lambda item: -item[1].start_mark.index
    ):
        start, end = old.start_mark.index, _end(old)
        text = text[:start] + values[key] + text[end:]
    return _with_fields(text, node, new) if new else text


def _mapping(
    node: yaml.Node | None, path: tuple[str, ...], where: Path | str
) -> yaml.MappingNode:
    """Returns the node; raises an error unless it is a mapping without tag."""
    if not isinstance(node, yaml.MappingNode) or not node.tag.endswith(":map"):
        raise FieldError(
            str(where),
            ".".join(path),
            ("is not a plain mapping and cannot be edited: set it by hand"),
        )
    return node


def _value(node: yaml.MappingNode, key: str) -> yaml.Node | None:
    return next((v for k, v in node.value if k.value == key), None)


def _is_empty(node: yaml.Node) -> bool:
    return node.tag.endswith(":null")


def _end(node: yaml.Node) -> int:
    """Returns the position at which a value ends.

    For values in block style, PyYAML's end mark is not used, since it is at the
    next token, after comments and blank lines.
    """
    is_block = isinstance(node, yaml.CollectionNode) and not node.flow_style
    if not is_block or not node.value:
        return node.end_mark.index
    last = node.value[-1]
    return _end(last[1] if isinstance(last, tuple) else last)


def _with_fields(text: str, node: yaml.MappingNode, lines: list[str]) -> str:
    """Returns the text with new fields before all other fields of a mapping."""
    if node.flow_style:
        at = node.start_mark.index + 1
        comma = ", " if node.value else ""
        return f"{text[:at]}{', '.join(lines)}{comma}{text[at:]}"
    first = node.value[0][0].start_mark
    indent = "\n" + " " * first.column
    new = indent.join(lines)
    return f"{text[: first.index]}{new}{indent}{text[first.index :]}"
