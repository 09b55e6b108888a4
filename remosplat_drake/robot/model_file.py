"""A robot's model file, parsed into a plant."""

from pydrake.multibody.parsing import (
    LoadModelDirectives,
    Parser,
    ProcessModelDirectives,
)
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import ModelInstanceIndex

from remosplat_drake import resources
from remosplat_drake.errors import FileError
from remosplat_drake.robot.robot_description import RobotDescription


def add_robot_model(
    description: RobotDescription, plant: MultibodyPlant
) -> list[ModelInstanceIndex]:
    """Parses the robot's model file into a plant.

    Returns:
        Indices of the model instances that were added.
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
    except (RuntimeError, ValueError) as error:
        raise FileError(path, " ".join(str(error).split())) from error


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
