"""`Kernel`: a compiled function that Python and other kernels call."""

import inspect
from collections.abc import Callable
from functools import cached_property, update_wrapper
from typing import Any

from numba import cfunc, njit, types
from numba.core import registry
from numba.extending import intrinsic, typeof_impl

from remosplat_drake.base.kernels.content import (
    Referenced,
    UnknownContentError,
    content_digest,
)
from remosplat_drake.base.kernels.packed import handed_type
from remosplat_drake.base.kernels.references import Types
from remosplat_drake.base.kernels.variant import (
    Variant,
    VariantCache,
    abandon,
    adding_complete,
    complete_for_others,
)

Returns = types.Type | Callable[..., types.Type] | None


class Kernel(Referenced):
    """A compiled function, kept on disk under the digest of its content.

    Other kernels call a kernel by its address. So the kernel is compiled only
    once, and its callers are not compiled again when it changes.

    Attributes:
        py_func: The original Python function.
        module: Name of its module.
        name: Qualified name of the function in its module.
        content: See `Referenced.content`.
        returns: The type of the result, or a function that computes this type
            from the argument types. If it is None, kernels that call this
            kernel are compiled after it, otherwise in parallel with it.
        options: Numba's options, as text.
    """

    def __init__(
        self,
        function: Callable,
        returns: Returns = None,
        *,
        linked: bool = False,
        **options: Any,
    ):
        """Creates a kernel; it is compiled at its first call.

        Args:
            function: The function.
            returns: The type of the result, see `Kernel`.
            linked: Whether kernels that call this one contain its code.
            options: Numba's options.
        """
        update_wrapper(self, function)
        self.py_func, self.returns = function, returns
        self.module, self.name = function.__module__, function.__qualname__
        self.content = "" if linked else f"kernel {self.module}.{self.name}"
        self.options = repr(sorted(options.items()))
        self.dispatcher = njit(nogil=True, no_cfunc_wrapper=True, **options)(
            function
        )
        self.dispatcher._cache = VariantCache(self)
        self.dispatcher.add_overload = adding_complete(
            self, self.dispatcher.add_overload
        )
        self._variants: dict[Types, Variant] = {}
        self._call = None if linked else self._intrinsic()

    def __call__(self, *arguments: Any) -> Any:
        """Calls the kernel from Python."""
        try:
            return self.dispatcher(*arguments)
        except BaseException:
            abandon()
            raise

    def variant(self, arguments: Types) -> Variant:
        """Returns the variant of this kernel for some argument types."""
        if arguments not in self._variants:
            self._variants[arguments] = Variant(self, arguments)
        return self._variants[arguments]

    @property
    def variants(self) -> list[Variant]:
        """The variants of this kernel that are compiled or loaded."""
        return [v for v in self._variants.values() if v.uses is not None]

    @property
    def digest(self) -> str:
        """The digest of the content; empty if it cannot be determined."""
        return self._digest

    @cached_property
    def _digest(self) -> str:
        try:
            return content_digest(self.py_func)
        except UnknownContentError:
            return ""

    def _intrinsic(self) -> Any:
        """Creates the intrinsic that calls this kernel by its address."""

        def call(typing_context, *arguments):
            del typing_context
            variant = self.variant(tuple(map(handed_type, arguments)))
            complete_for_others(variant)
            called = variant.result(*map(types.unliteral, arguments))
            return called, variant.generate_call

        names = ["typing_context", *inspect.signature(self.py_func).parameters]
        kind = inspect.Parameter.POSITIONAL_OR_KEYWORD
        call.__signature__ = inspect.Signature(  # pyright: ignore
            [inspect.Parameter(name, kind) for name in names]
        )
        return intrinsic(call)


@typeof_impl.register(Kernel)
def _type_of_kernel(kernel, context):
    del context
    called = kernel.dispatcher if kernel._call is None else kernel._call
    return registry.cpu_target.typing_context.resolve_value_type(called)


def callback(signature: Any) -> Any:
    """Compiles a function for one signature; kernels call it by its address.

    The compiled function is not kept on disk, since it may contain code of
    other files.

    Args:
        signature: Numba's types of the function's result and arguments.
    """
    return cfunc(signature, error_model="numpy")
