"""Checks values against ranges that are declared together with fields.

    gain: Annotated[float, Interval(gt=0, le=100)] = 4.0

The markers in `Annotated` are those of the package `annotated-types`, and this
module's `OneOf` and `Unbounded`. Every `Config` is checked when it is created,
and again before it is used, since its fields may have been assigned in between.
`strict_yaml` checks every value of a file, so that its errors name the line.
For Drake's structs, this module checks only that numbers are finite; Drake
checks everything else.
"""

import dataclasses as dc
import functools
import inspect
import math
import numbers
import types
import typing
from collections.abc import Collection, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any, ClassVar, Self

import numpy as np
from annotated_types import Ge, Gt, Interval, Le, Len, Lt

from remosplat_drake.base.drake_structs import (
    is_record,
    is_struct,
    member,
    struct_fields,
)
from remosplat_drake.base.errors import FieldError, unknown_name

_SHOWN = 60
"""Messages show at most this many characters of an invalid value."""


@dc.dataclass(frozen=True)
class OneOf:
    """Marker of a text field whose value must be one of several names.

    Attributes:
        names: The valid names.
        kind: The kind of things that have these names. For example, "backend"
            gives messages such as "unknown backend".
    """

    names: Collection[str]
    kind: str = "choice"


@dc.dataclass(frozen=True)
class Unbounded:
    """Marker of a number field for which any finite value is valid.

    Attributes:
        reason: The reason why the field needs no range.
    """

    reason: str


Coordinate = Annotated[float, Interval(ge=-1e4, le=1e4)]
"""A coordinate of a point in a scene [m]."""

Position = Annotated[list[Coordinate], Len(3, 3)]
"""A point x, y, z [m]."""

JointPosition = Annotated[float, Interval(ge=-100, le=100)]
"""Position of a revolute joint [rad] or of a prismatic joint [m]."""

Cosine = Annotated[float, Interval(ge=-2, le=2)]
"""Type of an entry of a rotation matrix. `PoseConfig` checks the whole
matrix."""

Seed = Annotated[int, Interval(ge=0, lt=2**63)]
"""Seed of a random number generator."""

AngleDeg = Annotated[float, Interval(ge=-360, le=360)]
"""An angle from -360 to 360 [deg]."""

RollPitchYawDeg = Annotated[list[AngleDeg], Len(3, 3)]
"""Roll, pitch and yaw [deg], as in Drake's `RollPitchYaw`."""


class Config:
    """Base class of dataclasses whose values are checked against their ranges.

    Attributes:
        PRESET: Name of the field that selects a preset, a set of defaults for
            the other fields; empty if there are no presets.
        MODULES: Name of the field that contains the folder of extensions, as a
            path relative to the file; empty if extensions are in the folder of
            the file.

    Example:
        >>> import remosplat_drake as rs
        >>> import dataclasses
        >>> from typing import Annotated
        >>> from annotated_types import Interval
        >>> @dataclasses.dataclass
        ... class Gain(rs.Config):
        ...     gain: Annotated[float, Interval(gt=0)] = 1.0
        >>> Gain(gain=-1.0)
        Traceback (most recent call last):
        ...
        remosplat_drake.base.errors.FieldError: Gain: gain: must be positive...
    """

    PRESET: ClassVar[str] = ""
    MODULES: ClassVar[str] = ""

    @classmethod
    def preset(cls, name: str) -> Self:
        """Returns the values that a preset gives to the other fields.

        Args:
            name: A valid value of the field `PRESET`.
        """
        raise NotImplementedError

    def check(self) -> Iterator[tuple[str, str]]:
        """Checks relations between fields; each field by itself is valid.

        Yields:
            The name of a field that is not valid, and a description of the
            problem.
        """
        yield from ()

    def __post_init__(self):
        """Checks all values.

        Raises:
            FieldError: A value is invalid; the error names the class and the
                field.
        """
        check_ranges(self)


def check_ranges(config: Any, where: str = "", field: str = "") -> None:
    """Checks all values of a configuration, and of nested configurations.

    Args:
        config: A `Config`, or one of Drake's structs.
        where: The file or flag that contains the configuration; errors name it.
            If it is empty, errors name the configuration's class.
        field: Path of the configuration inside `where`; empty if it is the
            whole document.

    Raises:
        FieldError: A value is invalid. The error names the value's field.
    """
    where = where or type(config).__name__
    for name, expected in field_types(type(config)).items():
        _check(member(config, name), expected, where, joined(field, name))
    if is_struct(type(config)):
        return
    for name, problem in config.check():
        raise FieldError(where, joined(field, name), problem)


