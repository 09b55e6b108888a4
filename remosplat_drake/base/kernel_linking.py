"""Keeps Numba from compiling for nobody.

Numba optimises each function and makes machine code of it, and then links its
intermediate code into all that call it, where it is optimised and compiled
again, level by level. For a function that no Python calls, all but the last
level is in vain: more than a third of a first start.

So a library of code without an entry for Python is only linked. If anybody
wants a pointer into it after all, it is made then.

What is kept on disk is machine code, and the intermediate code for others to
link. When it is loaded, Numba parses the latter only to learn which names are
defined: a quarter of a later start. So the names are kept, too, and it is
parsed when it is linked.

Where Numba's inside is not as it is known here, everything stays as Numba does
it.
"""

from typing import Any

from llvmlite import binding
from numba.core import codegen

_ENTRY = "_ZN7cpython"  # Begins the names of functions that Python calls.
_UNRESOLVED = ".numba.unresolved$"  # Begins those of pointers in recursions.

_NEEDED_OF_LIBRARIES = (
    "_finalize_dynamic_globals",
    "_finalize_final_module",
    "_finalize_specific",
    "_get_compiled_object",
    "_get_module_for_linking",
    "_optimize_final_module",
    "_optimize_functions",
    "_set_compiled_object",
    "_unserialize",
    "_verify_declare_only_symbols",
    "enable_object_caching",
    "serialize_using_object_code",
)
_NEEDED_OF_MACHINES = "create_library", "magic_tuple", "set_env"
_NEEDED_OF_ENGINES = "_load_defined_symbols", "is_symbol_defined"

_LISTED = "object with its names"
"""How a library is kept: machine code, intermediate code, names defined."""

_environments: dict[str, Any] = {}
"""What `set_env` was told of functions that have no machine code yet."""


class LinkedLibrary(codegen.JITCodeLibrary):
    """A library of code that is compiled only if it is called from outside."""

    _only_linked = False
    _unparsed: bytes | None = None

    def serialize_using_object_code(self):
        """Returns what is kept on disk."""
        name, _, (machine_code, intermediate_code) = (
            super().serialize_using_object_code()
        )
        module = self._get_module_for_linking()
        names = [
            symbol.name
            for symbols in (module.functions, module.global_variables)
            for symbol in symbols
            if not symbol.is_declaration
        ]
        return name, _LISTED, (machine_code, intermediate_code, names)

    @classmethod
    def _unserialize(cls, codegen, state):
        name, kind, data = state
        if kind != _LISTED:
            return super()._unserialize(codegen, state)
        machine_code, intermediate_code, names = data
        library = codegen.create_library(name)
        library.enable_object_caching()
        library._set_compiled_object(machine_code)
        library._unparsed = intermediate_code
        library._finalize_final_module()
        codegen._engine._defined_symbols.update(names)
        return library

    def _get_module_for_linking(self):
        if self._unparsed is not None:
            self._shared_module = binding.parse_bitcode(self._unparsed)
            self._unparsed = None
        return super()._get_module_for_linking()

    def _optimize_functions(self, ll_module):
        # The passes over the whole module hold these.
        ll_module.data_layout = self._codegen._data_layout

    def _optimize_final_module(self):
        self._only_linked = not self._is_entered()
        if not self._only_linked:
            super()._optimize_final_module()

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
        """Returns the address of a function, 0 if it is not defined here."""
        self._ensure_finalized()
        if self._only_linked:
            if not any(f.name == name for f in self.get_defined_functions()):
                return 0
            self._compile()
        return super().get_pointer_to_function(name)

    def _get_compiled_object(self):
        if self._only_linked:
            self._compile()
        return super()._get_compiled_object()

    def _compile(self):
        """Makes machine code of it after all."""
        self._only_linked = False
        self._get_module_for_linking()  # As it is before it is compiled.
        super()._optimize_final_module()
        super()._finalize_final_module()

    def _is_entered(self) -> bool:
        """Whether it holds what Python calls, or what cannot be put off."""
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
    """Makes Numba use it from now on, once and for all in this process."""
    machine = codegen.JITCPUCodegen
    library = machine._library_class
    if library is not codegen.JITCodeLibrary:
        return
    for owner, names in (
        (library, _NEEDED_OF_LIBRARIES),
        (machine, _NEEDED_OF_MACHINES),
        (codegen.JitEngine, _NEEDED_OF_ENGINES),
    ):
        if not all(hasattr(owner, name) for name in names):
            return
    set_env, magic_tuple = machine.set_env, machine.magic_tuple

    def set_env_later(self, env_name, env):
        if self._engine.is_symbol_defined(env_name):
            set_env(self, env_name, env)
        else:
            _environments[env_name] = env

    # In the key of whatever is kept: Numba alone could not load it.
    machine.magic_tuple = lambda self: (*magic_tuple(self), _LISTED)
    machine.set_env = set_env_later
    machine._library_class = LinkedLibrary
