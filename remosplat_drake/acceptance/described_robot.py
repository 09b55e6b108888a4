"""Writes a robot's description with other actuators to a file."""

from collections.abc import Sequence
from pathlib import Path

import yaml

from remosplat_drake.app.identification.record import with_actuators
from remosplat_drake.base.resources import PACKAGE_SCHEME
from remosplat_drake.base.yaml_nodes import read_text
from remosplat_drake.robot.actuators import Actuator
from remosplat_drake.robot.robot_description import load_robot_description


def write_description(
    path: Path, name: str, actuators: Sequence[Actuator] = ()
) -> None:
    """Writes a copy of a shipped robot's description, with other actuators.

    Args:
        path: Path of the file to write.
        name: Name of a shipped robot.
        actuators: The actuator models, in the order of u. If empty, the
            description contains none, as before their identification.
    """
    source = Path(load_robot_description(name).source)
    fields = yaml.safe_load(read_text(source))
    fields.pop("actuators", None)
    folder = f"{PACKAGE_SCHEME}models/{name}/"
    for field in ("model", "visuals"):
        fields[field] = folder + fields[field]
    fields["spheres"] = {
        spheres: folder + file for spheres, file in fields["spheres"].items()
    }
    text = yaml.safe_dump(fields, sort_keys=False)
    if actuators:
        text = with_actuators(text, actuators, ["u"], "a bench")
    path.write_text(text)