def _check(value: Any, expected: Any, where: str, field: str) -> None:
    base, markers = split(expected)
    if value is None and type(None) in choices(base):
        return
    options, protocols = alternatives(base)
    if protocols and isinstance(value, Config) and type(value) not in options:
        problem = misfit(type(value), protocols)
        if problem:
            raise FieldError(where, field, f"{type(value).__name__} {problem}")
        return check_ranges(value, where, field)
    if not options or any(map(is_record, options)):
        if not isinstance(value, tuple(options)):
            names = [option.__name__ for option in options]
            names += ["a Config class of another package"] if protocols else []
            problem = f"expected {' or '.join(names)}, got {shown(value)}"
            raise FieldError(where, field, problem)
        if is_record(type(value)):
            check_ranges(value, where, field)
        return None
    if options[0] is not base:
        return _check(value, options[0], where, field)
    problem = kind_problem(value, base) or range_problem(value, markers)
    if problem:
        raise FieldError(where, field, problem)
    inner = typing.get_args(base)
    if isinstance(value, Mapping):
        for key, item in value.items():
            _check(item, inner[1], where, joined(field, key))
    elif inner:
        for i, item in enumerate(typing.cast(Sequence, value)):
            _check(item, inner[0], where, f"{field}[{i}]")


@functools.cache
def field_types(schema: type) -> dict[str, Any]:
    """Returns the annotations of the fields of a dataclass or Drake struct."""
    if is_struct(schema):
        return struct_fields(schema)
    hints = typing.get_type_hints(schema, include_extras=True)
    return {f.name: hints[f.name] for f in dc.fields(schema)}


def split(expected: Any) -> tuple[Any, tuple[Any, ...]]:
    """Splits an annotation into its type and the markers of `Annotated`."""
    if typing.get_origin(expected) is Annotated:
        base, *markers = typing.get_args(expected)
        return base, tuple(markers)
    return expected, ()


def choices(expected: Any) -> list[Any]:
    """Returns the members of a union; of any other type, the type itself."""
    if typing.get_origin(expected) in (typing.Union, types.UnionType):
        return list(typing.get_args(expected))
    return [expected]


def alternatives(expected: Any) -> tuple[list[Any], list[type]]:
    """Splits a union, without None, into its classes and its protocols.

    If a field's annotation contains a protocol, the field accepts
    configurations of other packages; see `extensions.py`.
    """
    options = [o for o in choices(expected) if o is not type(None)]
    protocols = [o for o in options if getattr(o, "_is_protocol", False)]
    return [o for o in options if o not in protocols], protocols


def misfit(kind: type, protocols: Sequence[type]) -> str:
    """Returns the reason why a class does not fit a field's protocols.

    The class must have all methods of one of the protocols, with equal numbers
    of arguments. If it does, the returned text is empty.
    """
    wanted = []
    for protocol in protocols:
        methods = {
            name: list(inspect.signature(method).parameters)[1:]
            for name, method in vars(protocol).items()
            if not name.startswith("_")
        }
        if all(_takes(kind, name, n) for name, n in methods.items()):
            return ""
        wanted += [f"{name}({', '.join(n)})" for name, n in methods.items()]
    return f"has no method {' or '.join(wanted)}"


def _takes(kind: type, name: str, arguments: Sequence[str]) -> bool:
    try:
        method = inspect.signature(getattr(kind, name))
        method.bind(None, *arguments)
    except (AttributeError, TypeError, ValueError):
        return False
    return True


def schema_problem(schema: type) -> str:
    """Returns the reason why files cannot contain a dataclass; "" for none."""
    try:
        types = field_types(schema)
    except Exception as error:
        return f"has an invalid annotation: {error}"
    for f in dc.fields(schema):
        if f.default is dc.MISSING and f.default_factory is dc.MISSING:
            return f"needs a default for its field {f.name!r}"
        if not _is_readable(types[f.name]):
            return f"has a field {f.name!r} of a type that a file cannot hold"
    return ""


