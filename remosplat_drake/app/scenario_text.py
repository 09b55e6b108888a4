"""Writes a scenario as text that does not depend on the file's folder."""

import copy
from pathlib import Path

from remosplat_drake.app.scenario import Scenario
from remosplat_drake.app.scenario_robot import robot_file
from remosplat_drake.base.extensions import extensions_in
from remosplat_drake.base.resources import PACKAGE_SCHEME, resolve
from remosplat_drake.base.strict_yaml import dump
from remosplat_drake.scene.directives import with_absolute_files

_SCENE_FILES = ("splat", "truth", "truth_later")


def scenario_text(scenario: Scenario, name: str) -> str:
    """Writes a scenario as the YAML of a file with only this scenario.

    The text states every value, so that a later change of defaults does not
    affect it. Relative file names become absolute.

    Args:
        scenario: A checked scenario.
        name: Name of the scenario's entry in the file.

    Raises:
        FileError: One of the scenario's files is missing.
    """
    alone = copy.deepcopy(scenario)
    for field in _SCENE_FILES:
        uri = getattr(alone.scene, field)
        setattr(alone.scene, field, _absolute(uri, scenario.folder))
    alone.scene.directives = with_absolute_files(
        scenario.scene.directives, scenario.folder
    )
    robot = robot_file(scenario)
    if Path(robot).is_file():
        alone.robot.model = str(Path(robot).resolve())
    if alone.teleop.trajectory:
        alone.teleop.trajectory = _absolute(
            alone.teleop.trajectory, scenario.folder
        )
    if scenario.modules or any(extensions_in(scenario)):
        folder = scenario.folder / scenario.modules
        alone.modules = str(folder.resolve())
    return dump(name, alone)


def _absolute(uri: str, folder: Path) -> str:
    if not uri or uri.startswith(PACKAGE_SCHEME):
        return uri
    return str(resolve(uri, folder).resolve())
