"""`AddRobotView`: draws the robot in its measured configuration."""

import numpy as np
from pydrake.geometry import (
    MakePhongIllustrationProperties,
    Meshcat,
    MeshcatVisualizer,
    MeshcatVisualizerParams,
    Rgba,
    Role,
    RoleAssign,
    SceneGraph,
)
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import BodyIndex
from pydrake.systems.framework import Diagram, DiagramBuilder, InputPort
from pydrake.systems.primitives import AffineSystem
from pydrake.systems.rendering import MultibodyPositionToGeometryPose

from remosplat_drake.robot.meshes import link_meshes, register_link_meshes
from remosplat_drake.robot.model_file import add_robot_model
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.robot.visuals import load_visuals
from remosplat_drake.visualization.page import ROOT

PUBLISH_PERIOD = 1 / 32
"""Time between two pictures of everything that moves [s]."""

_NAME = "robot_view"
_GREY = Rgba(0.75, 0.76, 0.78)


def AddRobotView(
    builder: DiagramBuilder, robot: RobotModel, meshcat: Meshcat
) -> InputPort:
    """Adds the systems that draw a robot from its configuration alone.

    They know of no station, so a simulated and a real robot look the same.
    Links are drawn from their meshes, or from their collision geometry where
    there is none.

    Args:
        builder: Builder of the diagram; it gets a scene graph of the view's
            own, kinematics and a visualizer.
        robot: The robot to draw.
        meshcat: The Meshcat server; the robot is drawn below
            `/remosplat/robot`.

    Returns:
        The input port for the configuration q, shape (n_q,), which the caller
        connects.
    """
    scene_graph = builder.AddNamedSystem("robot_view_scene", SceneGraph())
    plant = make_drawn_plant(robot, scene_graph)
    to_pose = builder.AddNamedSystem(
        "robot_view_kinematics", MultibodyPositionToGeometryPose(plant)
    )
    positions = builder.AddNamedSystem(
        "robot_view_positions", _plant_positions(robot, plant)
    )
    builder.Connect(positions.get_output_port(), to_pose.get_input_port())
    builder.Connect(
        to_pose.get_output_port(),
        scene_graph.get_source_pose_port(plant.get_source_id()),
    )
    visualizer = MeshcatVisualizer.AddToBuilder(
        builder,
        scene_graph,
        meshcat,
        MeshcatVisualizerParams(
            role=Role.kIllustration,
            publish_period=PUBLISH_PERIOD,
            prefix=f"{ROOT}/robot",
            # A run must not wipe off what was drawn before it began.
            delete_on_initialization_event=False,
        ),
    )
    visualizer.set_name(_NAME)
    return positions.get_input_port()


def draw_robot(diagram: Diagram) -> None:
    """Draws the robot where it starts, before anything moves.

    Args:
        diagram: A diagram with the systems of `AddRobotView`.
    """
    context = diagram.CreateDefaultContext()
    view = diagram.GetSubsystemByName(_NAME)
    view.ForcedPublish(view.GetMyContextFromRoot(context))


def make_drawn_plant(
    robot: RobotModel, scene_graph: SceneGraph
) -> MultibodyPlant:
    """Makes a plant whose links have the look of the robot.

    Args:
        robot: The robot.
        scene_graph: Scene graph that gets the illustration geometry: the
            links' meshes, or their collision geometry where there are none.

    Returns:
        The finalized plant.
    """
    description = robot.description
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
    _show_collision_geometry(plant, scene_graph, colours)
    return plant


def _show_collision_geometry(
    plant: MultibodyPlant, scene_graph: SceneGraph, colours: dict[str, Rgba]
):
    """Makes the primitives of links without any other look visible."""
    for i in range(plant.num_bodies()):
        body = plant.get_body(BodyIndex(i))
        if plant.GetVisualGeometriesForBody(body):
            continue
        properties = MakePhongIllustrationProperties(
            colours.get(body.name(), _GREY).rgba
        )
        for geometry in plant.GetCollisionGeometriesForBody(body):
            scene_graph.AssignRole(
                plant.get_source_id(), geometry, properties, RoleAssign.kNew
            )


def _plant_positions(robot: RobotModel, plant: MultibodyPlant) -> AffineSystem:
    """Maps q to the plant's positions; locked joints are constants."""
    n = plant.num_positions()
    D = np.zeros((n, robot.n_q))
    y0 = np.zeros(n)
    for i, name in enumerate(robot.joint_names):
        D[plant.GetJointByName(name).position_start(), i] = 1.0
    for name, value in robot.description.locked.items():
        y0[plant.GetJointByName(name).position_start()] = value
    none = np.zeros((0, 0))
    return AffineSystem(
        A=none,
        B=np.zeros((0, robot.n_q)),
        f0=np.zeros(0),
        C=np.zeros((n, 0)),
        D=D,
        y0=y0,
    )