def _is_readable(expected: Any) -> bool:
    base, _ = split(expected)
    options, protocols = alternatives(base)
    if protocols or len(options) > 1 or options[0] is not base:
        return all(map(_is_readable, options))
    container, inner = typing.get_origin(base), typing.get_args(base)
    if container in (list, dict):
        return _is_readable(inner[-1])
    if is_struct(base):
        return all(map(_is_readable, field_types(base).values()))
    if dc.is_dataclass(base):
        return not schema_problem(typing.cast(type, base))
    return base in KINDS and base not in (list, dict)


def joined(field: str, name: str) -> str:
    """Returns a field's path from its parent's path and its own name."""
    return f"{field}.{name}" if field else str(name)


def shown(value: object) -> str:
    """Formats a value for messages, shortened to one line."""
    try:
        text = " ".join(repr(value).split())
    except ValueError:  # An integer of thousands of digits.
        return "a number of thousands of digits"
    return text if len(text) <= _SHOWN else text[:_SHOWN] + "..."


KINDS: dict[Any, tuple[str, Any]] = {
    float: ("a number", numbers.Real),
    int: ("a whole number", numbers.Integral),
    bool: ("true or false", (bool, np.bool_)),
    str: ("text", str),
    Path: ("a path", (str, Path)),
    list: ("a list", (Sequence, np.ndarray)),
    dict: ("a mapping", Mapping),
}
"""The scalar types of fields. For each type: its name in messages, and the
Python classes whose objects it accepts."""


def kind_problem(value: object, base: Any) -> str:
    """Returns the reason why a value is not of a type; empty if it is."""
    base = typing.get_origin(base) or base
    name, classes = KINDS[base]
    is_switch = isinstance(value, (bool, np.bool_))
    if not isinstance(value, classes) or is_switch != (base is bool):
        return f"expected {name}, got {shown(value)}"
    if base is list and isinstance(value, str):
        return f"expected {name}, got {shown(value)}"
    if base is float:
        try:
            is_finite = math.isfinite(value)  # pyright: ignore
        except OverflowError:
            is_finite = False
        if not is_finite:
            return f"must be finite, got {shown(value)}"
    return ""


def range_problem(value: Any, markers: Sequence[Any]) -> str:
    """Returns the reason why a value is out of range; empty if it is in range.

    Args:
        value: A value of the right type.
        markers: The markers of its field, such as `Interval` and `OneOf`.
    """
    for marker in markers:
        if isinstance(marker, OneOf):
            if value not in marker.names:
                return unknown_name(marker.kind, value, marker.names)
        elif isinstance(marker, Len):
            problem = _length_problem(len(value), marker)
            if problem:
                return problem
        elif not isinstance(marker, Unbounded):
            problem = _interval_problem(value, _interval(marker))
            if problem:
                return problem
    return ""


def _length_problem(n: int, marker: Len) -> str:
    least, most = marker.min_length, marker.max_length
    if n >= least and (most is None or n <= most):
        return ""
    if n < least and least == 1:
        return "must not be empty"
    if least == most:
        return f"expected {least} entries, got {n}"
    if most is None:
        return f"expected at least {least} entries, got {n}"
    return f"expected {least} to {most} entries, got {n}"


def _interval(marker: Any) -> Interval:
    if isinstance(marker, (Gt, Ge, Lt, Le)):
        return Interval(**dc.asdict(marker))
    return marker


def _interval_problem(value: Any, bounds: Interval) -> str:
    low = bounds.gt if bounds.ge is None else bounds.ge
    high = bounds.lt if bounds.le is None else bounds.le
    # The comparisons are written so that NaN is out of range.
    above = low is None or (value > low if bounds.ge is None else value >= low)
    below = high is None or (
        value < high if bounds.le is None else value <= high
    )
    if above and below:
        return ""
    return f"{_in_words(low, high, bounds, above)}, got {shown(value)}"


def _in_words(low: Any, high: Any, bounds: Interval, above: bool) -> str:
    is_open = bounds.ge is None
    if low == 0 and not above:
        return "must be positive" if is_open else "must not be negative"
    if high == 0 and above and low is None:
        return "must not be positive"
    if high is None:
        return f"must {'exceed' if is_open else 'be at least'} {low:g}"
    if low is None:
        return f"must be {'at most' if bounds.lt is None else 'below'} {high:g}"
    opening = "(" if is_open else "["
    closing = ")" if bounds.le is None else "]"
    return f"must lie in {opening}{low:g}, {high:g}{closing}"
