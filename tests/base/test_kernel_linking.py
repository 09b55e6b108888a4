"""Code that only kernels call is linked into them, and not compiled itself."""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from numba import njit, prange

from remosplat_drake.base.kernel_linking import LinkedLibrary
from remosplat_drake.base.kernels import helper, kernel


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
    imports = "import numpy as np; from test_kernel_linking import *\n"
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


def test_what_comes_from_disk_is_parsed_when_it_is_linked():
    result = elsewhere("""
outer(np.ones(3), 2)
assert outer.stats.cache_hits
(kept,) = outer.overloads.values()
assert kept.library._unparsed and kept.library._shared_module is None
again = njit(lambda x, n: outer(x, n) + shifted(x, n))
assert again(np.ones(3), 2) == 15.0
assert not kept.library._unparsed
assert kept.library._shared_module is not None
print("done")
""")
    assert result.stdout == "done\n", result.stderr


def test_kernels_that_numba_itself_has_kept_are_loaded():
    compiled = njit("float64(float64[::1], int64)")(outer.py_func)
    (result,) = compiled.overloads.values()
    library = result.library
    state = super(LinkedLibrary, library).serialize_using_object_code
    name = result.fndesc.llvm_cpython_wrapper_name
    assert state()[1] == "object"
    loaded = library.codegen.unserialize_library(state())
    assert loaded.get_pointer_to_function(name)


def test_who_does_without_this_library_finds_no_kernels_of_it(tmp_path):
    """Somebody's function, kept by a process with it and one without."""
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
