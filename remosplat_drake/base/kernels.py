"""How numba compiles this project's kernels.

Compiling takes most of the first start. A function that Python calls needs
code that takes its arguments apart, which for a robot and a program is more
than most kernels are themselves, so that only `kernel` makes it.
"""

from typing import Any

from numba import cfunc, njit
from numba.extending import register_jitable

from remosplat_drake.base.kernel_cache import share_kernels
from remosplat_drake.base.kernel_linking import link_only

link_only()
share_kernels()

_OPTIONS: Any = {"cache": True, "nogil": True, "no_cfunc_wrapper": True}

kernel = njit(**_OPTIONS)
"""Compiles a function that is called by Python, too, and keeps it on disk.

It lets go of Python's lock while it runs."""

numpy_kernel = njit(**_OPTIONS, error_model="numpy")
"""A `kernel` that divides as NumPy does: by zero, to infinity or NaN."""

parallel_kernel = njit(cache=True, parallel=True)
"""A `kernel` whose loops over `prange` are shared by threads."""

helper = register_jitable(no_cfunc_wrapper=True)
"""Compiles a function into the kernels that call it.

Python, where it calls one, runs it as it stands: slowly."""


def callback(signature: Any) -> Any:
    """Compiles a function that kernels call by its address, for one signature.

    It is not kept on disk, since it may contain code of other files.

    Args:
        signature: Numba's types of what it returns and takes.
    """
    return cfunc(signature, error_model="numpy")
