"""Parses a robot's model file (URDF, SDF, *.dmd.yaml) into a plant."""

import re

from pydrake.multibody.parsing import (
    LoadModelDirectives,
    Parser,
    ProcessModelDirectives,
)
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import Frame, FrameIndex, ModelInstanceIndex

from remosplat_drake.base import resources
from remosplat_drake.base.errors import FieldError, FileError, unknown_name
from remosplat_drake.robot.robot_description import RobotDescription


def add_robot_model(
    description: RobotDescription, plant: MultibodyPlant
) -> list[ModelInstanceIndex]:
    """Parses the robot's model file into a plant; welds its roots to W.

    Args:
        description: The robot, whose `model` names the file.
        plant: A plant that is not yet finalized.

    Returns:
        Indices of the model instances that were added.

    Raises:
        FileError: The file is not a model, or Drake rejects it.
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
    # Drake aborts in C++, for a negative limit for example; from Python, this
    # raises SystemExit.
    except (RuntimeError, ValueError, SystemExit) as error:
        raise FileError(path, in_one_line(error)) from error


def find_frame(
    plant: MultibodyPlant, name: str, where: str, field: str
) -> Frame:
    """Finds a frame of the robot's model by its name.

    Args:
        plant: The finalized plant with the robot.
        name: Name of the frame.
        where: Source to name in errors, such as a file.
        field: The field of `where` that contains the name.

    Raises:
        FieldError: There is no such frame; the text lists the existing frames.
    """
    if not plant.HasFrameNamed(name):
        known = _frame_names(plant)
        raise FieldError(where, field, unknown_name("frame", name, known))
    return plant.GetFrameByName(name)


def _frame_names(plant: MultibodyPlant) -> set[str]:
    """Names of the frames that may be used, except the world's."""
    names = {
        plant.get_frame(FrameIndex(i)).name() for i in range(plant.num_frames())
    }
    # Skips the frames that Drake adds on the parents of joints.
    joints = map(plant.get_joint, plant.GetJointIndices())
    added = {f"{joint.name()}_parent" for joint in joints}
    return names - added - {"", "world"}


def in_one_line(error: BaseException) -> str:
    """Returns Drake's message without the position in Drake's source code."""
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
