"""`DrawnPlant`: the shapes and colours of a robot's links, for all views."""

import dataclasses as dc
from functools import lru_cache

from pydrake.geometry import (
    IllustrationProperties,
    MakePhongIllustrationProperties,
    Rgba,
    Role,
    RoleAssign,
    SceneGraph,
    Shape,
)
from pydrake.math import RigidTransform
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import BodyIndex, RigidBody

from remosplat_drake.robot.meshes import link_meshes, register_link_meshes
from remosplat_drake.robot.model_file import add_robot_model
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.robot.visuals import load_visuals

GREY = Rgba(0.75, 0.76, 0.78)
"""Colour of shapes without a colour."""


@dc.dataclass(frozen=True, eq=False)
class Look:
    """A shape of a link.

    Attributes:
        shape: The shape. A mesh may contain materials.
        colour: Colour of a shape without materials.
        X_LG: Pose of the shape's frame G in the link's frame L.
    """

    shape: Shape
    colour: Rgba
    X_LG: RigidTransform


@dc.dataclass(frozen=True, eq=False)
class DrawnPlant:
    """A plant whose links have the shapes and colours of a robot's links.

    Attributes:
        plant: The finalized plant.
        scene_graph: Scene graph with the illustration geometry: the links'
            meshes, or the collision geometry of links without meshes.
    """

    plant: MultibodyPlant
    scene_graph: SceneGraph

    @property
    def bodies(self) -> list[RigidBody]:
        """All bodies of the plant."""
        plant = self.plant
        return [plant.get_body(BodyIndex(i)) for i in range(plant.num_bodies())]

    def looks(self, body: RigidBody) -> list[Look]:
        """Returns the shapes of a body.

        Args:
            body: The body.
        """
        inspector = self.scene_graph.model_inspector()
        frame = self.plant.GetBodyFrameIdOrThrow(body.index())
        return [
            Look(
                inspector.GetShape(geometry),
                _colour(inspector.GetIllustrationProperties(geometry)),
                inspector.GetPoseInFrame(geometry),
            )
            for geometry in inspector.GetGeometries(frame, Role.kIllustration)
        ]


@lru_cache(maxsize=4)
def drawn_plant(robot: RobotModel) -> DrawnPlant:
    """Returns a plant with the appearance of a robot's links; caches it.

    Args:
        robot: The robot.
    """
    scene_graph, description = SceneGraph(), robot.description
    plant = MultibodyPlant(time_step=0.0)
    plant.RegisterAsSourceForSceneGraph(scene_graph)
    add_robot_model(description, plant)
    colours = {}
    visuals = description.visuals_path
    if visuals is not None:
        register_link_meshes(link_meshes(visuals), plant)
        colours = {
            link: Rgba(*entries[0].colour)
            for link, entries in load_visuals(visuals).items()
        }
    plant.Finalize()
    drawn = DrawnPlant(plant, scene_graph)
    _show_collision_geometry(drawn, colours)
    return drawn


def _show_collision_geometry(drawn: DrawnPlant, colours: dict[str, Rgba]):
    """Shows the collision geometry of links without illustration geometry."""
    plant = drawn.plant
    for body in drawn.bodies:
        if plant.GetVisualGeometriesForBody(body):
            continue
        properties = MakePhongIllustrationProperties(
            colours.get(body.name(), GREY).rgba
        )
        for geometry in plant.GetCollisionGeometriesForBody(body):
            drawn.scene_graph.AssignRole(
                plant.get_source_id(), geometry, properties, RoleAssign.kNew
            )


def _colour(properties: IllustrationProperties | None) -> Rgba:
    if properties is None or not properties.HasProperty("phong", "diffuse"):
        return GREY
    return properties.GetProperty("phong", "diffuse")
