"""Writes the text of a robot description file, with guesses in comments."""

from collections.abc import Sequence

import yaml

from remosplat_drake.robot.importing.findings import Findings
from remosplat_drake.robot.robot_description import (
    DIFFERENTIAL,
    RobotDescription,
)


def description_text(
    description: RobotDescription, made_by: str, findings: Findings
) -> str:
    """Returns a description's text, with guesses and doubts in comments.

    Args:
        description: The description; empty fields are omitted.
        made_by: Command line that made it.
        findings: Guesses and doubts.
    """
    lines = [
        f"# Made by `{made_by}`.",
        *(f"# DOUBTFUL: {what}: {value}" for what, value in findings.doubted),
        "# Guessed; please check:",
        *(f"#   {what}: {value}" for what, value in findings.guessed),
        "# Velocities are in the order of u: base, if any, then arm. SI units.",
    ]
    if description.base is not None:
        base = description.base
        section = {"joints": base.joints, "body": base.body}
        if base.drive != DIFFERENTIAL:
            section = {"drive": base.drive, **section}
    else:
        section = None
    arm = description.arm
    fields = {
        "name": description.name,
        "model": description.model,
        "base": section,
        "arm": {"name": arm.name, "joints": arm.joints, "mount": arm.mount},
        "end_effector_frame": description.end_effector_frame,
        "end_effectors": description.end_effectors,
        "velocity_limits": description.velocity_limits,
        "acceleration_limits": description.acceleration_limits,
        "home": description.home,
        "locked": description.locked,
        "floor_links": description.floor_links,
        "allowed_collisions": getattr(description, "allowed_collisions", []),
        "spheres": description.spheres,
    }
    for name, value in fields.items():
        if value:
            lines.append(_entry(name, value))
    return "\n".join(lines) + "\n"


def _entry(name: str, value: object) -> str:
    flat = isinstance(value, Sequence) and not isinstance(value, str)
    return yaml.safe_dump(
        {name: value},
        sort_keys=False,
        default_flow_style=None if flat else False,
        width=80,
    ).rstrip()
