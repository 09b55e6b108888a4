"""Reads Drake's own structs, such as `SimulatorConfig`, from YAML files.

pydrake lists the fields of each struct (`__fields__`). This module converts the
types of these fields into annotations like those of this package's dataclasses.
A vector becomes a list of numbers, whose length is that in a default struct.
Random distributions are excluded, since a scenario is deterministic.
"""

import copyreg
import dataclasses as dc
import functools
import types
import typing
from typing import Annotated, Any

import numpy as np
from annotated_types import Len
from pydrake.common.schema import Rotation

_RANDOM = ("Deterministic", "Gaussian", "Uniform", "_Invalid")
"""Prefixes of the class names of Drake's random distributions."""


def is_struct(kind: Any) -> bool:
    """Whether a type is one of Drake's structs."""
    return isinstance(kind, type) and hasattr(kind, "__fields__")


def is_record(kind: Any) -> bool:
    """Whether a type is a dataclass or one of Drake's structs."""
    return dc.is_dataclass(kind) or is_struct(kind)


def member(record: Any, name: str) -> Any:
    """Returns a field's value; for Drake's `Rotation`, the active variant."""
    value = getattr(record, name)
    return value.value if isinstance(value, Rotation) else value


@functools.cache
def struct_fields(struct: Any) -> dict[str, Any]:
    """Returns the types that a struct's fields have in files, as annotations.

    The function also makes structs of this class picklable, since
    configurations are sent to other processes.
    """
    new = struct()
    copyreg.pickle(struct, _reduced)
    return {
        f.name: _annotation(f.type, getattr(new, f.name))
        for f in struct.__fields__
    }


def _reduced(struct: Any) -> tuple[Any, ...]:
    """Returns the constructor and the state of a struct, for `pickle`."""
    names = struct_fields(type(struct))
    return _restored, (type(struct), {n: member(struct, n) for n in names})


def _restored(kind: type, values: dict[str, Any]) -> Any:
    struct = kind()
    for name, value in values.items():
        setattr(struct, name, value)
    return struct


def _annotation(expected: Any, default: Any) -> Any:
    container, inner = typing.get_origin(expected), typing.get_args(expected)
    if container in (typing.Union, types.UnionType):
        exact = [o for o in inner if not o.__name__.startswith(_RANDOM)]
        return typing.Union[*(_annotation(o, default) for o in exact)]
    if container in (list, dict):
        typed: Any = container
        return typed[*(_annotation(each, None) for each in inner)]
    if expected is np.ndarray:
        n = 0 if default is None else len(default)
        return Annotated[list[float], Len(n, n)] if n else list[float]
    return expected
