"""Drake's own structs as fields of files, `SimulatorConfig` for example.

pydrake tells of each struct which fields it has (`__fields__`). Their types
become annotations as ours are: a vector is a list of numbers, as long as that
of a new struct, and random values are left out, for a scenario says exactly
what is where.
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
"""How the names of Drake's distributions begin."""


def is_struct(kind: Any) -> bool:
    """Whether a type is one of Drake's structs."""
    return isinstance(kind, type) and hasattr(kind, "__fields__")


def is_record(kind: Any) -> bool:
    """Whether a type has named fields, as dataclasses and structs have."""
    return dc.is_dataclass(kind) or is_struct(kind)


def member(record: Any, name: str) -> Any:
    """The value of a field; of Drake's rotations the kind that was chosen."""
    value = getattr(record, name)
    return value.value if isinstance(value, Rotation) else value


@functools.cache
def struct_fields(struct: Any) -> dict[str, Any]:
    """The annotations of a struct's fields, in terms that files have.

    From here on, structs of this kind can be pickled: configurations travel to
    other processes.
    """
    new = struct()
    copyreg.pickle(struct, _reduced)
    return {
        f.name: _annotation(f.type, getattr(new, f.name))
        for f in struct.__fields__
    }


def _reduced(struct: Any) -> tuple[Any, ...]:
    """What `pickle` keeps of a struct."""
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
