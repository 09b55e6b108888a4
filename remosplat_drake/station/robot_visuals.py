"""Adds visual shapes of the robot to a plant, for a simulated camera."""

import numpy as np
from pydrake.geometry import GeometryInstance, Mesh, SceneGraph
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import RigidBody

from remosplat_drake.robot.meshes import link_meshes
from remosplat_drake.robot.robot_model import RobotModel

PRIMITIVE_COLOUR = np.array([0.9, 0.9, 0.9, 1.0])
"""Colour (RGBA) of links that are drawn by their collision primitives."""


def add_robot_visuals(
    plant: MultibodyPlant, scene_graph: SceneGraph, robot: RobotModel
) -> None:
    """Adds a link's meshes, or else its collision primitives, as visuals.

    Links with visuals in the model file are left unchanged.

    Args:
        plant: The plant with the robot, before `Finalize`.
        scene_graph: The plant's scene graph.
        robot: The robot.
    """
    visuals = robot.description.visuals_path
    meshes = {} if visuals is None else link_meshes(visuals)
    for name in robot.tree.names[1:]:
        body = plant.GetBodyByName(name)
        if plant.GetVisualGeometriesForBody(body):
            continue
        for i, mesh in enumerate(meshes.get(name, ())):
            plant.RegisterVisualGeometry(
                body,
                GeometryInstance(mesh.X_LV, Mesh(mesh.path), f"visual_{i}"),
            )
        if name not in meshes:
            _draw_collision_geometry(plant, scene_graph, body)


def _draw_collision_geometry(
    plant: MultibodyPlant, scene_graph: SceneGraph, body: RigidBody
) -> None:
    inspector = scene_graph.model_inspector()
    for i, geometry in enumerate(plant.GetCollisionGeometriesForBody(body)):
        plant.RegisterVisualGeometry(
            body,
            inspector.GetPoseInFrame(geometry),
            inspector.GetShape(geometry),
            f"visual_{i}",
            PRIMITIVE_COLOUR,
        )
