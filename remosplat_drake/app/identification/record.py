"""Writes identified actuators into a robot's description."""

import dataclasses as dc
import re
from collections.abc import Sequence
from pathlib import Path

from remosplat_drake.base.atomic_file import (
    replace_checked,
    write_atomically,
)
from remosplat_drake.base.yaml_nodes import read_text
from remosplat_drake.robot.actuators import Actuator
from remosplat_drake.robot.robot_description import load_robot_description

_BLOCK = re.compile(
    r"^(?:# Identified [^\n]*\n)?actuators:.*\n(?:[ \-#].*\n|\n)*", re.MULTILINE
)


def with_actuators(
    text: str, actuators: Sequence[Actuator], names: Sequence[str], when: str
) -> str:
    """Returns a description's text with new actuators.

    Args:
        text: The description's YAML.
        actuators: The actuators, in the order of u.
        names: Names of the axes, for comments.
        when: The date, for a comment.
    """
    lines = [f"# Identified on {when}: {', '.join(names)}.", "actuators:"]
    for actuator in actuators:
        fields = ", ".join(
            f"{name}: {value:.6g}"
            for name, value in dc.asdict(actuator).items()
            if value is not None
        )
        lines.append(f"- {{{fields}}}")
    block = "\n".join(lines) + "\n"
    rest = _BLOCK.sub("", text)
    return rest.rstrip("\n") + "\n" + block


def write_actuators(
    path: Path, actuators: Sequence[Actuator], names: Sequence[str], when: str
) -> Path:
    """Writes actuators into a description file; keeps a copy of the old file.

    Args:
        path: Path of the description.
        actuators: The actuators, in the order of u.
        names: Names of the axes.
        when: The date.

    Returns:
        Path of the copy of the old file.

    Raises:
        RemoSplatError: One of the files cannot be read or written, or the
            result is not a valid description. The description file is then
            unchanged.
    """
    text = read_text(path)
    kept = path.with_suffix(".before_identify.yaml")
    write_atomically(kept, text)
    replace_checked(
        path,
        with_actuators(text, actuators, names, when),
        lambda: load_robot_description(path),
    )
    return kept
