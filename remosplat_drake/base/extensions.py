"""Finds classes of other packages, which files name `package.module:Class`.

A field accepts such a class if its annotation contains a `Protocol`:

    oracle: SphereToEllipsoid | GroundTruth | OracleMaker

In this example, the field accepts any `Config` dataclass that has the methods
of the protocol `OracleMaker`. The fields of such a class are declared and
checked in the same way as those of this package's classes. A YAML file names
the class as a tag, `!my_package:MyOracle {gain: 2}`, or as plain text, which
gives the class's default values.
"""

import dataclasses as dc
import importlib
import importlib.util
import inspect
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any, cast

from remosplat_drake.base.errors import RemoSplatError, unknown_name
from remosplat_drake.base.ranges import (
    Config,
    field_types,
    misfit,
    schema_problem,
    shown,
)


def find_extension(
    name: str, protocols: list[type], folder: Path | None = None
) -> type[Config]:
    """Imports and returns the class of a given name.

    Python's import path is searched first. If the module is not found there,
    `folder` is appended to `sys.path`, which child processes inherit. Since
    `folder` is the last entry of the path, it hides no installed module.

    Args:
        name: The name, as `package.module:Class`.
        protocols: Protocols; the class must have all methods of at least one of
            them.
        folder: Folder of the file that names the class.

    Raises:
        RemoSplatError: There is no such class, or the class lacks a required
            method.
    """
    module, _, class_name = name.partition(":")
    parts = [*module.split("."), class_name]
    if not all(part.isidentifier() for part in parts):
        raise RemoSplatError(
            f"expected package.module:Class, got {shown(name)}"
        )
    found: Any = vars(_import(module, folder)).get(class_name)
    if found is None:
        classes = [n for n, c in _classes(module) if c is not Config]
        raise RemoSplatError(
            f"{module}: {unknown_name('class', class_name, classes)}"
        )
    if not (_is_config(found) and dc.is_dataclass(found)):
        raise RemoSplatError(f"{name} is not a dataclass derived from Config")
    found = cast(type[Config], found)
    problem = misfit(found, protocols) or schema_problem(found)
    if problem:
        raise RemoSplatError(f"{name} {problem}")
    return found


def _import(module: str, folder: Path | None):
    try:
        top, *_ = module.split(".")
        if folder is not None and importlib.util.find_spec(top) is None:
            sys.path.append(str(folder.resolve()))
            importlib.invalidate_caches()
        return importlib.import_module(module)
    except Exception as error:
        problem = " ".join(f"{type(error).__name__}: {error}".split())
        raise RemoSplatError(f"cannot import {module}: {problem}") from error


def _classes(module: str) -> list[tuple[str, type]]:
    return inspect.getmembers(sys.modules[module], _is_config)


def _is_config(found: object) -> bool:
    return isinstance(found, type) and issubclass(found, Config)


def extension_name(kind: type) -> str:
    """Returns the name by which `find_extension` finds a class.

    Raises:
        RemoSplatError: The class is not in a module that can be imported by
            name.
    """
    name = kind.__qualname__
    if kind.__module__ == "__main__" or not name.isidentifier():
        raise RemoSplatError(
            f"{name} cannot be named in a file: move it into a module"
        )
    return f"{kind.__module__}:{name}"


def extensions_in(config: Config) -> Iterator[Config]:
    """Returns the configurations in `config` that other packages define."""
    for name in field_types(type(config)):
        yield from _extensions_of(getattr(config, name))


def _extensions_of(value: Any) -> Iterator[Config]:
    if isinstance(value, Config):
        if not value.__module__.startswith("remosplat_drake."):
            yield value
        yield from extensions_in(value)
    elif isinstance(value, list):
        for item in value:
            yield from _extensions_of(item)
