"""A scenario as text that stands alone, wherever it is put."""

import copy
from pathlib import Path

from pydrake.common.yaml import yaml_dump_typed

from remosplat_drake.resources import PACKAGE_SCHEME, resolve
from remosplat_drake.scenario import Scenario

_SCENE_FILES = ("splat", "truth", "truth_later")


def scenario_text(scenario: Scenario, name: str) -> str:
    """The YAML of a file with this one scenario in it.

    Every value is written out, so that later defaults change nothing, and
    relative files become absolute ones.

    Args:
        scenario: A checked scenario.
        name: Of its entry.

    Raises:
        FileError: One of its files is not there.
    """
    alone = copy.deepcopy(scenario)
    for field in _SCENE_FILES:
        uri = getattr(alone.scene, field)
        setattr(alone.scene, field, _absolute(uri, scenario.folder))
    if Path(alone.robot.model).exists():
        alone.robot.model = _absolute(alone.robot.model, Path())
    if alone.teleop.trajectory:
        alone.teleop.trajectory = _absolute(
            alone.teleop.trajectory, scenario.folder
        )
    # Where it was read from is no field of a file; Drake writes it last.
    alone.source = ""
    text = yaml_dump_typed({name: alone}, schema=dict[str, Scenario])
    return text.rstrip("\n").removesuffix("  source: ''")


def _absolute(uri: str, folder: Path) -> str:
    if not uri or uri.startswith(PACKAGE_SCHEME):
        return uri
    return str(resolve(uri, folder).resolve())
