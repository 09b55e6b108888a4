"""Adds the stage that predicts the robot's state from its measurements."""

from collections.abc import Iterable

from pydrake.systems.framework import (
    Diagram,
    DiagramBuilder,
    LeafSystem,
    OutputPort,
)

from remosplat_drake.app.scenario import Scenario
from remosplat_drake.controller.prediction.motion_predictor import (
    MotionPredictor,
)
from remosplat_drake.robot.actuators import ActuatorModel
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.signals import station_ports as ports
from remosplat_drake.station.actuated_command import ActuatedCommand

_STEPS = 4
"""Number of simulation steps of a robot's actuators in a control period."""


def AddPrediction(
    builder: DiagramBuilder,
    scenario: Scenario,
    robot: RobotModel,
    station: Diagram,
    *,
    hardware: bool,
) -> MotionPredictor | None:
    """Adds the predictor if the robot's axes follow commands with a delay.

    A simulated robot whose description has no actuators executes commands at
    once and needs no predictor. For a real robot whose axes have not been
    identified, cautious default delays are assumed.

    Args:
        builder: The builder of the diagram.
        scenario: The scenario.
        robot: The robot.
        station: The robot, simulated or real, as a system.
        hardware: Whether the station is the real robot.
    """
    actuators = robot.description.actuators
    if hardware and scenario.hardware.shadow:
        return None  # Nothing is sent, so nothing is in flight.
    if hardware:
        actuators = robot.assumed_actuators
    if not actuators:
        return None
    predictor = builder.AddSystem(
        MotionPredictor(
            robot=robot,
            model=ActuatorModel.make(actuators),
            period=scenario.control_period,
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


def AddActuators(
    builder: DiagramBuilder,
    scenario: Scenario,
    robot: RobotModel,
    executed: OutputPort,
) -> OutputPort:
    """Adds the delays and lags of a robot's description to its simulation.

    Args:
        builder: The builder of the diagram.
        scenario: The scenario.
        robot: The robot. If its description has no actuators, it executes
            commands at once.
        executed: The output port of the command u that the station gets.

    Returns:
        The output port of the velocities that the robot executes.
    """
    if not robot.description.actuators:
        return executed
    actuators = builder.AddSystem(
        ActuatedCommand(
            model=ActuatorModel.make(robot.description.actuators),
            step=scenario.control_period / _STEPS,
        )
    )
    builder.Connect(executed, actuators.get_input_port())
    return actuators.get_output_port()


def ConnectPrediction(
    builder: DiagramBuilder,
    predictor: MotionPredictor,
    readers: Iterable[LeafSystem],
    **inputs: OutputPort,
) -> None:
    """Connects the predictor with the stages of a closed loop.

    Args:
        builder: The builder of the diagram.
        predictor: The predictor that `AddPrediction` made.
        readers: The systems that read the predicted `Motion`.
        inputs: The output ports for the predictor's inputs, keyed by the
            input's name.
    """
    for name, port in inputs.items():
        builder.Connect(port, predictor.GetInputPort(name))
    for system in readers:
        builder.Connect(
            predictor.GetOutputPort("motion"), system.GetInputPort("motion")
        )
