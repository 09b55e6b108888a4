"""Parsing of a robot's model file (URDF, SDF, *.dmd.yaml) into a plant."""

import re

from pydrake.multibody.parsing import (
    LoadModelDirectives,
    Parser,
    ProcessModelDirectives,
)
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import ModelInstanceIndex

from remosplat_drake.base import resources
from remosplat_drake.base.errors import FileError
from remosplat_drake.robot.robot_description import RobotDescription


def add_robot_model(
    description: RobotDescription, plant: MultibodyPlant
) -> list[ModelInstanceIndex]:
    """Parses the robot's model file into a plant, its roots welded to W.

    Args:
        description: The robot, whose `model` names the file.
        plant: A plant that is not yet finalized.

    Returns:
        Indices of the model instances that were added.

    Raises:
        FileError: The file is no model, or Drake refuses what it says.
    """
    parser = Parser(plant)
    parser.package_map().Add(
        "remosplat_drake", str(resources.models_dir().parent)
    )
    path = description.model_path
    try:
        if path.name.endswith(".dmd.yaml"):
            added = ProcessModelDirectives(
                LoadModelDirectives(str(path)), parser
            )
            return [info.model_instance for info in added]
        instances = parser.AddModels(str(path))
        _weld_roots_to_world(plant, instances)
        return instances
    # Where C++ would abort, since a limit is negative for example, Python is
    # asked to exit.
    except (RuntimeError, ValueError, SystemExit) as error:
        raise FileError(path, in_one_line(error)) from error


def in_one_line(error: BaseException) -> str:
    """What Drake says, without the place in its own sources."""
    text = " ".join(str(error).split())
    return re.sub(r"^Failure at \S+ in ", "Drake refuses it in ", text)


def _weld_roots_to_world(
    plant: MultibodyPlant, instances: list[ModelInstanceIndex]
) -> None:
    """Fixes each body without an inboard joint to the world's origin."""
    children = {
        plant.get_joint(joint).child_body().index()
        for joint in plant.GetJointIndices()
    }
    for instance in instances:
        for index in plant.GetBodyIndices(instance):
            if index not in children:
                root = plant.get_body(index).body_frame()
                plant.WeldFrames(plant.world_frame(), root)
