"""Calls from compiled kernels back to Python.

Some results can be computed only in Python, for example those of Drake's
solvers, and those of maps and terms of the quadratic program from other
packages. For such a result, a kernel calls `call_python` with arrays and
numbers. A C function, which the kernel finds by its symbol, then calls the
Python function. The Python function writes its results into the arrays, or
returns the address of a `Packed`.

If the Python function raises an exception, `call_python` returns `FAILED`, and
the kernel continues with a safe branch. The exception is stored as
`PythonCalls.error`, so that the code that called the kernel can raise it.
"""

import ctypes
from collections.abc import Callable, Iterator
from itertools import count
from typing import Any

import numpy as np
from llvmlite import binding, ir
from numba import types
from numba.core import cgutils
from numba.core.errors import TypingError
from numba.extending import intrinsic

from remosplat_drake.base.kernels import overload
from remosplat_drake.base.kernels.packed import (
    Packed,
    PackedType,
    packed_field,
)

FAILED = -1
"""Result of a call whose Python function has raised an exception."""

_SYMBOL = "remosplat_drake_call_python"
_WORD = ir.IntType(64)
_KINDS = {types.float64: 0, types.int64: 1, types.boolean: 2}
_DTYPES = np.dtype(float), np.dtype(np.int64), np.dtype(bool)
_NUMBER = -1
"""Value that replaces an array's number of dimensions if a value is a
number."""


class Arguments:
    """A sequence of the arrays and numbers that a kernel passes to Python.

    A value is read from the kernel's memory when it is accessed. Arrays are
    views of this memory, and are valid until the Python function returns.
    """

    __slots__ = ("_words",)

    def __init__(self, address: int):
        size = ctypes.c_int64.from_address(address).value
        self._words = (ctypes.c_int64 * size).from_address(address)[:]

    def __getitem__(self, i: int) -> Any:
        """Returns value i. Each field of a named tuple counts as a value."""
        place = self._words[1 + i]
        kind, n_dim, first = self._words[place : place + 3]
        dtype = _DTYPES[kind]
        if n_dim == _NUMBER:
            return bool(first) if kind == 2 else _number(first, dtype)
        shape = self._words[place + 3 : place + 3 + n_dim]
        size = dtype.itemsize
        for length in shape:
            size *= length
        if not size:
            return np.empty(shape, dtype)
        memory = (ctypes.c_char * size).from_address(first)
        return np.ndarray(shape, dtype, memory)


def _number(word: int, dtype: np.dtype) -> Any:
    return np.array(word, np.int64).view(dtype).item()


class PythonCalls:
    """The Python functions that a kernel can call during one call of it.

        with PythonCalls(solve, look) as calls:
            kernel(..., calls.number)
        if calls.error is not None:
            raise calls.error

    Each function takes `Arguments`, the values that the kernel passes. The
    function returns an integer >= 0. To return a `Packed`, it returns the
    result of `handed`.

    Attributes:
        number: Number of this object, which the kernel passes to `call_python`.
        error: The first exception that a function raised; None if no function
            has raised an exception. After an exception, no function is called
            any more.
    """

    __slots__ = ("_functions", "_handed", "error", "number")

    def __init__(self, *functions: Callable[[Any], int]):
        """Registers the functions. Kernels refer to them by their index."""
        self._functions = functions
        self._handed: dict[int, Packed] = {}
        self.error: BaseException | None = None
        self.number = next(_numbers)

    def __enter__(self) -> "PythonCalls":
        _open[self.number] = self
        return self

    def __exit__(self, *_: object) -> None:
        del _open[self.number]
        # Dropping the functions breaks reference cycles. Such a cycle would
        # never be freed while a real robot's loop runs, since it runs without
        # garbage collection.
        self._functions, self._handed = (), {}

    def handed(self, packed: Packed) -> int:
        """Returns the address of a `Packed`, and keeps the `Packed` alive.

        Args:
            packed: The `Packed`, which the kernel reads by `packed_at`.
        """
        self._handed[packed.address] = packed
        return packed.address

    def answer(self, function: int, arguments: Arguments | list) -> int:
        """Calls a registered function; returns `FAILED` if it fails.

        A function fails if it raises an exception. After that, no further
        function is called.

        Args:
            function: Index of the function.
            arguments: The values that the kernel passes to the function.
        """
        if self.error is not None:
            return FAILED
        try:
            return self._functions[function](arguments)
        except BaseException as error:  # C would lose Ctrl-C.
            self.error = error
            return FAILED


_numbers = count()
_open: dict[int, PythonCalls] = {}


