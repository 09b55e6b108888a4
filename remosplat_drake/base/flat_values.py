"""Converts dataclasses of arrays to JSON text and arrays, and back.

Supported values are arrays, dataclasses, tuples, lists, numbers, strings and
None, nested in any way. `restore` rebuilds the original value, equal to the
last bit.
"""

import dataclasses as dc
import hashlib
import json
from collections.abc import Mapping
from typing import Any, TypeVar, get_args, get_type_hints

import numpy as np

from remosplat_drake.base.strict_json import parse_json

T = TypeVar("T")


def flatten(value: object) -> tuple[str, dict[str, np.ndarray]]:
    """Splits a value into a JSON text and the arrays that it holds.

    Raises:
        TypeError: The value holds an object of another type.
    """
    arrays: dict[str, np.ndarray] = {}
    return json.dumps(_flat(value, arrays)), arrays


def restore(kind: type[T], text: str, arrays: Mapping[str, np.ndarray]) -> T:
    """Rebuilds a value from the results of `flatten`.

    Args:
        kind: Dataclass of the value. `restore` creates only objects of this
            dataclass, and of the dataclasses in the annotations of its fields.
        text: The JSON text.
        arrays: The arrays.

    Raises:
        RemoSplatError: The text is not JSON, or a dataclass rejects the value
            of a field.
        LookupError: The text names an unknown array or dataclass.
        TypeError: The value is not an object of `kind`.
    """
    value = _restored(parse_json(text, "text"), arrays, _dataclasses(kind))
    if not isinstance(value, kind):
        raise TypeError(f"expected {kind.__name__}")
    return value


def digest(value: object) -> str:
    """Returns the SHA-256 of a value, in hexadecimal."""
    text, arrays = flatten(value)
    result = hashlib.sha256(text.encode())
    for array in arrays.values():
        result.update(f"{array.dtype.str}{array.shape}".encode())
        result.update(np.ascontiguousarray(array).tobytes())
    return result.hexdigest()


def _flat(value: object, arrays: dict[str, np.ndarray]) -> object:
    """Returns the value as JSON data and adds its arrays to `arrays`."""
    if value is None or isinstance(value, bool | int | float | str):
        return value
    if isinstance(value, np.generic):
        return value.item()
    if isinstance(value, np.ndarray):
        arrays[str(len(arrays))] = value
        return {"array": str(len(arrays) - 1)}
    if isinstance(value, tuple | list):
        items = [_flat(item, arrays) for item in value]
        return {"tuple" if isinstance(value, tuple) else "list": items}
    if dc.is_dataclass(value) and not isinstance(value, type):
        fields = {
            field.name: _flat(getattr(value, field.name), arrays)
            for field in dc.fields(value)
            if field.init
        }
        return {"dataclass": type(value).__name__, "fields": fields}
    raise TypeError(f"cannot store a value of type {type(value).__name__}")


def _restored(
    flat: Any, arrays: Mapping[str, np.ndarray], kinds: Mapping[str, type]
) -> object:
    if not isinstance(flat, dict):
        return flat
    if "array" in flat:
        return arrays[flat["array"]]
    if "dataclass" in flat:
        fields = {
            name: _restored(item, arrays, kinds)
            for name, item in flat["fields"].items()
        }
        return kinds[flat["dataclass"]](**fields)
    ((kind, items),) = flat.items()
    restored = (_restored(item, arrays, kinds) for item in items)
    return tuple(restored) if kind == "tuple" else list(restored)


def _dataclasses(kind: Any) -> dict[str, type]:
    """Returns a type and all dataclasses in it, keyed by name."""
    found: dict[str, type] = {}
    waiting = [kind]
    while waiting:
        hint = waiting.pop()
        waiting += get_args(hint)
        if not (dc.is_dataclass(hint) and isinstance(hint, type)):
            continue
        if hint.__name__ not in found:
            found[hint.__name__] = hint
            waiting += get_type_hints(hint).values()
    return found
