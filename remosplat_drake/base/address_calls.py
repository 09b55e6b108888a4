"""Lets kernels call a user's functions, which are compiled separately.

By default, a kernel contains the code of the functions that it calls. When one
of these functions changes, the kernel is compiled again, which takes minutes.
To avoid this for a user's function, the function is compiled separately, and
the kernel calls it by its address. The function's settings and its argument are
named tuples, which the kernel passes in packed form; see `Packed`.
"""

import hashlib
from collections.abc import Callable
from functools import cache
from typing import Any
from weakref import WeakValueDictionary

import numpy as np
from llvmlite import ir
from numba import config, types
from numba.extending import intrinsic

from remosplat_drake.base.kernels import callback, helper, overload
from remosplat_drake.base.kernels.packed import (
    Packed,
    PackedType,
    packed_type,
    packed_words,
    store_words,
)

DONE, RAISED, MISFIT = range(3)
"""Results of a call: the function returned (DONE), raised an exception
(RAISED), or did not run because it was compiled for other arguments
(MISFIT)."""

_WORD = ir.IntType(64)


class AddressedFunction:
    """A compiled function with settings, which kernels call by its address.

    The function takes two named tuples: its settings and its input. It is
    compiled once for all settings of the same type. Division by zero gives
    infinity or NaN, as in NumPy.

    Attributes:
        words: The addresses of the function and of its settings, for kernels,
            shape (2,).
    """

    __slots__ = ("__weakref__", "_function", "_settings", "words")

    def __init__(
        self,
        function: Callable[[Any, Any], None],
        settings: Packed,
        told: Packed,
    ):
        """Compiles the function.

        Args:
            function: The function.
            settings: Its settings.
            told: An example of the function's input; only its type is used.

        Raises:
            NumbaError: The function cannot be compiled.
        """
        self._function, self._settings, address = function, settings, 0
        if not config.DISABLE_JIT:
            kinds = settings._numba_type_, told._numba_type_
            address = _compiled(function, *kinds).address
        self.words = np.array([address, settings.address])
        _functions[settings.address] = self

    def __call__(self, told: Any) -> int:
        """Calls the original Python function, which is not compiled."""
        self._function(self._settings, told)
        return DONE


_functions: WeakValueDictionary[int, AddressedFunction] = WeakValueDictionary()


@cache
def _compiled(function: Callable, settings: PackedType, told: PackedType):
    function, fits = helper(function), _digest(told)

    def run(digest, settings, told):
        if digest != fits:
            return MISFIT
        try:
            function(settings, told)
        except Exception:
            return RAISED
        return DONE

    return callback(types.int64(types.int64, settings, told))(run)


def _digest(kind: types.Type) -> int:
    """Returns a number that is equal in all processes for the same type."""
    digest = hashlib.sha256(repr(kind).encode()).digest()
    return int.from_bytes(digest[:8], "little", signed=True)


def call_address(words, told) -> int:
    """Calls a function by its address, from within a kernel.

    Args:
        words: The `AddressedFunction.words`.
        told: The function's input, a named tuple.

    Returns:
        DONE, RAISED or MISFIT.
    """
    return _functions[words[1]](told)


@overload(call_address)
def _call_address(words, told):
    return lambda words, told: _call(  # pyright: ignore
        words[0], words[1], told
    )


@intrinsic
def _call(typing_context, function, settings, told):
    """The compiled form of `call_address`."""
    del typing_context

    def generate(context, builder, signature, arguments):
        del signature
        words = packed_words(context, builder, told, arguments[2])
        first = store_words(builder, words)
        # At this level, an address is passed as an integer.
        kind = ir.FunctionType(_WORD, [_WORD] * 3)
        called = builder.inttoptr(arguments[0], kind.as_pointer())
        digest = ir.Constant(_WORD, _digest(packed_type(told)))
        place = builder.ptrtoint(first, _WORD)
        return builder.call(called, [digest, arguments[1], place])

    return types.int64(types.int64, types.int64, told), generate