@ctypes.CFUNCTYPE(*[ctypes.c_int64] * 4)
def _answer(number: int, function: int, words: int) -> int:
    calls = _open.get(number)
    return FAILED if calls is None else calls.answer(function, Arguments(words))


binding.add_symbol(_SYMBOL, ctypes.cast(_answer, ctypes.c_void_p).value)


def call_python(number, function, values) -> int:
    """Calls a Python function, from within a kernel.

    Args:
        number: The attribute `number` of the `PythonCalls`.
        function: Index of the function.
        values: A tuple of contiguous arrays, numbers, and named tuples of
            these, packed or not.

    Returns:
        The function's result, or `FAILED`.
    """
    return _open[number].answer(function, list(_flat(values)))


@overload(call_python)
def _call_python(number, function, values):
    return lambda number, function, values: _call(  # pyright: ignore
        number, function, values
    )


def packed_at(like, address) -> Any:
    """Reads a `Packed` that Python has returned, from within a kernel.

    Args:
        like: A `Packed` of the same type.
        address: The result of `PythonCalls.handed`.
    """
    del like
    for calls in _open.values():
        if address in calls._handed:
            return calls._handed[address]
    raise KeyError(address)


@overload(packed_at)
def _packed_at(like, address):
    return lambda like, address: _cast(like, address)  # pyright: ignore


@intrinsic
def _call(typing_context, number, function, values):
    """The compiled form of `call_python`."""
    del typing_context
    parts = list(_flat(values))
    for kind in parts:
        is_array = isinstance(kind, types.Array)
        if (kind.dtype if is_array else kind) not in _KINDS or (
            is_array and kind.layout != "C"
        ):
            raise TypingError(f"a call of Python cannot pass {kind}")

    def generate(context, builder, signature, arguments):
        del signature
        words, places = [], []
        flat = _flat_values(context, builder, arguments[2], values)
        for value, kind in flat:
            places.append(1 + len(parts) + len(words))
            words += _described(context, builder, value, kind)
        size = 1 + len(places) + len(words)
        at = cgutils.alloca_once(builder, ir.ArrayType(_WORD, size))
        first = builder.bitcast(at, _WORD.as_pointer())
        for k, word in enumerate([*map(_constant, [size, *places]), *words]):
            builder.store(word, builder.gep(first, [_constant(k)]))
        function_type = ir.FunctionType(_WORD, [_WORD] * 3)
        called = cgutils.get_or_insert_function(
            builder.module, function_type, _SYMBOL
        )
        place = builder.ptrtoint(first, _WORD)
        return builder.call(called, [arguments[0], arguments[1], place])

    return types.int64(types.int64, types.int64, values), generate


def _flat(values: Any) -> Iterator[Any]:
    """Yields the values of a tuple and of nested tuples, in order."""
    if isinstance(values, Packed):
        values = values.values
    elif isinstance(values, PackedType):
        values = values.fields
    if isinstance(values, tuple | types.BaseTuple):
        for part in values:
            yield from _flat(part)
    else:
        yield values


def _flat_values(context, builder, value, kind):
    """Yields the values in a compiled tuple, and their types."""
    if isinstance(kind, types.BaseTuple):
        for k, part in enumerate(kind):
            field = builder.extract_value(value, k)
            yield from _flat_values(context, builder, field, part)
    elif isinstance(kind, PackedType):
        for k, part in enumerate(kind.fields):
            field = packed_field(context, builder, kind, value, k)
            yield from _flat_values(context, builder, field, part)
    else:
        yield value, kind


def _described(context, builder, value, kind):
    """Returns the words that describe a value: type, dimensions, data."""
    if not isinstance(kind, types.Array):
        if kind == types.float64:
            value = builder.bitcast(value, _WORD)
        else:
            value = context.cast(builder, value, kind, types.int64)
        return [_constant(_KINDS[kind]), _constant(_NUMBER), value]
    array = context.make_array(kind)(context, builder, value)
    shape = cgutils.unpack_tuple(builder, array.shape, kind.ndim)
    head = [_constant(_KINDS[kind.dtype]), _constant(kind.ndim)]
    return [*head, builder.ptrtoint(array.data, _WORD), *shape]


def _constant(number):
    return ir.Constant(_WORD, number)


@intrinsic
def _cast(typing_context, like, address):
    """The compiled form of `packed_at`."""
    del typing_context
    if not isinstance(like, PackedType):
        raise TypingError(f"{like} is not packed")

    def generate(context, builder, signature, arguments):
        kind = context.get_value_type(signature.return_type)
        return builder.inttoptr(arguments[1], kind)

    return like(like, types.int64), generate
