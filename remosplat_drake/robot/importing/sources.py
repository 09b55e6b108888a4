"""A robot's file, whatever it is written in, as a URDF."""

import contextlib
import importlib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from remosplat_drake.base.errors import FileError, RemoSplatError
from remosplat_drake.base.system_libraries import import_optional
from remosplat_drake.robot.importing.dialects import URDF
from remosplat_drake.robot.importing.drake_formats import read_by_drake
from remosplat_drake.robot.importing.findings import Findings
from remosplat_drake.robot.importing.packages import Packages
from remosplat_drake.robot.importing.srdf import Srdf
from remosplat_drake.robot.importing.staging import (
    dialect_of,
    read_robot_text,
)
from remosplat_drake.robot.importing.urdf import Urdf

XACRO = ".xacro"
"""Ending of xacro files, which are told by it; all others by their content."""


def read_robot(
    path: Path,
    packages: Packages,
    arguments: dict[str, str],
    findings: Findings,
) -> tuple[Urdf, Srdf]:
    """Reads a robot from URDF, xacro, SDFormat, MJCF or model directives.

    URDF is read as it stands, with what Drake's plants do not keep. The others
    are parsed by Drake, and its plant is written as a URDF.

    Args:
        path: The file.
        packages: Finds the files of packages that it names.
        arguments: Arguments of a xacro by name.
        findings: Where it is noted what was found.

    Returns:
        The robot, and what an SRDF would say of it; nothing for a URDF.

    Raises:
        RemoSplatError: A file is missing, of another kind, or broken, or the
            robot has what cannot be driven.
        MissingExtraError: It is xacro, which is not installed.
    """
    text = read_robot_text(path)
    if path.suffix.lower() == XACRO:
        return Urdf(path, _expanded(path, packages, arguments)), Srdf()
    dialect = dialect_of(path, text)
    if dialect is URDF:
        return Urdf(path, text), Srdf()
    return read_by_drake(path, dialect, packages, findings)


def _expanded(path: Path, packages: Packages, arguments: dict[str, str]) -> str:
    xacro = import_optional("xacro", "reading xacro", "robots")
    with _packages_of(packages):
        try:
            document = xacro.process_file(str(path), mappings=arguments)
        # Errors of many kinds, as a file may hold Python.
        except Exception as error:
            for cause in _causes(error):
                if isinstance(cause, RemoSplatError):
                    raise cause from error
            problem = " ".join(str(error).split()) or type(error).__name__
            raise FileError(path, f"xacro: {problem}") from error
    return document.toxml()


def _causes(error: BaseException | None) -> Iterator[BaseException]:
    """An error and those that it was made of, by Python or by xacro."""
    while error is not None:
        yield error
        wrapped = getattr(error, "exc", None)
        error = wrapped or error.__cause__ or error.__context__


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
