"""Finds and loads the robot of a scenario."""

from pathlib import Path

from remosplat_drake.app.scenario import YAML_SUFFIXES, Scenario
from remosplat_drake.base import resources
from remosplat_drake.base.errors import FieldError, FileError
from remosplat_drake.robot.robot_description import (
    MODEL_SUFFIXES,
    load_robot_description,
)
from remosplat_drake.robot.robot_model import RobotModel, load_robot


def robot_file(scenario: Scenario) -> str:
    """Returns the name or file of a scenario's robot, for `load_robot`.

    A file is relative to the scenario's folder. If it does not exist there, it
    is relative to the working directory.

    Args:
        scenario: The scenario.

    Returns:
        The name of a shipped robot, or the path of a robot description file.

    Raises:
        FieldError: There is no such file.
    """
    model = scenario.robot.model
    if Path(model).suffix.lower() in MODEL_SUFFIXES:
        # An error of `load_robot` is raised again as an error of the scenario's
        # field.
        try:
            load_robot_description(model)
        except FileError as error:
            raise FieldError(
                scenario.source, "robot.model", str(error)
            ) from error
    if Path(model).suffix not in YAML_SUFFIXES:
        return model
    try:
        return str(resources.resolve(model, scenario.folder))
    except FileError as error:
        if resources.expand(model).is_file():
            return str(resources.expand(model))
        raise FieldError(scenario.source, "robot.model", str(error)) from error


def robot_beside(robot: str, folder: Path) -> str:
    """Returns the text by which a scenario file in a folder names a robot.

    Args:
        robot: Name of a shipped robot, or the path of a robot description file.
        folder: Folder of the scenario's file.
    """
    path = Path(robot)
    if path.suffix not in YAML_SUFFIXES:
        return robot
    path, folder = path.resolve(), folder.resolve()
    if path.is_relative_to(folder):
        return str(path.relative_to(folder))
    return str(path)


def load_scenario_robot(scenario: Scenario) -> RobotModel:
    """Loads a scenario's robot, with its spheres and the height of the floor.

    Args:
        scenario: The scenario.

    Raises:
        RemoSplatError: The robot or its set of spheres does not exist, or a
            file of the robot is unusable.
    """
    return load_robot(
        robot_file(scenario),
        scenario.robot.spheres,
        scenario.scene.floor_height,
    )
