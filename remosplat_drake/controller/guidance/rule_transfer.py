"""Sends a selection rule to another process, part by part.

A rule may contain code of a user. For example, a lambda function cannot be
pickled, and the other process cannot import a class that is defined in a
notebook. So each part of the rule is also packed separately, and errors name
the part.
"""

import dataclasses as dc
import pickle
from collections.abc import Callable
from typing import TypeVar

from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.controller.guidance.selection_rule import SelectionRule

T = TypeVar("T")


class TransferError(RemoSplatError):
    """Raised if a part of a selection rule cannot be sent to a process."""


@dc.dataclass(frozen=True)
class PackedRule:
    """A selection rule as bytes.

    Attributes:
        parts: Name and pickle of each part that may be code of a user.
        whole: Pickle of the whole rule, without its arrays.
        arrays: The bytes of each array. They are immutable if the array is
            read-only, so that the unpacked array is read-only, too. For a
            writable array, Numba would compile kernels again.
    """

    parts: tuple[tuple[str, bytes], ...]
    whole: bytes
    arrays: tuple[bytes | bytearray, ...]


def pack_rule(rule: SelectionRule) -> PackedRule:
    """Packs a selection rule into bytes.

    Args:
        rule: The rule.

    Raises:
        TransferError: A part cannot be pickled. The error names the part.
    """
    parts: list[tuple[str, object]] = [("the rule of arrival", rule.arrived)]
    parts.append((type(rule.planner).__name__, rule.planner))
    parts += [(type(i).__name__, i) for i in rule.law.ingredients]
    packed = tuple(
        (name, _attempt(name, "be pickled", pickle.dumps, part))
        for name, part in parts
    )
    buffers: list[pickle.PickleBuffer] = []
    whole = pickle.dumps(rule, protocol=5, buffer_callback=buffers.append)
    views = [buffer.raw() for buffer in buffers]
    arrays = tuple(bytes(v) if v.readonly else bytearray(v) for v in views)
    return PackedRule(packed, whole, arrays)


def unpack_rule(packed: PackedRule) -> SelectionRule:
    """Unpacks a selection rule in another process.

    Args:
        packed: The rule as bytes.

    Raises:
        TransferError: A part cannot be loaded in this process. The error names
            the part.
    """
    try:
        return pickle.loads(packed.whole, buffers=packed.arrays)
    except Exception:
        for name, part in packed.parts:
            _attempt(name, "be imported there", pickle.loads, part)
        raise


def _attempt(name: str, done: str, step: Callable[..., T], part: object) -> T:
    try:
        return step(part)
    except Exception as error:
        raise TransferError(
            f"{name} cannot be sent to the look-ahead process: it cannot {done}"
            f" ({' '.join(str(error).split())}); put it into a module, or set"
            " controller.guidance.asynchronous to false"
        ) from error
