"""`Packed`: a named tuple of arrays that kernels receive by address.

If a kernel takes a plain named tuple, Numba makes a separate argument of each
number in each array header. For a robot, these are hundreds of arguments of the
kernel, and of each function that the kernel calls. They would dominate the
compilation time and the duration of calls from Python. In contrast, a `Packed`
is a single address, from which a kernel reads only the fields that it uses.
"""

import hashlib
import itertools
import struct
from contextlib import suppress
from typing import Any, Generic, TypeVar

import numpy as np
from llvmlite import ir
from numba import typeof, types
from numba.core import cgutils
from numba.core.errors import TypingError
from numba.core.typing.templates import AttributeTemplate
from numba.extending import (
    NativeValue,
    infer_getattr,
    lower_getattr_generic,
    models,
    register_model,
    unbox,
)
from numba.np import arrayobj

from remosplat_drake.base.kernels.content import (
    UnknownContentError,
    content_digest,
)

Values = TypeVar("Values", bound=tuple)

_WORD = ir.IntType(64)
_REAL, _WHOLE = struct.Struct("d"), struct.Struct("q")
_HEADERS = [struct.Struct(f"{1 + 2 * n}q") for n in range(33)]
"""Formats of the headers of arrays with n dimensions."""


class Packed(Generic[Values]):
    """A named tuple for kernels: arrays, numbers, and tuples of these.

    Kernels read the fields of a `Packed` by name, as if it were the named
    tuple. Kernels must not write to its read-only arrays.

    Attributes:
        values: The named tuple, with contiguous arrays.
        address: Address of the packed fields: array headers and numbers.
    """

    __slots__ = ("_layout", "_numba_type_", "_words", "address", "values")

    def __init__(self, values: Values):
        """Packs a named tuple.

        Args:
            values: The named tuple; named tuples in it are packed, too. Arrays
                that are not contiguous are copied.
        """
        words = bytearray()
        self.values, layout = _pack(values, words)
        self._layout, self._numba_type_ = _known_type(layout, self.values)
        self._words = np.frombuffer(words, np.int64)
        self.address = _address(self._words)

    def __getattr__(self, name: str) -> Any:
        """Returns a field of the named tuple, by its name."""
        if name in Packed.__slots__:
            raise AttributeError(name)
        return getattr(self.values, name)

    def __reduce__(self):
        return Packed, (self.values,)

    def __deepcopy__(self, memo) -> "Packed[Values]":
        return self


def _pack(value: Any, words: bytearray) -> tuple[Any, Any]:
    """Appends a value as 64-bit words; an array's are address, shape, strides.

    Returns:
        Two things: the value, in which arrays are contiguous and each `Packed`
        is replaced by its named tuple, and its layout. The layout is a hashable
        key, which is equal only for values of the same type.
    """
    if isinstance(value, np.ndarray):
        value = np.ascontiguousarray(value)
        header = _HEADERS[value.ndim]
        words += header.pack(_address(value), *value.shape, *value.strides)
        return value, (value.dtype, value.ndim)
    if isinstance(value, Packed):
        words += value._words.data
        return value.values, value._layout
    if isinstance(value, tuple):
        kind = type(value)
        parts = [_pack(part, words) for part in value]
        make = getattr(kind, "_make", tuple)
        return make(p for p, _ in parts), (kind, *(at for _, at in parts))
    if isinstance(value, float):
        words += _REAL.pack(value)
    else:
        words += _WHOLE.pack(int(value))
    return value, type(value)


def _address(array: np.ndarray) -> int:
    # This is several times as fast as the array's `ctypes`.
    return array.__array_interface__["data"][0]


_codes: dict[type, Any] = {}


def bind_code(kind: type, function: Any) -> None:
    """Declares the function that processes a named tuple as part of its type.

    Kernels that take such a tuple are then compiled again when the code of the
    function changes. `bind_code` must be called before the first such tuple is
    packed.

    Args:
        kind: The named tuple.
        function: The kernel or helper.
    """
    _codes[kind] = function


def _code_of(kind: type) -> str:
    """Returns the digest of a named tuple's `bind_code` function, as text."""
    try:
        return content_digest(_codes[kind]) if kind in _codes else ""
    except UnknownContentError:
        return f"unknown at 0x{id(_codes[kind]):x}"  # Invalid as a file name.


