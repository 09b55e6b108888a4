"""References by which any process finds a kernel, and interfaces of kernels."""

import importlib
from collections.abc import Callable
from typing import Any, Protocol

from numba import types

Types = tuple[types.Type, ...]

Reference = tuple[str, str, Types]
"""A reference: a kernel's module, its name in the module, and its argument
types."""


class KernelCode(Protocol):
    """Protocol with the part of `Kernel` that `Variant` uses."""

    py_func: Callable
    module: str
    name: str
    content: str
    options: str
    returns: Any
    dispatcher: Any

    @property
    def digest(self) -> str:
        """See `Kernel.digest`."""
        ...

    def variant(self, arguments: Types) -> Any:
        """See `Kernel.variant`."""


class Unit(Protocol):
    """Protocol with the part of `Variant` that `compilation` uses."""

    uses: Any

    @property
    def file(self) -> str:
        """See `Variant.file`."""
        ...

    @property
    def reference(self) -> Reference | None:
        """See `Variant.reference`."""
        ...

    @property
    def is_kept(self) -> bool:
        """See `Variant.is_kept`."""
        ...

    def prepare(self) -> None:
        """See `Variant.prepare`."""


def found(reference: Reference) -> Any:
    """Returns the variant that a reference names; None if it does not exist."""
    module, name, arguments = reference
    kernel = of_module(module, name)
    return kernel.variant(arguments) if hasattr(kernel, "variant") else None


def of_module(module: str, name: str) -> Any:
    """Returns a member of a module by its name; None if it does not exist."""
    try:
        return getattr(importlib.import_module(module), name, None)
    except ImportError:
        return None
