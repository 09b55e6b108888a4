"""Connects a station's ports with the vectors q and u of the whole robot."""

import math

from pydrake.systems.framework import Diagram, DiagramBuilder, OutputPort
from pydrake.systems.primitives import (
    ConstantVectorSource,
    Demultiplexer,
    Multiplexer,
)

from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.signals import station_ports as ports

_GRIP_FORCE = 20.0  # [N]


def AddConfiguration(
    builder: DiagramBuilder, robot: RobotModel, station: Diagram
) -> OutputPort:
    """Stacks a station's measurements into the configuration q.

    Args:
        builder: Builder of the diagram that holds the station.
        robot: The robot; its description names the ports.
        station: A simulated or the real station.

    Returns:
        Output port of the measured q, shape (n_q,) [m, rad].
    """
    arm = ports.arm_position(robot.description)
    return _Stack(
        builder, "configuration", robot, station, ports.BASE_POSE, arm
    )


def AddMeasuredVelocity(
    builder: DiagramBuilder, robot: RobotModel, station: Diagram
) -> OutputPort:
    """Stacks a station's measurements into the velocity u.

    Args:
        builder: Builder of the diagram that holds the station.
        robot: The robot; its description names the ports.
        station: A simulated or the real station.

    Returns:
        Output port of the measured u, shape (n_u,) [m/s, rad/s].
    """
    arm = ports.arm_velocity(robot.description)
    return _Stack(
        builder, "velocity_measured", robot, station, ports.BASE_VELOCITY, arm
    )


def _Stack(
    builder: DiagramBuilder,
    name: str,
    robot: RobotModel,
    station: Diagram,
    base: str,
    arm: str,
) -> OutputPort:
    """Stacks measurements of base and arm; a fixed base has none."""
    names = [base, arm] if robot.n_base else [arm]
    measured = [station.GetOutputPort(name) for name in names]
    multiplexer = builder.AddNamedSystem(
        name, Multiplexer([port.size() for port in measured])
    )
    for i, port in enumerate(measured):
        builder.Connect(port, multiplexer.get_input_port(i))
    return multiplexer.get_output_port()


def ConnectCommand(
    builder: DiagramBuilder,
    robot: RobotModel,
    velocity: OutputPort,
    station: Diagram,
    hands: OutputPort | None = None,
) -> None:
    """Connects the command u to base and arm, and the grippers' commands.

    Args:
        builder: Builder of the diagram that holds the station.
        robot: The robot; its description names the ports.
        velocity: Output port of the command u, shape (n_u,) [m/s, rad/s].
        station: A simulated or the real station.
        hands: Output port of width and force of each gripper [m, N]; None keeps
            the widths in the robot's description.
    """
    names = [ports.arm_command(robot.description)]
    if robot.n_base:
        names.insert(0, ports.BASE_COMMAND)
    inputs = [station.GetInputPort(name) for name in names]
    demultiplexer = builder.AddNamedSystem(
        "command", Demultiplexer([port.size() for port in inputs])
    )
    builder.Connect(velocity, demultiplexer.get_input_port())
    for i, port in enumerate(inputs):
        builder.Connect(demultiplexer.get_output_port(i), port)
    grippers = robot.description.effector_hands.values()
    if not grippers:
        return
    if hands is None:
        hands = _AddHeldHands(builder, robot)
    each = builder.AddNamedSystem(
        "hand_commands", Demultiplexer([2] * len(grippers))
    )
    builder.Connect(hands, each.get_input_port())
    for i, hand in enumerate(grippers):
        name = ports.hand_command(hand)
        builder.Connect(each.get_output_port(i), station.GetInputPort(name))


def AddHandStates(
    builder: DiagramBuilder, robot: RobotModel, station: Diagram
) -> OutputPort:
    """Stacks the readings of a robot's grippers.

    Args:
        builder: Builder of the diagram that holds the station.
        robot: The robot, with at least one gripper.
        station: A simulated or the real station.

    Returns:
        Output port of width, rate and force of each gripper [m, m/s, N].
    """
    hands = robot.description.effector_hands.values()
    stack = builder.AddNamedSystem("hand_states", Multiplexer([3] * len(hands)))
    for i, hand in enumerate(hands):
        measured = station.GetOutputPort(ports.hand_state(hand))
        builder.Connect(measured, stack.get_input_port(i))
    return stack.get_output_port()


def _AddHeldHands(builder: DiagramBuilder, robot: RobotModel) -> OutputPort:
    """Keeps the fingers at the positions in the robot's description."""
    description, held = robot.description, []
    for hand in description.effector_hands.values():
        fingers = [description.locked.get(joint, 0.0) for joint in hand.joints]
        held += [math.fsum(fingers), _GRIP_FORCE]
    return builder.AddNamedSystem(
        "hand_command", ConstantVectorSource(held)
    ).get_output_port()
