"""`Variant`: a kernel that is compiled for certain argument types.

Kernels call a variant through its cell, a word of memory that contains the
address of the variant's machine code. Machine code finds the cell by the cell's
name. Before Python calls a kernel, the cells of all variants that the kernel
may call are filled. So no variant is compiled or loaded during the call.
"""

import ctypes
import gc
import hashlib
import threading
from collections.abc import Callable
from contextlib import ExitStack
from functools import cache, cached_property
from time import process_time
from typing import Any

from llvmlite import binding, ir
from numba import types
from numba.core import cgutils, compiler, config, registry
from numba.core.errors import TypingError

from remosplat_drake.base.kernels import compilation, files, linking
from remosplat_drake.base.kernels.packed import hand_over, type_text
from remosplat_drake.base.kernels.references import (
    KernelCode,
    Reference,
    Types,
    found,
    of_module,
)

_CELL = "numba.dynamic.globals.remosplat_drake:"
"""Prefix of the names of cells.

Numba recognises the beginning of this prefix, and treats the cells as local to
this process. So Numba does not cache functions with `cache=True` that call
kernels, because another process would not find the cells."""

_WORD = ir.IntType(64)

variants: list["Variant"] = []
"""All variants of this process."""

_named: dict[str, "Variant"] = {}
"""The variants with named cells, keyed by cell name."""


