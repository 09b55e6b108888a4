"""`JsonFields`: reads an untrusted JSON object field by field, with checks."""

import math

from remosplat_drake.base.errors import FieldError
from remosplat_drake.base.strict_json import parse_json

_SHOWN = 40
"""Messages show at most this many characters of an invalid value."""

_LARGEST = 2**53
"""Largest integer that every program reads exactly. Many programs read numbers
as floats, which hold integers of up to 53 bits."""


class JsonFields:
    """A JSON object whose fields are checked when they are read.

    All methods except `has` and `names` raise a `FieldError` if the field is
    missing, has another type or is out of range. The error names the file and
    the field.
    """

    def __init__(self, value: object, where: str, field: str = ""):
        """Wraps a value that must be an object.

        Args:
            value: A value from `parse_json`.
            where: The file; errors name it.
            field: Path of the value inside the file; empty for the whole file.

        Raises:
            FieldError: The value is not an object.
        """
        self.where = where
        self._field = field
        if not isinstance(value, dict):
            raise FieldError(
                where,
                field or "the document",
                f"expected an object, got {_short(value)}",
            )
        self._values: dict[str, object] = value

    def error(self, name: str, problem: str) -> FieldError:
        """Returns an error about a field; the caller raises it."""
        return FieldError(self.where, self._name(name), problem)

    def has(self, name: str) -> bool:
        """Returns whether a field exists and is not null."""
        return self._values.get(name) is not None

    def names(self) -> list[str]:
        """Returns the names of all fields."""
        return list(self._values)

    def text(self, name: str) -> str:
        """Returns a field that holds a string. Lone surrogates are an error."""
        return self._as_text(name, self._values.get(name))

    def flag(self, name: str) -> bool:
        """Returns a field that holds true or false."""
        value = self._values.get(name)
        if not isinstance(value, bool):
            raise self._wrong(name, "true or false", value)
        return value

    def number(
        self,
        name: str,
        least: float = -math.inf,
        most: float = math.inf,
    ) -> float:
        """Returns a field that holds a finite number in [least, most]."""
        value = self._as_number(name, self._values.get(name))
        if not least <= value <= most:
            low = value < least
            limit = f"at least {least:g}" if low else f"at most {most:g}"
            raise self.error(name, f"must be {limit}, got {value:g}")
        return value

    def whole(self, name: str, least: int = 0, most: int = _LARGEST) -> int:
        """Returns a field that holds a whole number in [least, most]."""
        return self._as_whole(name, self._values.get(name), least, most)

    def numbers(self, name: str, count: int | None = None) -> list[float]:
        """Returns a field that holds a list of finite numbers.

        Args:
            name: Name of the field.
            count: The required length of the list; None allows any.
        """
        values = self._list(name)
        if count is not None and len(values) != count:
            raise self.error(name, f"expected {count} numbers")
        return [
            self._as_number(f"{name}[{i}]", value)
            for i, value in enumerate(values)
        ]

    def wholes(self, name: str, least: int = 0) -> list[int]:
        """Returns a field that holds a list of whole numbers >= `least`."""
        return [
            self._as_whole(f"{name}[{i}]", value, least, _LARGEST)
            for i, value in enumerate(self._list(name))
        ]

    def texts(self, name: str) -> tuple[str, ...]:
        """Returns a field that holds a list of strings."""
        return tuple(
            self._as_text(f"{name}[{i}]", value)
            for i, value in enumerate(self._list(name))
        )

    def inner(self, name: str) -> "JsonFields":
        """Returns a field that holds an object."""
        return JsonFields(self._values.get(name), self.where, self._name(name))

    def inners(self, name: str) -> list["JsonFields"]:
        """Returns a field that holds a list of objects."""
        return [
            JsonFields(value, self.where, self._name(f"{name}[{i}]"))
            for i, value in enumerate(self._list(name))
        ]

    def _list(self, name: str) -> list:
        value = self._values.get(name)
        if not isinstance(value, list):
            raise self._wrong(name, "a list", value)
        return value

    def _as_text(self, name: str, value: object) -> str:
        # A lone surrogate is valid in JSON, but cannot be encoded as UTF-8, so
        # it can neither be printed nor saved.
        if not isinstance(value, str) or not _is_printable(value):
            raise self._wrong(name, "text", value)
        return value

    def _as_number(self, name: str, value: object) -> float:
        is_number = isinstance(value, (int, float))
        if not is_number or isinstance(value, bool) or not _is_finite(value):
            raise self._wrong(name, "a finite number", value)
        # An integer is not converted to a float, since messages would print 1
        # as 1.0.
        return value if abs(value) <= _LARGEST else float(value)

    def _as_whole(self, name: str, value: object, least: int, most: int) -> int:
        if not isinstance(value, int) or isinstance(value, bool):
            raise self._wrong(name, "a whole number", value)
        if not least <= value <= most:
            problem = f"must lie in [{least}, {most}], got {_short(value)}"
            raise self.error(name, problem)
        return value

    def _wrong(self, name: str, expected: str, value: object) -> FieldError:
        if name not in self._values and "[" not in name:
            return self.error(name, f"is missing; expected {expected}")
        return self.error(name, f"expected {expected}, got {_short(value)}")

    def _name(self, name: str) -> str:
        if not name.isprintable() or len(name) > _SHOWN:
            name = _short(name)
        return f"{self._field}.{name}" if self._field else name


def parse_fields(text: str | bytes, where: str) -> JsonFields:
    """Parses a JSON text that holds an object.

    Args:
        text: The JSON text; bytes are UTF-8.
        where: The file; errors name it.

    Raises:
        FileError: The text is not JSON.
        FieldError: The text holds something other than an object.
    """
    return JsonFields(parse_json(text, where), where)


def _short(value: object) -> str:
    """Formats a value for messages, on one line."""
    if isinstance(value, (dict, list)):
        return "an object" if isinstance(value, dict) else "a list"
    text = ascii(value)
    return text if len(text) <= _SHOWN else text[:_SHOWN] + "..."


def _is_finite(value: int | float) -> bool:
    try:
        return math.isfinite(value)
    except OverflowError:
        return False


def _is_printable(text: str) -> bool:
    try:
        text.encode()
    except UnicodeEncodeError:
        return False
    return True
