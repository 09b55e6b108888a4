"""The stage between measurements and planning: where a robot is about to be."""

from typing import TYPE_CHECKING

from pydrake.systems.framework import Diagram, DiagramBuilder

from remosplat_drake.app.scenario import Scenario
from remosplat_drake.controller.prediction.motion_predictor import (
    MotionPredictor,
)
from remosplat_drake.hardware.wire.channels import COMMAND_EXPIRY
from remosplat_drake.robot.actuators import ActuatorModel, default_actuators
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.signals import station_ports as ports

if TYPE_CHECKING:
    from remosplat_drake.app.control_loop import ControlLoop


def AddPrediction(
    builder: DiagramBuilder,
    scenario: Scenario,
    robot: RobotModel,
    station: Diagram,
    *,
    hardware: bool,
) -> MotionPredictor | None:
    """Adds the predictor, where the robot does not obey at once.

    A real robot whose description has no actuators is taken to have those of
    `default_actuators`; a simulated one without them obeys at once.

    Args:
        builder: The builder of the diagram.
        scenario: The scenario.
        robot: The robot.
        station: The robot, simulated or real, as a system.
        hardware: Whether the station is the real robot.
    """
    actuators = robot.description.actuators
    if not actuators and hardware:
        actuators = default_actuators(robot.n_base, robot.n_u - robot.n_base)
    if not actuators:
        return None
    predictor = builder.AddSystem(
        MotionPredictor(
            robot=robot,
            model=ActuatorModel.make(actuators),
            period=scenario.control_period,
            expiry=COMMAND_EXPIRY,
        )
    )
    builder.Connect(
        station.GetOutputPort(ports.STATUS), predictor.GetInputPort("status")
    )
    if robot.n_base:
        builder.Connect(
            station.GetOutputPort(ports.BASE_VELOCITY),
            predictor.GetInputPort("base_velocity"),
        )
    return predictor


def ConnectPrediction(
    builder: DiagramBuilder, loop: "ControlLoop", predictor: MotionPredictor
) -> None:
    """Connects the predictor with the stages of a closed loop.

    Args:
        builder: The builder of the diagram.
        loop: The stages.
        predictor: The predictor that `AddPrediction` made.
    """
    for port, name in (
        (loop.configuration, "configuration"),
        (loop.odometry, "odometry"),
        (loop.executed, "velocity_executed"),
    ):
        builder.Connect(port, predictor.GetInputPort(name))
    motion = predictor.GetOutputPort("motion")
    for system in (loop.controller, loop.supervisor):
        if system is not None:
            builder.Connect(motion, system.GetInputPort("motion"))