class Variant:
    """A kernel that is compiled for certain argument types.

    Attributes:
        kernel: The kernel.
        arguments: The types of the arguments.
        uses: The variants that this one calls; None before it is compiled or
            loaded.
        time: Compilation time of this variant's own code on one core [s].
        was_kept: Whether the variant was loaded from disk.
    """

    def __init__(self, kernel: KernelCode, arguments: Types):
        self.kernel, self.arguments = kernel, arguments
        self.uses: list[Variant] | None = None
        self._cell = ctypes.c_int64(0)
        self._compiled: Any = None
        self._result: types.Type | None = None
        self.time = self._start = 0.0
        self.was_kept = False
        self._work = ExitStack()
        variants.append(self)

    @cached_property
    def name(self) -> str:
        """The name by which machine code finds the variant's cell."""
        kernel, kinds = self.kernel, self._kinds
        name = f"{_CELL}{kernel.module}.{kernel.name}"
        return f"{name}.{hashlib.sha256(kinds.encode()).hexdigest()[:16]}"

    @cached_property
    def _kinds(self) -> str:
        return ", ".join(map(type_text, self.arguments))

    @property
    def file(self) -> str:
        """Name of the variant's file; empty if it cannot be kept on disk."""
        return self._file

    @cached_property
    def _file(self) -> str:
        kernel, kinds = self.kernel, self._kinds
        if not kernel.digest or " at 0x" in kinds:
            return ""
        parts = kernel.digest, kernel.options, kinds, _processor()
        digest = hashlib.sha256("\0".join(parts).encode()).hexdigest()
        return f"{kernel.py_func.__name__}-{digest[:40]}.kernel"

    @property
    def is_kept(self) -> bool:
        """Whether the variant is on disk."""
        return bool(self.file) and files.find(self.file) is not None

    @property
    def result(self) -> types.Type:
        """The type of the result; reading it may compile the variant."""
        if self._result is None:
            returns = self.kernel.returns
            if returns is not None:
                told = isinstance(returns, types.Type)
                self._result = returns if told else returns(*self.arguments)
                compilation.request(self)
            else:
                self.prepare()
        assert self._result is not None
        return self._result

    @property
    def reference(self) -> Reference | None:
        """Reference for `found`; None if other processes cannot find it."""
        kernel = self.kernel
        module, name = kernel.module, kernel.name
        is_found = module != "__main__" and of_module(module, name) is kernel
        return (module, name, self.arguments) if is_found else None

    def prepare(self) -> None:
        """Loads or compiles the variant, but not the variants that it calls."""
        if self._compiled is not None:
            return
        _thread.nested += 1
        outer = len(_thread.working)
        try:
            self.kernel.dispatcher.compile(self.arguments)
        except BaseException:
            abandon(outer)
            raise
        finally:
            _thread.nested -= 1

    def load(self, target_context: Any) -> Any:
        """Returns Numba's `CompileResult` from disk; None if there is none."""
        if self._compiled is not None:
            return self._compiled
        kept = self._kept()
        if kept is None:
            return None
        self.time, used, reduced = kept
        uses = []
        for reference, result in used:
            variant = found(reference)
            # The code on disk is valid only if the variants that it calls still
            # have the result types for which it was compiled.
            if variant is None or variant.result != result:
                return None
            variant.name_cell()
            uses.append(variant)
        compiled = compiler.CompileResult._rebuild(target_context, *reduced)
        self._take(compiled, uses)
        self.was_kept = True
        return compiled

    def begin(self) -> None:
        """Locks the variant for this process; disables garbage collection."""
        compilation.begin(self)
        if self.file:
            self._work.enter_context(files.locked(self.file))
        if not _thread.working and gc.isenabled():
            gc.disable()
            self._work.callback(gc.enable)
        self.time, self._start = 0.0, process_time()
        _thread.working.append(self)

    def keep(self, compiled: Any) -> None:
        """Writes the variant's compiled code to disk."""
        spent = process_time() - self._start
        self.time += spent
        for outer in _thread.working[-2:-1]:
            outer.time -= spent
        names = linking.globals_of(compiled.library, _CELL)
        self._take(compiled, [_named[name] for name in names])
        assert self.uses is not None
        used = [(used.reference, used.result) for used in self.uses]
        if self.file and all(reference for reference, _ in used):
            is_linked = not self.kernel.content
            reduced = linking.reduced(compiled, is_linked)
            files.write(self.file, (self.time, used, reduced))
        self._end()

    def _end(self) -> None:
        if self in _thread.working:
            _thread.working.remove(self)
            compilation.end(self)
        self._work.close()

    def _kept(self) -> Any:
        """Returns the content of the variant's file; None if there is none.

        The content is the compilation time, the called variants, and Numba's
        data.
        """
        path = files.find(self.file) if self.file else None
        return None if path is None else files.read(path)

    def _take(self, compiled: Any, uses: list["Variant"]) -> None:
        result = compiled.signature.return_type
        if self._result not in (None, result):
            raise TypingError(
                f"{self.kernel.name} returns {result}, not {self._result} as "
                "declared"
            )
        self._result, self.uses = result, uses
        # Numba records the duration of a compilation, but not of loading.
        self._compiled = compiled._replace(metadata=None)
        self._cell.value = compiled.library.get_pointer_to_function(
            compiled.fndesc.llvm_func_name
        )

    def name_cell(self) -> None:
        """Registers the cell's name with LLVM, for use by machine code."""
        if self.name not in _named:
            _named[self.name] = self
            binding.add_symbol(self.name, ctypes.addressof(self._cell))

    def generate_call(self, context, builder, signature, arguments):
        """Generates the intermediate code of a call through the cell."""
        self.name_cell()
        convention, module = context.call_conv, builder.module
        cell = module.globals.get(self.name)
        if cell is None:
            cell = ir.GlobalVariable(module, _WORD, self.name)
            cell.linkage = "external"
        address = builder.load(cell)
        is_empty = builder.icmp_unsigned("==", address, _WORD(0))
        with cgutils.if_unlikely(builder, is_empty):
            text = f"{self.kernel.name} is not compiled"
            convention.return_user_exc(builder, RuntimeError, (text,))
        arguments = [
            hand_over(context, builder, kind, value)
            for kind, value in zip(signature.args, arguments, strict=True)
        ]
        result, kinds = signature.return_type, self.arguments
        kind = convention.get_function_type(result, kinds)
        called = builder.inttoptr(address, kind.as_pointer())
        status, value = convention.call_function(
            builder, called, result, kinds, arguments
        )
        with cgutils.if_unlikely(builder, status.is_error):
            convention.return_status_propagate(builder, status)
        _check_owned(context, builder, self.kernel, result, value)
        return value


