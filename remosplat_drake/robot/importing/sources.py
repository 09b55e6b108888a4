"""The text of a robot's URDF, whatever its file is written in."""

import contextlib
import importlib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from remosplat_drake.base.errors import FileError, RemoSplatError
from remosplat_drake.base.system_libraries import import_optional
from remosplat_drake.robot.importing.packages import Packages

URDFS, XACROS = (".urdf",), (".xacro",)


def read_urdf_text(
    path: Path, packages: Packages, arguments: dict[str, str]
) -> str:
    """Reads a URDF, or expands the xacro that makes one.

    Args:
        path: The file.
        packages: Finds the packages that `$(find NAME)` means.
        arguments: Arguments of the xacro by name.

    Raises:
        FileError: The file is missing, of another kind, or broken.
        MissingExtraError: It is xacro, which is not installed.
    """
    if not path.is_file():
        raise FileError(path, "no such file")
    suffix = path.suffix.lower()
    if suffix in XACROS:
        return _expanded(path, packages, arguments)
    if suffix not in URDFS:
        raise FileError(path, "expected a .urdf or .xacro file")
    try:
        return path.read_text(encoding="utf-8-sig")
    except (OSError, UnicodeDecodeError) as error:
        raise FileError(path, f"cannot be read: {error}") from error


def _expanded(path: Path, packages: Packages, arguments: dict[str, str]) -> str:
    xacro = import_optional("xacro", "reading xacro", "robots")
    with _packages_of(packages):
        try:
            document = xacro.process_file(str(path), mappings=arguments)
        except RemoSplatError:
            raise
        # Errors of many kinds, as a file may hold Python.
        except Exception as error:
            problem = " ".join(str(error).split()) or type(error).__name__
            raise FileError(path, f"xacro: {problem}") from error
    return document.toxml()


@contextlib.contextmanager
def _packages_of(packages: Packages) -> Iterator[None]:
    """Has `$(find NAME)` answered by us, not by a ROS installation."""
    module: Any = importlib.import_module("xacro.substitution_args")
    before = module._eval_find
    module._eval_find = lambda name: str(
        packages.folder(name, f"$(find {name})").absolute()
    )
    try:
        yield
    finally:
        module._eval_find = before
