"""Reads and writes lists of kernels: argument types and compilation times.

With such a list, all kernels that a process needs can be compiled in parallel
on all cores, before the values of their arguments exist. The argument types in
a list are numbered, so that a type can refer to other types.
"""

import importlib
import json
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

from numba import types

from remosplat_drake.base.kernels.packed import PackedType
from remosplat_drake.base.kernels.references import found
from remosplat_drake.base.kernels.returns import named
from remosplat_drake.base.kernels.variant import Variant

_PACKAGE = "remosplat_drake."


class UnlistedTypeError(Exception):
    """Raised if the type of an argument cannot be written into a list."""


def listed(variants: Iterable[Variant]) -> str:
    """Returns a list of variants as text; each follows those that it calls.

    A variant that another process cannot find, such as one defined in a script,
    is omitted.
    """
    table, rows = _Table(), []
    for variant in _callees_first(variants):
        if variant.reference is not None:
            module, name, arguments = variant.reference
            module = module.removeprefix(_PACKAGE)
            numbers = [table.number(kind) for kind in arguments]
            rows.append([f"{module}:{name}", round(variant.time, 1), *numbers])
    kinds, kernels = (
        ",\n".join(map(json.dumps, part)) for part in (table.rows, rows)
    )
    return f'{{"types": [\n{kinds}\n],\n"kernels": [\n{kernels}\n]}}\n'


def read_list(path: Path) -> dict[Variant, float]:
    """Returns the variants of a list, and the compilation time of each [s].

    Entries of kernels that no longer exist are omitted.
    """
    content = json.loads(path.read_text())
    kinds: list[types.Type | None] = []
    for row in content["types"]:
        kinds.append(_type(row, kinds))
    times = {}
    for name, time, *numbers in content["kernels"]:
        module, name = name.split(":")
        arguments = tuple(kinds[number] for number in numbers)
        if None not in arguments:
            times[found((_PACKAGE + module, name, arguments))] = time  # pyright: ignore
    times.pop(None, None)
    return times


def _callees_first(variants: Iterable[Variant]) -> Iterator[Variant]:
    done: set[Variant] = set()

    def visit(variant):
        if variant not in done:
            done.add(variant)
            for used in variant.uses or ():
                yield from visit(used)
            yield variant

    for variant in variants:
        yield from visit(variant)


class _Table:
    """The argument types in a list, each after the types that it contains.

    Attributes:
        rows: Descriptions of the types, in order.
    """

    def __init__(self):
        self.rows: list[Any] = []
        self._numbers: dict[types.Type, int] = {}

    def number(self, kind: types.Type) -> int:
        """Returns the number of a type; adds the type if it is new."""
        if kind not in self._numbers:
            row = self._described(kind)
            self._numbers[kind] = len(self.rows)
            self.rows.append(row)
        return self._numbers[kind]

    def _described(self, kind: types.Type) -> Any:
        if isinstance(kind, PackedType | types.BaseNamedTuple):
            is_packed = isinstance(kind, PackedType)
            name = kind.kind if is_packed else kind.instance_class
            fields = kind.fields if is_packed else tuple(kind)
            return [
                "packed" if is_packed else "named",
                f"{name.__module__.removeprefix(_PACKAGE)}:{name.__qualname__}",
                *map(self.number, fields),
            ]
        if isinstance(kind, types.Array):
            return [
                "array",
                self.number(kind.dtype),
                kind.ndim,
                kind.layout,
                kind.mutable,
                kind.aligned,
            ]
        if isinstance(kind, types.BaseTuple):
            return ["tuple", *map(self.number, kind)]
        if isinstance(kind, types.Number | types.Boolean | types.NoneType):
            return str(kind)
        raise UnlistedTypeError(str(kind))


def _type(row: Any, kinds: list) -> types.Type | None:
    if isinstance(row, str):
        return getattr(types, row)
    what, *rest = row
    if what == "array":
        dtype, n_dim, layout, is_mutable, is_aligned = rest
        return types.Array(
            kinds[dtype], n_dim, layout, not is_mutable, aligned=is_aligned
        )
    numbers = rest if what == "tuple" else rest[1:]
    fields = tuple(kinds[number] for number in numbers)
    if None in fields:
        return None
    if what == "tuple":
        return types.BaseTuple.from_types(fields)
    module, name = rest[0].split(":")
    kind = getattr(importlib.import_module(_PACKAGE + module), name, None)
    if kind is None or len(kind._fields) != len(fields):
        return None
    if what == "packed":
        return PackedType(kind, fields)
    return named(kind, *fields)
