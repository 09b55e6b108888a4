"""`RobotView`: draws the robot at its measured configuration."""

import numpy as np
from pydrake.geometry import Meshcat
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import RigidBody
from pydrake.systems.framework import (
    Context,
    Diagram,
    DiagramBuilder,
    InputPort,
    LeafSystem,
)

from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.visualization.drawn_plant import drawn_plant
from remosplat_drake.visualization.page import MeshcatPage
from remosplat_drake.visualization.scene_look import ROOT

PUBLISH_PERIOD = 1 / 32
"""Time between two updates of moving objects [s]."""

PREFIX = f"{ROOT}/robot"

_NAME = "robot_view"


class RobotView(LeafSystem):
    """Draws a robot from its configuration.

    .. pydrake_system::

        name: RobotView
        input_ports:
        - configuration

    The view is the same for simulated and real robots, since it needs only the
    configuration. It draws links below `/remosplat/robot`, as meshes or, if a
    link has none, as collision geometry. The shapes are sent once, at the
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
    """Draws the robot at its start, before anything moves.

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
        A plant that computes the links' poses, and the paths of the links with
        a shape.
    """
    drawn, paths = drawn_plant(robot), []
    for body in drawn.bodies:
        name = body.scoped_name().get_full().replace("::", "/")
        path = f"{PREFIX}/{name}"
        looks = drawn.looks(body)
        if looks:
            paths.append((body, path))
        if meshcat.HasPath(path):
            continue  # `draw_first` has sent its shapes.
        for i, look in enumerate(looks):
            meshcat.SetObject(f"{path}/{i}", look.shape, look.colour)
            meshcat.SetTransform(f"{path}/{i}", look.X_LG)
    return drawn.plant, paths


def _plant_positions(
    robot: RobotModel, plant: MultibodyPlant
) -> tuple[np.ndarray, np.ndarray]:
    """Returns the affine map (matrix and vector) from q to plant positions.

    Positions of locked joints are constants in the vector.
    """
    n = plant.num_positions()
    D = np.zeros((n, robot.n_q))
    y0 = np.zeros(n)
    for i, name in enumerate(robot.joint_names):
        D[plant.GetJointByName(name).position_start(), i] = 1.0
    for name, value in robot.description.locked.items():
        y0[plant.GetJointByName(name).position_start()] = value
    return D, y0