def _check_owned(context, builder, kernel, kind, value) -> None:
    """Generates a check that a result contains no array of a packed argument.

    Such an array might be freed while the caller still uses the result.
    """
    if isinstance(kind, types.Array):
        array = context.make_array(kind)(context, builder, value)
        is_borrowed = cgutils.is_null(builder, array.meminfo)
        with cgutils.if_unlikely(builder, is_borrowed):
            text = f"{kernel.name} returns an array of an argument"
            context.call_conv.return_user_exc(builder, RuntimeError, (text,))
    elif isinstance(kind, types.BaseTuple):
        for k, part in enumerate(kind):
            inner = builder.extract_value(value, k)
            _check_owned(context, builder, kernel, part, inner)


class _Thread(threading.local):
    """State of a thread that compiles variants.

    Attributes:
        working: The variants that the thread compiles at present.
        nested: Number of these variants that are compiled because another
            variant calls them, or because another process requested them.
    """

    def __init__(self):
        self.working: list[Variant] = []
        self.nested = 0


_thread = _Thread()


def abandon(outer: int = 0) -> None:
    """Ends this thread's compilations after one of them has failed.

    Args:
        outer: Number of the thread's outermost compilations that continue.
    """
    for variant in reversed(_thread.working[outer:]):
        variant._end()
    if not outer:
        compilation.rest()


class VariantCache:
    """Replaces the cache of a Numba dispatcher by the files of variants."""

    def __init__(self, kernel: KernelCode):
        self._kernel = kernel

    def load_overload(self, arguments: Types, target_context: Any) -> Any:
        """Returns a variant's `CompileResult` from disk; None if absent."""
        variant = self._kernel.variant(tuple(arguments))
        target_context.refresh()  # It links Numba's runtime.
        compiled = variant.load(target_context)
        if compiled is None:
            variant.begin()
            # Another process may have compiled the variant in the meantime.
            compiled = variant.load(target_context) if variant.file else None
            if compiled is not None:
                variant._end()
        if compiled is not None:
            _complete(variant)
        return compiled

    def save_overload(self, arguments: Types, compiled: Any) -> None:
        """Does nothing, since `adding_complete` writes variants to disk."""


def adding_complete(
    kernel: KernelCode, add: Callable[[Any], None]
) -> Callable[[Any], None]:
    """Returns a function that adds a `CompileResult` to a kernel's dispatcher.

    As soon as a result is added, Python may call the kernel on any thread. So
    the function first prepares all variants that the kernel calls. It does not
    add the results of these variants to their dispatchers: if Python calls one
    of them, `VariantCache` loads it.

    Args:
        kernel: The kernel.
        add: The dispatcher's `add_overload`.
    """

    def add_complete(compiled: Any) -> None:
        for variant in _thread.working[-1:]:
            if variant.kernel is kernel:  # Not for a variant from disk.
                variant.keep(compiled)
                _complete(variant)
        # If a kernel contains the code of a function, Numba links this
        # function.
        if not _thread.nested or not kernel.content:
            add(compiled)

    return add_complete


def _complete(variant: Variant) -> None:
    """Prepares all variants that a variant calls, before Python calls it."""
    if not _thread.nested:
        try:
            compilation.finish(variant)
        finally:
            compilation.rest()


def complete_for_others(variant: Variant) -> None:
    """Prepares a variant for a caller that is not a kernel.

    Such a caller does not prepare the variants that it needs, so they are
    prepared when it is compiled.
    """
    if not _thread.working and not _thread.nested:
        variant.prepare()
        _complete(variant)


@cache
def _processor() -> str:
    """Returns the target processor and Numba's settings, as text."""
    codegen = registry.cpu_target.target_context.codegen()
    settings = (
        int(config.OPT),
        config.BOUNDSCHECK,
        config.DEBUGINFO_DEFAULT,
        config.LOOP_VECTORIZE,
        config.SLP_VECTORIZE,
    )
    return repr((codegen.magic_tuple(), settings))