class PackedType(types.Type):
    """Numba's type of a `Packed`, with the types of its fields."""

    def __init__(self, kind: type, fields: tuple[types.Type, ...]):
        self.kind, self.fields = kind, fields
        self.code = _code_of(kind)
        # The order of the fields is part of the type, since compiled code
        # depends on it.
        self.names: tuple[str, ...] = kind._fields  # pyright: ignore
        layout = repr((fields, self.names, self.code))
        digest = hashlib.sha256(layout.encode()).hexdigest()[:16]
        unknown = " at 0x" if " at 0x" in layout else ""
        super().__init__(
            f"Packed.{kind.__module__}.{kind.__name__}.{digest}{unknown}"
        )

    @property
    def key(self) -> tuple:
        """Key that distinguishes this type from other types."""
        return self.kind, self.names, self.fields, self.code


_types: dict[Any, tuple[int, "PackedType"]] = {}
_numbers = itertools.count()


def _known_type(layout: Any, values: Any) -> tuple[int, PackedType]:
    """Returns the number and the Numba type of a layout; creates each once."""
    if layout not in _types:
        found = next(_numbers), _packed_type(values)
        return _types.setdefault(layout, found)
    return _types[layout]


def _packed_type(values: Any) -> PackedType:
    return PackedType(type(values), tuple(_type(part) for part in values))


def _type(value: Any) -> types.Type:
    if isinstance(value, np.ndarray):
        # A writable and a read-only array have the same type.
        return types.Array(typeof(value).dtype, value.ndim, "C")
    if hasattr(value, "_fields"):
        return _packed_type(value)
    if isinstance(value, tuple):
        return types.BaseTuple.from_types([_type(part) for part in value])
    return typeof(value)


def _count(kind: types.Type) -> int:
    """Returns the number of 64-bit words that a value of a type takes."""
    if isinstance(kind, types.Array):
        return 1 + 2 * kind.ndim
    if isinstance(kind, PackedType):
        return sum(_count(part) for part in kind.fields)
    if isinstance(kind, types.BaseTuple):
        return sum(_count(part) for part in kind)
    return 1


register_model(PackedType)(models.OpaqueModel)


@unbox(PackedType)
def _unbox(kind, packed, c):
    address = c.pyapi.object_getattr_string(packed, "address")
    word = c.pyapi.long_as_ulonglong(address)
    c.pyapi.decref(address)
    model = c.context.get_value_type(kind)
    return NativeValue(c.builder.inttoptr(word, model))


@infer_getattr
class _Fields(AttributeTemplate):
    key = PackedType

    def generic_resolve(self, typ, attr):
        if attr in typ.names:
            return typ.fields[typ.names.index(attr)]
        return None


@lower_getattr_generic(PackedType)
def _get_field(context, builder, kind, value, name):
    return packed_field(context, builder, kind, value, kind.names.index(name))


def packed_field(context, builder, kind, value, place) -> Any:
    """Reads a field of a packed value.

    Args:
        context: Numba's target context.
        builder: LLVM builder of the kernel's intermediate code.
        kind: The `PackedType`.
        value: The packed value.
        place: Index of the field.
    """
    first = sum(_count(part) for part in kind.fields[:place])
    words = builder.bitcast(value, _WORD.as_pointer())
    return _read(context, builder, kind.fields[place], words, first)


def _read(context, builder, kind, words, first):
    """Reads a value of a given type from consecutive words, from `first` on."""

    def word(number):
        at = builder.gep(words, [ir.Constant(_WORD, number)])
        loaded = builder.load(at)
        # Array headers never change, so the compiler may move this read out of
        # loops.
        loaded.set_metadata("invariant.load", builder.module.add_metadata([]))
        return loaded

    if isinstance(kind, types.Array):
        n = kind.ndim
        array = context.make_array(kind)(context, builder)
        arrayobj.populate_array(
            array,
            data=builder.inttoptr(word(first), array.data.type),
            shape=[word(first + 1 + k) for k in range(n)],
            strides=[word(first + 1 + n + k) for k in range(n)],
            itemsize=array.itemsize.type(
                context.get_abi_sizeof(context.get_data_type(kind.dtype))
            ),
            meminfo=None,  # Python holds the reference.
        )
        return array._getvalue()
    if isinstance(kind, PackedType):
        at = builder.gep(words, [ir.Constant(_WORD, first)])
        return builder.bitcast(at, context.get_value_type(kind))
    if isinstance(kind, types.BaseTuple):
        parts = []
        for part in kind:
            parts.append(_read(context, builder, part, words, first))
            first += _count(part)
        return context.make_tuple(builder, kind, parts)
    loaded = word(first)
    if isinstance(kind, types.Float):
        return builder.bitcast(loaded, context.get_value_type(kind))
    return context.cast(builder, loaded, types.int64, kind)


