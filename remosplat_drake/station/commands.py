"""Declares a station's command ports, and checks the values of commands."""

import dataclasses as dc

import numpy as np
from pydrake.common.value import Value
from pydrake.systems.framework import (
    CacheEntry,
    Context,
    DependencyTicket,
    InputPort,
    LeafSystem,
    ValueProducer,
)

from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.signals import station_ports as ports
from remosplat_drake.signals.station_status import (
    RUNNING,
    STOPPED,
    StationStatus,
)


@dc.dataclass(frozen=True)
class HandCommand:
    """A command to a gripper.

    Attributes:
        width: Commanded opening [m]; None keeps the present opening.
        force: Bound on the gripping force [N].
    """

    width: float | None = None
    force: float = 0.0


@dc.dataclass(frozen=True, eq=False)
class StationCommand:
    """A checked command to a station; copying returns the object itself.

    Attributes:
        u: Base and arm velocities, shape (n_u,) [m/s, rad/s]; zero if the robot
            is stopped.
        hands: The command to each hand.
        status: Status of the station: stopped, with the reason, if a command
            was not finite.
    """

    u: np.ndarray
    hands: tuple[HandCommand, ...]
    status: StationStatus

    def __deepcopy__(self, memo) -> "StationCommand":
        return self


def checked_command(
    values: dict[str, np.ndarray], robot: RobotModel
) -> StationCommand:
    """Converts the values of the command ports to a command without NaN.

    A number that is not finite stops the whole robot, since the other numbers
    of the command may be wrong, too.

    Args:
        values: Values of the input ports, keyed by name. For a missing port,
            the command is zero, or a hand's present width.
        robot: The robot; its description names the ports.
    """
    broken = [
        name for name, value in values.items() if not np.isfinite(value).all()
    ]
    description = robot.description
    grippers = description.effector_hands.values()
    if broken:
        reason = ", ".join(broken) + ": the command is not finite"
        status = StationStatus(mode=STOPPED, stop_reason=reason)
        held = (HandCommand(),) * len(grippers)
        return StationCommand(np.zeros(robot.n_u), held, status)
    u = values[ports.arm_command(description)]
    if description.base:
        u = np.concatenate([values[ports.BASE_COMMAND], u])
    hands = (
        HandCommand(*map(float, values.get(ports.hand_command(hand), ())))
        for hand in grippers
    )
    return StationCommand(u, tuple(hands), StationStatus(mode=RUNNING))


class CommandInputs:
    """Command ports of a system; values are checked once for all outputs.

    If the port of a hand is not connected, the gripper keeps its width.
    """

    def __init__(self, system: LeafSystem, robot: RobotModel):
        """Declares the command ports on a system.

        Args:
            system: The system that gets the ports.
            robot: The robot; its description names the ports.
        """
        self._robot = robot
        self._inputs: list[InputPort] = [
            system.DeclareVectorInputPort(port.name, port.size)
            for port in ports.station_ports(robot.description, False)
            if port.direction == ports.INPUT
        ]
        nothing = StationCommand(np.zeros(0), (), StationStatus())
        self._command: CacheEntry = system.DeclareCacheEntry(
            "command",
            ValueProducer(allocate=Value(nothing).Clone, calc=self._calc),
            {port.ticket() for port in self._inputs},
        )

    @property
    def ticket(self) -> DependencyTicket:
        """Dependency ticket for outputs that depend on the command."""
        return self._command.ticket()

    def read(self, context: Context) -> StationCommand:
        """Returns the present command, after the check.

        Args:
            context: Context of the system with the ports.
        """
        return self._command.Eval(context)

    def _calc(self, context: Context, value: Value) -> None:
        hands = self._robot.description.effector_hands.values()
        optional = set(map(ports.hand_command, hands))
        values = {
            port.get_name(): port.Eval(context)
            for port in self._inputs
            if port.get_name() not in optional or port.HasValue(context)
        }
        value.set_value(checked_command(values, self._robot))
