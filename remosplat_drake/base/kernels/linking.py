"""Changes Numba's code generation, so that compilation takes less time.

By default, Numba compiles each function to machine code, and compiles it again
as a part of each function that calls it. If Python never calls a helper, its
separate machine code is not needed. So this module links helpers into their
callers, and compiles a helper separately only if its address is needed.

This module uses private parts of Numba. A test lists each of these parts, and
`pyproject.toml` excludes versions of Numba that are not tested.
"""

from collections.abc import Sequence
from functools import cache
from typing import Any

from llvmlite import binding
from numba.core import codegen, targetconfig

_ENTRY = "_ZN7cpython"  # Begins the names of functions that Python calls.
_UNRESOLVED = ".numba.unresolved$"  # Begins those of pointers in recursions.

_environments: dict[str, Any] = {}
"""Arguments of calls of Numba's `set_env` that are delayed until the function
has machine code."""


class LinkedLibrary(codegen.JITCodeLibrary):
    """Numba code library that is compiled only if code outside it calls it."""

    _only_linked = False

    def _optimize_functions(self, ll_module):
        # Numba keeps these objects in its module-level passes.
        ll_module.data_layout = self._codegen._data_layout

    def _optimize_final_module(self):
        self._only_linked = not self._is_entered()
        if not self._only_linked:
            self._hide_linked()
            super()._optimize_final_module()

    def _hide_linked(self):
        """Hides the names of helpers from the code of other kernels.

        Numba's names of functions contain a number that is unique only within a
        process. So two different helpers, from different processes, could have
        the same name.
        """
        for function in self._final_module.functions:
            if function.linkage.name == "linkonce_odr":
                function.linkage = "internal"

    def _finalize_final_module(self):
        if not self._only_linked:
            super()._finalize_final_module()
            return
        self._finalize_dynamic_globals()
        self._verify_declare_only_symbols()
        self._finalized = True

    def _finalize_specific(self):
        super()._finalize_specific()
        for variable in self._final_module.global_variables:
            if variable.name in _environments:
                environment = _environments.pop(variable.name)
                self._codegen.set_env(variable.name, environment)

    def get_pointer_to_function(self, name: str) -> int:
        """Returns the address of a function; 0 if it is not in this library."""
        self._ensure_finalized()
        if self._only_linked:
            if not any(f.name == name for f in self.get_defined_functions()):
                return 0
            self._compile()
        return super().get_pointer_to_function(name)

    def _compile(self):
        """Generates the library's machine code."""
        self._only_linked = False
        self._get_module_for_linking()  # Restores the state before compilation.
        super()._optimize_final_module()
        super()._finalize_final_module()

    def _is_entered(self) -> bool:
        """Whether Python calls the library, or its compilation cannot wait."""
        module = self._final_module
        return (
            not self._object_caching_enabled
            or any(
                function.name.startswith(_ENTRY)
                and not function.is_declaration
                and function.linkage.name == "external"
                for function in module.functions
            )
            or any(
                variable.name.startswith(_UNRESOLVED)
                for variable in module.global_variables
            )
        )


def link_only() -> None:
    """Makes Numba use `LinkedLibrary` for the rest of this process."""
    machine = codegen.JITCPUCodegen
    if machine._library_class is not codegen.JITCodeLibrary:
        return
    set_env = machine.set_env

    def set_env_later(self, env_name, env):
        if self._engine.is_symbol_defined(env_name):
            set_env(self, env_name, env)
        else:
            _environments[env_name] = env

    machine.set_env = set_env_later
    machine._library_class = LinkedLibrary


def compare_quickly() -> None:
    """Makes Numba compare only those settings of functions that were set.

    By default, Numba compares the settings of functions thousands of times.
    Each time it computes all settings, including those with default values.
    """
    config = targetconfig.TargetConfig
    equal, digest = config.__eq__, config.__hash__

    @cache
    def digest_of_names(kind):
        return digest(kind())

    def equal_quickly(self, other):
        same = type(self) is type(other) and self._values == other._values
        return same or equal(self, other)

    config.__eq__ = equal_quickly
    config.__hash__ = lambda self: digest_of_names(type(self))


def globals_of(library: Any, prefix: str) -> list[str]:
    """Returns the global variables that a compiled library reads.

    Args:
        library: Numba's library.
        prefix: Prefix of the variables' names.
    """
    variables = library._final_module.global_variables
    return sorted(v.name for v in variables if v.name.startswith(prefix))


def reduced(compiled: Any, is_linked: bool) -> tuple:
    """Returns the part of Numba's `CompileResult` that is kept on disk.

    A `CompileResult` contains intermediate code, from which the function is
    linked into other code. If no other code links the function, this function
    replaces the intermediate code by an empty module. The empty module has the
    names that the machine code defines, which are needed in any case.

    Args:
        compiled: The `CompileResult`.
        is_linked: Whether other code links the function.
    """
    library, *rest = compiled._reduce()
    if is_linked:
        return library, *rest
    name, kind, (machine_code, _) = library
    module = compiled.library._final_module
    names = [
        value.name
        for values in (module.functions, module.global_variables)
        for value in values
        if not value.is_declaration
    ]
    return (name, kind, (machine_code, _module_of(names))), *rest


def _module_of(names: Sequence[str]) -> bytes:
    lines = [f'@"{name}" = global i8 0' for name in names]
    return binding.parse_assembly("\n".join(lines)).as_bitcode()
