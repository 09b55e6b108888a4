"""Code that only kernels call is linked into them, and not compiled itself."""

import importlib
import inspect
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from numba import njit, prange
from numba.core import compiler, dispatcher

from remosplat_drake.base.kernels import helper, kernel, linking
from remosplat_drake.base.kernels.linking import LinkedLibrary


@helper
def product(x, n):
    if n > 3:
        raise ValueError("too many", n)
    return x.sum() * n


@helper
def shifted(x, n):
    return product(x, n) + np.zeros(3)[1] + 1.0


@kernel
def inner(x, n):
    return shifted(x, n)


@kernel
def outer(x, n):
    return inner(x, n) + 1.0


PRIVATE = {
    "codegen.JITCodeLibrary": (
        "_codegen",
        "_ensure_finalized",
        "_finalize_dynamic_globals",
        "_finalize_final_module",
        "_finalize_specific",
        "_get_module_for_linking",
        "_optimize_final_module",
        "_optimize_functions",
        "_verify_declare_only_symbols",
        "enable_object_caching",
        "get_pointer_to_function",
    ),
    "codegen.JITCPUCodegen": ("_library_class", "magic_tuple", "set_env"),
    "codegen.JitEngine": ("is_symbol_defined",),
    "compiler.CompileResult": ("_rebuild", "_reduce"),
    "dispatcher.Dispatcher": ("compile",),
    "callconv.CPUCallConv": (
        "call_function",
        "get_function_type",
        "return_status_propagate",
        "return_user_exc",
    ),
    "extending._Intrinsic": ("__init__",),
}
"""What this library uses of Numba's inside."""


@pytest.mark.parametrize("owner", PRIVATE)
def test_numba_has_what_is_private_to_it(owner):
    """If this fails, a new version of Numba has changed its inside."""
    module, name = owner.split(".")
    found = getattr(importlib.import_module(f"numba.core.{module}"), name)
    missing = [part for part in PRIVATE[owner] if not _has(found, part)]
    assert not missing


def _has(owner: type, name: str) -> bool:
    return hasattr(owner, name) or name in inspect.getsource(owner.__mro__[1])


def test_dispatchers_ask_the_cache_that_they_are_given():
    """`VariantCache` takes the place of it."""
    source = inspect.getsource(dispatcher.Dispatcher.compile)
    assert "self._cache.load_overload(sig, self.targetctx)" in source
    assert "self._cache.save_overload(sig, cres)" in source


def test_what_numba_keeps_is_code_and_then_intermediate_code():
    """`linking.reduced` leaves out the latter."""
    (variant,) = called_kernel(inner, np.ones(3), 2).variants
    compiled = variant.kernel.dispatcher.overloads[variant.arguments]
    assert isinstance(compiled, compiler.CompileResult)
    fresh = njit(lambda x: 2.0 * x)
    fresh(1.0)
    (result,) = fresh.overloads.values()
    (name, kind, data), *rest = result._reduce()
    assert (type(name), kind, len(data)) == (str, "object", 2)
    assert len(rest) == 8
    short, *also = linking.reduced(result, is_linked=False)
    assert also == rest and short[2][0] == data[0]
    assert len(short[2][1]) < len(data[1])


def called_kernel(function, *arguments):
    function(*arguments)
    return function


def test_helpers_have_no_machine_code(monkeypatch):
    compiled = []
    optimise = LinkedLibrary._optimize_final_module

    def noting(self):
        optimise(self)
        if not self._only_linked:
            compiled.append(self.name)

    monkeypatch.setattr(LinkedLibrary, "_optimize_final_module", noting)
    fresh = njit(outer.py_func)
    assert fresh(np.ones(3), 2) == 8.0
    assert compiled and not {"product", "shifted"} & set(compiled)


def test_errors_of_helpers_say_what_was_wrong():
    for function in (inner, outer):
        with pytest.raises(ValueError, match=r"too many.*5"):
            function(np.ones(3), 5)


def elsewhere(program: str) -> subprocess.CompletedProcess[str]:
    """Runs a program in another process, which finds kernels on disk."""
    outer(np.ones(3), 2)
    imports = "import numpy as np; from test_linking import *\n"
    return subprocess.run(
        [sys.executable, "-c", imports + program],
        cwd=Path(__file__).parent,
        capture_output=True,
        text=True,
    )


def test_so_they_do_from_the_cache_of_another_process():
    result = elsewhere("print(outer(np.ones(3), 2)); outer(np.ones(3), 5)")
    assert result.stdout == "8.0\n"
    assert "ValueError: ('too many', 5)" in result.stderr


def test_numba_keeps_and_loads_functions_of_its_own(tmp_path):
    """In processes with this library and without it."""
    (tmp_path / "mine.py").write_text("""
from numba import njit

@njit(cache=True)
def doubled(x):
    return 2 * x
""")
    with_us = "import remosplat_drake.base.kernels\n"
    program = """
import mine
print(mine.doubled(4), len(mine.doubled.stats.cache_hits))
"""
    for imports, hits in (("", 0), (with_us, 0), ("", 1), (with_us, 1)):
        result = subprocess.run(
            [sys.executable, "-c", imports + program],
            cwd=tmp_path,
            capture_output=True,
            text=True,
        )
        assert result.stdout == f"8 {hits}\n", result.stderr


def test_parallel_loops_call_helpers():
    @njit(parallel=True)
    def doubled(x):
        for i in prange(len(x)):
            x[i] = shifted(x[i : i + 1], 2)

    x = np.arange(4.0)
    doubled(x)
    np.testing.assert_array_equal(x, [1.0, 3.0, 5.0, 7.0])


def test_what_is_wanted_after_all_is_compiled():
    """As by `cfunc`, which numba takes a pointer from."""
    compiled = njit(no_cpython_wrapper=True)(product)
    compiled.compile("float64(float64[::1], int64)")
    (result,) = compiled.overloads.values()
    name = result.fndesc.llvm_cfunc_wrapper_name
    assert result.library._only_linked
    assert result.library.get_pointer_to_function(name)
    assert not result.library._only_linked
    assert result.library.get_pointer_to_function("nothing") == 0


def test_settings_are_equal_as_numba_says():
    def settings(**values):
        flags = compiler.Flags()
        for name, value in values.items():
            setattr(flags, name, value)
        return flags

    none, set_so = settings(), settings(no_cpython_wrapper=False)
    other = settings(no_cpython_wrapper=True)
    assert none == set_so == settings() and hash(none) == hash(set_so)
    assert other != none and other == other.copy()
    assert none.__eq__(1) is NotImplemented
