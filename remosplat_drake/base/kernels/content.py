"""Computes the digest of a kernel's content, which is the name of its file.

A kernel contains the functions that it calls and the constants that it reads,
from all modules. The digest covers the bytecode of these functions and the
values of these constants in this process. It does not depend on source files.
So a changed comment does not change the digest. If a function was redefined in
a notebook, the digest covers the current definition.

If a kernel calls another kernel by its address, the digest covers only the name
and the type of the called kernel; see `Kernel`.
"""

import enum
import hashlib
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from types import BuiltinFunctionType, CodeType, FunctionType, ModuleType
from typing import Any, TypeGuard

import llvmlite
import numba
import numpy as np
from llvmlite import ir
from numba import extending, types

_FOREIGN = {"numba", "numpy", "llvmlite", *sys.stdlib_module_names}
"""Packages whose functions are represented in the digest by the package's name
and version, and not by their bytecode."""

_COMPILER_FILES = (
    "address_calls.py",
    "lanes.py",
    "python_calls.py",
    "kernels/kernel.py",
    "kernels/linking.py",
    "kernels/packed.py",
    "kernels/variant.py",
)
"""The files in `remosplat_drake/base/` that extend Numba's compiler."""

_COMPILER_MODULES = {
    f"remosplat_drake.base.{name.removesuffix('.py').replace('/', '.')}"
    for name in _COMPILER_FILES
}


class UnknownContentError(Exception):
    """Raised if the content of a value in a kernel cannot be determined."""


class Referenced:
    """A global that kernels call by its address.

    Attributes:
        content: Text that represents the global in the digests of kernels that
            call it; empty if these kernels contain the global's code.
    """

    content: str


overloads: dict[Callable, list[Callable]] = {}
"""The functions that choose the compiled form of a Python function; see
`overload`."""


def content_digest(function: Callable) -> str:
    """Returns the digest of a function, and of the functions that it calls.

    Raises:
        UnknownContentError: The function reads a global whose content cannot be
            determined.
    """
    digest = hashlib.sha256(_environment())
    for part in _Walk().parts(function):
        digest.update(part)
        digest.update(b"\0")
    return digest.hexdigest()


class _Walk:
    """Iterates over the content of values, and visits each function once."""

    def __init__(self):
        self._seen: dict[Any, int] = {}

    def parts(self, value: Any) -> Iterator[bytes]:
        function = getattr(value, "py_func", value)
        if isinstance(value, Referenced) and value.content:
            yield value.content.encode()
        elif isinstance(function, FunctionType):
            yield from self._of_function(function)
        elif isinstance(value, tuple | list | frozenset | set):
            yield type(value).__name__.encode()
            yield str(len(value)).encode()
            members = sorted(value, key=repr) if _is_set(value) else value
            for member in members:
                yield from self.parts(member)
        elif isinstance(value, CodeType):
            yield from self._of_code(value)
        elif _is_intrinsic(value) and not _is_of_compiler(value):
            yield from self.parts(value._defn)
        else:
            yield _plain(value)

    def _of_function(self, function: FunctionType) -> Iterator[bytes]:
        if _is_foreign(function.__module__) or _is_of_compiler(function):
            yield _name(function)
            return
        if function in self._seen:
            yield b"seen %d" % self._seen[function]
            return
        self._seen[function] = len(self._seen)
        if function in overloads:
            for chooses in overloads[function]:
                yield from self.parts(chooses)
            return
        yield from self._of_code(function.__code__, function.__doc__)
        yield from self.parts(function.__defaults__ or ())
        for cell in function.__closure__ or ():
            yield from self.parts(cell.cell_contents)
        for name in sorted(_names(function.__code__)):
            if name in function.__globals__:
                yield name.encode()
                yield from self.parts(function.__globals__[name])

    def _of_code(self, code: CodeType, doc: str | None = None):
        yield code.co_code
        counts = code.co_argcount, code.co_posonlyargcount
        counts = *counts, code.co_kwonlyargcount, code.co_flags
        yield repr((counts, code.co_names, code.co_varnames)).encode()
        yield repr((code.co_freevars, code.co_cellvars)).encode()
        yield code.co_exceptiontable
        constants = code.co_consts
        if doc is not None and constants and constants[0] == doc:
            constants = constants[1:]
        yield from self.parts(constants)


def _is_set(value: Any) -> bool:
    return isinstance(value, frozenset | set)


def _names(code: CodeType) -> set[str]:
    """Returns the globals that a function or its inner functions may read."""
    names = set(code.co_names)
    for constant in code.co_consts:
        if isinstance(constant, CodeType):
            names |= _names(constant)
    return names


def _is_foreign(module: str | None) -> bool:
    # `__main__` is the module of a script or notebook, although Python lists it
    # as a module of the standard library.
    return module != "__main__" and (module or "").split(".")[0] in _FOREIGN


def _name(value: Any) -> bytes:
    module = getattr(value, "__module__", "")
    name = getattr(value, "__qualname__", getattr(value, "__name__", ""))
    return f"{module}.{name}".encode()


def _plain(value: Any) -> bytes:
    """Returns the content of a value that contains no function."""
    if value is None or value is Ellipsis:
        return repr(value).encode()
    if isinstance(value, enum.Enum):
        return _name(type(value)) + repr((value.name, value.value)).encode()
    if isinstance(value, bool | int | float | complex | str | bytes):
        return f"{type(value).__name__} {value!r}".encode()
    if isinstance(value, np.ndarray):
        head = repr((value.dtype, value.shape)).encode()
        return head + np.ascontiguousarray(value).tobytes()
    if isinstance(value, np.generic | np.dtype):
        return f"{type(value).__name__} {value!r}".encode()
    if isinstance(value, types.Type | ir.Type | ir.Constant):
        return f"type {value}".encode()
    if isinstance(value, ModuleType):
        if _is_foreign(value.__name__):
            return f"module {value.__name__}".encode()
    elif isinstance(value, enum.EnumType):
        return _name(value) + repr(list(value)).encode()
    elif isinstance(value, type) and issubclass(value, tuple):
        return _name(value) + repr(getattr(value, "_fields", ())).encode()
    elif isinstance(value, type) or _is_known_by_name(value):
        return _name(value)
    raise UnknownContentError(f"{value!r} of {type(value)}")


def _is_known_by_name(value: Any) -> bool:
    """Whether a value's name represents it: a function of Numba, NumPy or C.

    An intrinsic of this package is also represented by its name. Only
    intrinsics in `_COMPILER_FILES` reach this function.
    """
    return hasattr(value, "__name__") and (
        isinstance(value, BuiltinFunctionType | np.ufunc)
        or _is_intrinsic(value)
        or _is_foreign(getattr(value, "__module__", None))
    )


def _is_intrinsic(value: Any) -> TypeGuard[Any]:
    return isinstance(value, extending._Intrinsic)


def _is_of_compiler(value: Any) -> bool:
    return value.__module__ in _COMPILER_MODULES


_known_environment = b""


def _environment() -> bytes:
    """Returns the content that all kernels share: versions and extensions."""
    global _known_environment
    if not _known_environment:
        base = Path(__file__).resolve().parents[1]
        digest = hashlib.sha256()
        for name in _COMPILER_FILES:
            digest.update((base / name).read_bytes())
        versions = (
            numba.__version__,
            llvmlite.__version__,
            np.__version__.split(".")[0],
            sys.version_info[:2],
        )
        digest.update(repr(versions).encode())
        _known_environment = digest.digest()
    return _known_environment
