"""Changes to Numba's code generation that keep compilation short.

By default, Numba compiles each function to machine code, and compiles it again
as a part of each caller. A helper that Python never calls needs only the copies
in its callers. So helpers are linked into their callers, but are not compiled
separately, unless a pointer into their library is needed.

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
"""Arguments of delayed calls of `set_env`, for functions that have no machine
code yet."""


class LinkedLibrary(codegen.JITCodeLibrary):
    """A code library that is compiled only if code outside it calls it."""

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
        """Makes the names of helpers invisible to the code of other kernels.

        Numba's names of functions contain a number that is unique only within a
        process. So two different helpers could have the same name.
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
        """Returns the address of a function; 0 if this library lacks it."""
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
        """Whether Python calls the library, or its code cannot be deferred."""
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
    """Makes Numba compare functions' settings by their explicit values only.

    By default, Numba compares settings thousands of times, and computes all of
    them each time, including default values.
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
    """Returns the part of a compile result that is kept on disk.

    Numba's result contains intermediate code, which is needed to link the
    function into other code. If no other code links it, an empty module
    replaces the intermediate code. This module has the names that the machine
    code defines, which are needed in any case.

    Args:
        compiled: Numba's `CompileResult`.
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
