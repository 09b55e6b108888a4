"""Compiles the kernels of this package with Numba.

A `kernel` is a function that is compiled separately and kept on disk. A
`helper` is a function that is compiled into each kernel that calls it.
"""

from collections.abc import Callable
from typing import Any

from numba import config, extending
from numba.extending import register_jitable

from remosplat_drake.base.kernels import compilation, linking, target
from remosplat_drake.base.kernels.content import overloads
from remosplat_drake.base.kernels.kernel import Kernel, Returns, callback

__all__ = [
    "callback",
    "helper",
    "kernel",
    "note_extension",
    "numpy_helper",
    "numpy_kernel",
    "overload",
    "parallel_kernel",
]

target.choose()
linking.link_only()
linking.compare_quickly()


def kernel(
    function: Any = None,
    *,
    returns: Returns = None,
    linked: bool = False,
    **options: Any,
) -> Any:
    """Decorates a function, which is compiled as a `Kernel` and kept on disk.

    Python and other kernels can call it. It releases the GIL while it runs.

    Args:
        function: The function; None if the decorator is used with options.
        returns: Type of the function's result; see `Kernel.returns`.
        linked: Whether the function is compiled into each kernel that calls it,
            in the same way as a `helper`.
        options: Numba's options.
    """
    if function is None:
        return lambda function: kernel(
            function, returns=returns, linked=linked, **options
        )
    if config.DISABLE_JIT:
        return function
    return Kernel(function, returns, linked=linked, **options)


def numpy_kernel(function: Any = None, **options: Any) -> Any:
    """Decorates a `kernel` in which division by zero gives infinity or NaN."""
    return kernel(function, error_model="numpy", **options)


def parallel_kernel(function: Any) -> Any:
    """Decorates a `kernel` whose loops over `prange` run on several threads."""
    return kernel(function, parallel=True)


helper = register_jitable(no_cfunc_wrapper=True)
"""Decorator of a function that is compiled into each kernel that calls it.

If Python calls a helper directly, the function runs uncompiled, which is
slow."""

numpy_helper = register_jitable(no_cfunc_wrapper=True, error_model="numpy")
"""Decorator of a `helper` in which division by zero gives infinity or NaN."""


def overload(function: Callable) -> Callable[[Callable], Callable]:
    """Decorates a function that selects an implementation (Numba's `overload`).

    Args:
        function: The function.
    """

    def register(chooses: Callable) -> Callable:
        overloads.setdefault(function, []).append(chooses)
        note_extension(chooses)
        return extending.overload(function)(chooses)

    return register


def note_extension(function: Callable) -> None:
    """Registers a function's module as an extension of Numba's compiler."""
    if function.__module__ not in compilation.extending_modules:
        compilation.extending_modules.append(function.__module__)
