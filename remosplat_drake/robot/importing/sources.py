"""Reads a robot's file of any format as a URDF."""

from pathlib import Path

from remosplat_drake.base.errors import FieldError
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
from remosplat_drake.robot.importing.xacro_files import expand_xacro

XACRO = ".xacro"
"""Suffix of xacro files; all other formats are recognised by their content."""


def read_robot(
    path: Path,
    packages: Packages,
    arguments: dict[str, str],
    findings: Findings,
) -> tuple[Urdf, Srdf]:
    """Reads a robot from URDF, xacro, SDFormat, MJCF or model directives.

    URDF is read directly, which keeps elements that Drake's plants do not have.
    Other formats are parsed by Drake, and its plant is written as a URDF.

    Args:
        path: The file.
        packages: Resolves references to ROS packages.
        arguments: Arguments of a xacro by name.
        findings: Receives the values that were found.

    Returns:
        The robot, and the content of its file that an SRDF would contain; empty
        for a URDF.

    Raises:
        RemoSplatError: A file is missing, of another format, or broken, or the
            robot has parts that cannot be driven.
        MissingExtraError: The file is xacro, and xacro is not installed.
    """
    text = read_robot_text(path)
    if path.suffix.lower() == XACRO:
        return Urdf(
            path, expand_xacro(path, packages, arguments, findings)
        ), Srdf()
    if arguments:
        name = next(iter(arguments))
        raise FieldError(
            str(path), "--arg", f"{name}: only xacro has arguments"
        )
    dialect = dialect_of(path, text)
    if dialect is URDF:
        return Urdf(path, text), Srdf()
    return read_by_drake(path, dialect, packages, findings)
