"""`RobotView`: draws the robot in its measured configuration."""

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
from pydrake.multibody.tree import BodyIndex, RigidBody
from pydrake.systems.framework import (
    Context,
    Diagram,
    DiagramBuilder,
    InputPort,
    LeafSystem,
)

from remosplat_drake.robot.meshes import link_meshes, register_link_meshes
from remosplat_drake.robot.model_file import add_robot_model
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.robot.visuals import load_visuals
from remosplat_drake.visualization.page import MeshcatPage
from remosplat_drake.visualization.scene_look import ROOT

PUBLISH_PERIOD = 1 / 32
"""Time between two pictures of everything that moves [s]."""

PREFIX = f"{ROOT}/robot"

_NAME = "robot_view"
_GREY = Rgba(0.75, 0.76, 0.78)


class RobotView(LeafSystem):
    """Draws a robot from its configuration alone.

    .. pydrake_system::

        name: RobotView
        input_ports:
        - configuration

    It sees no station, so a simulated and a real robot look the same. Links
    are drawn from their meshes, or from their collision geometry where there
    is none, below `/remosplat/robot`. Their shapes are sent once, at the
    start.

    Args:
        page: The page to draw on.
        robot: The robot to draw.
    """

    def __init__(self, *, page: MeshcatPage, robot: RobotModel):
        super().__init__()
        self.set_name(_NAME)
        self._scene = page.scene
        self._plant, self._paths = _draw_links(page.meshcat, robot)
        self._at = self._plant.CreateDefaultContext()
        self._D, self._y0 = _plant_positions(robot, self._plant)
        self._configuration_input = self.DeclareVectorInputPort(
            "configuration", robot.n_q
        )
        self.DeclarePeriodicPublishEvent(PUBLISH_PERIOD, 0.0, self._publish)
        self.DeclareForcedPublishEvent(self._publish)

    def _publish(self, context: Context):
        q = self._configuration_input.Eval(context)
        self._plant.SetPositions(self._at, self._D @ q + self._y0)
        for body, path in self._paths:
            X_WB = self._plant.EvalBodyPoseInWorld(self._at, body)
            self._scene.move(path, X_WB, context.get_time())


def AddRobotView(
    builder: DiagramBuilder, robot: RobotModel, page: MeshcatPage
) -> InputPort:
    """Adds a `RobotView` to a diagram.

    Args:
        builder: Builder of the diagram.
        robot: The robot to draw.
        page: The page to draw on.

    Returns:
        The input port for the configuration q, shape (n_q,), which the caller
        connects.
    """
    view = builder.AddSystem(RobotView(page=page, robot=robot))
    return view.GetInputPort("configuration")


def draw_robot(diagram: Diagram) -> None:
    """Draws the robot where it starts, before anything moves.

    Args:
        diagram: A diagram with a `RobotView`.
    """
    context = diagram.CreateDefaultContext()
    view = diagram.GetSubsystemByName(_NAME)
    view.ForcedPublish(view.GetMyContextFromRoot(context))


def _draw_links(
    meshcat: Meshcat, robot: RobotModel
) -> tuple[MultibodyPlant, list[tuple[RigidBody, str]]]:
    """Draws the links once.

    Returns:
        A plant for their poses, and each link that has a shape with its path.
    """
    builder = DiagramBuilder()
    scene_graph = builder.AddNamedSystem("scene_graph", SceneGraph())
    plant = make_drawn_plant(robot, scene_graph)
    builder.AddSystem(plant)
    builder.Connect(
        plant.get_geometry_pose_output_port(),
        scene_graph.get_source_pose_port(plant.get_source_id()),
    )
    MeshcatVisualizer.AddToBuilder(
        builder,
        scene_graph,
        meshcat,
        MeshcatVisualizerParams(
            role=Role.kIllustration,
            prefix=PREFIX,
            # A run must not wipe off what was drawn before it began.
            delete_on_initialization_event=False,
        ),
    )
    diagram = builder.Build()
    bodies = (plant.get_body(BodyIndex(i)) for i in range(plant.num_bodies()))
    paths = [
        (body, f"{PREFIX}/{body.scoped_name().get_full().replace('::', '/')}")
        for body in bodies
    ]
    if not any(meshcat.HasPath(path) for _, path in paths):
        # Else `draw_first` has sent them.
        diagram.ForcedPublish(diagram.CreateDefaultContext())
    return plant, [(b, path) for b, path in paths if meshcat.HasPath(path)]


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
    """Shows the primitives of links that have no other appearance."""
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


def _plant_positions(
    robot: RobotModel, plant: MultibodyPlant
) -> tuple[np.ndarray, np.ndarray]:
    """Matrix and vector that map q to positions; locked ones are constants."""
    n = plant.num_positions()
    D = np.zeros((n, robot.n_q))
    y0 = np.zeros(n)
    for i, name in enumerate(robot.joint_names):
        D[plant.GetJointByName(name).position_start(), i] = 1.0
    for name, value in robot.description.locked.items():
        y0[plant.GetJointByName(name).position_start()] = value
    return D, y0