def packed_type(kind: types.Type) -> Any:
    """Returns the type of a kernel's value after packing.

    Args:
        kind: The type of the value.

    Raises:
        TypingError: The value contains an array that is not contiguous.
    """
    if isinstance(kind, types.Array):
        if kind.layout != "C":
            raise TypingError(f"{kind} cannot be packed")
        return types.Array(kind.dtype, kind.ndim, "C")
    if isinstance(kind, types.BaseNamedTuple):
        return PackedType(kind.instance_class, tuple(map(packed_type, kind)))
    if isinstance(kind, types.BaseTuple):
        return types.BaseTuple.from_types(tuple(map(packed_type, kind)))
    return kind


def packed_words(context, builder, kind, value) -> list[ir.Value]:
    """Converts a kernel's value to the 64-bit integers that represent it.

    Args:
        context: Numba's target context.
        builder: LLVM builder of the kernel's intermediate code.
        kind: The type of the value.
        value: The value.

    Returns:
        The integers. An array is represented by its address, shape and strides,
        a number by its bits, and a tuple by the integers of its elements.
    """
    if isinstance(kind, types.Array):
        array, n = context.make_array(kind)(context, builder, value), kind.ndim
        return [
            builder.ptrtoint(array.data, _WORD),
            *cgutils.unpack_tuple(builder, array.shape, n),
            *cgutils.unpack_tuple(builder, array.strides, n),
        ]
    if isinstance(kind, PackedType):
        first = builder.bitcast(value, _WORD.as_pointer())
        places = (ir.Constant(_WORD, k) for k in range(_count(kind)))
        return [builder.load(builder.gep(first, [k])) for k in places]
    if isinstance(kind, types.BaseTuple):
        parts = (builder.extract_value(value, k) for k in range(len(kind)))
        return [
            word
            for part, of_part in zip(kind, parts, strict=True)
            for word in packed_words(context, builder, part, of_part)
        ]
    if isinstance(kind, types.Float):
        return [builder.bitcast(value, _WORD)]
    return [context.cast(builder, value, kind, types.int64)]


def handed_type(kind: types.Type) -> Any:
    """Returns the type in which a kernel passes a value to another kernel.

    Named tuples are packed. A tuple with an array that is not contiguous is
    passed unpacked.

    Args:
        kind: The type of the value.
    """
    kind = types.unliteral(kind)
    if isinstance(kind, types.BaseNamedTuple):
        with suppress(TypingError):
            return packed_type(kind)
    elif isinstance(kind, types.BaseTuple):
        return types.BaseTuple.from_types(tuple(map(handed_type, kind)))
    return kind


def hand_over(context, builder, kind, value) -> ir.Value:
    """Converts a kernel's value to the form in which another kernel takes it.

    Args:
        context: Numba's target context.
        builder: LLVM builder of the kernel's intermediate code.
        kind: The type of the value.
        value: The value. Its arrays must exist until the other kernel returns.
    """
    handed = handed_type(kind)
    if handed == kind:
        return value
    if isinstance(handed, PackedType):
        at = store_words(builder, packed_words(context, builder, kind, value))
        return builder.bitcast(at, context.get_value_type(handed))
    parts = [
        hand_over(context, builder, part, builder.extract_value(value, k))
        for k, part in enumerate(kind)
    ]
    return context.make_tuple(builder, handed, parts)


def type_text(kind: types.Type) -> str:
    """Returns text that identifies a type, and is equal in all processes.

    Numba's own name of a named tuple is not sufficient, since it lacks the
    names of the fields.

    Args:
        kind: The type. For a tuple, the text contains the types of all parts.
    """
    if not isinstance(kind, types.BaseTuple):
        return repr(kind)
    parts = ", ".join(map(type_text, kind))
    if not isinstance(kind, types.BaseNamedTuple):
        return f"({parts})"
    named = kind.instance_class
    return f"{named.__module__}.{named.__qualname__}{kind.fields}({parts})"


def store_words(builder, words) -> ir.Value:
    """Stores words in a kernel's stack frame; returns their address."""
    at = cgutils.alloca_once(builder, ir.ArrayType(_WORD, len(words)))
    first = builder.bitcast(at, _WORD.as_pointer())
    for k, word in enumerate(words):
        builder.store(word, builder.gep(first, [ir.Constant(_WORD, k)]))
    return first
