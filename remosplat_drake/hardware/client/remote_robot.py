"""`RemoteRobot`: the system with a station's ports, for a robot on LCM."""

import dataclasses as dc

import numpy as np
from pydrake.common.value import Value
from pydrake.systems.framework import (
    BasicVector,
    Context,
    LeafSystem,
    State,
)

from remosplat_drake.hardware.client.measurement import Measurement
from remosplat_drake.hardware.client.robot_link import RobotLink
from remosplat_drake.hardware.client.status_monitor import station_status
from remosplat_drake.hardware.hardware_config import HardwareConfig
from remosplat_drake.hardware.wire.base import base_axes
from remosplat_drake.hardware.wire.hand import check_hands
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.signals import station_ports as ports
from remosplat_drake.signals.station_status import (
    RUNNING,
    STOPPED,
    StationStatus,
)
from remosplat_drake.station.commands import CommandInputs


class RemoteRobot(LeafSystem):
    """A robot whose drivers are other processes on an LCM network.

    .. pydrake_system::

        name: RemoteRobot
        input_ports:
        - base.velocity_commanded
        - panda.velocity_commanded
        - hand.command
        output_ports:
        - base.pose_measured
        - base.velocity_measured
        - panda.position_measured
        - panda.velocity_measured
        - hand.state
        - status

    The context's time is the wall clock, in seconds of the Unix epoch. The
    system has no events of its own: `receive` and initialization store the
    packets of the link in the state, and a forced publish sends the commands.
    If the control loop stops, no commands are sent, and the drivers' watchdogs
    stop the robot.

    The ports have the names of `signals.station_ports`. A robot on a fixed base
    has no `base` ports, and a robot without a gripper has no `hand` ports.
    `base.pose_measured` is the odometry, extrapolated to the context's time.
    Before the first status of a part, its outputs are NaN. The outputs of a
    hand are also NaN if its latest status is stale. A command that is not
    finite is replaced by zeros. A command beyond the base's limits is scaled to
    these limits. In both cases, `status` contains the reason.
    """

    def __init__(
        self, *, robot: RobotModel, link: RobotLink, config: HardwareConfig
    ):
        """Declares state and ports.

        Args:
            robot: The robot; its description names the ports.
            link: The LCM connection to its drivers.
            config: The expiry times and the channels' names.

        Raises:
            FieldError: The robot has several hands.
        """
        check_hands(robot.description)
        super().__init__()
        self._robot = robot
        self._link = link
        self._config = config
        self._axes = base_axes(robot.n_base)
        self._commands = CommandInputs(self, robot)
        self._cell = self.DeclareAbstractState(Value(Measurement()))
        self.DeclareInitializationUnrestrictedUpdateEvent(self._initialize)
        self.DeclareForcedPublishEvent(self._send)
        self._declare_outputs()

    def _declare_outputs(self) -> None:
        description = self._robot.description
        n_arm = len(description.arm.joints)
        state = {self.abstract_state_ticket(self._cell)}
        now = {*state, self.time_ticket()}
        outputs = [
            (ports.arm_position(description), n_arm, self._calc_arm, state),
            (ports.arm_velocity(description), n_arm, self._calc_rates, state),
        ]
        if description.base:
            outputs += [
                (ports.BASE_POSE, 3, self._calc_base, now),
                (
                    ports.BASE_VELOCITY,
                    len(self._axes),
                    self._calc_base_velocity,
                    state,
                ),
            ]
        if description.hand:
            name = ports.hand_state(description.hand)
            outputs.append((name, 3, self._calc_hand, now))
        for name, size, calc, prerequisites in outputs:
            self.DeclareVectorOutputPort(name, size, calc, prerequisites)
        self.DeclareAbstractOutputPort(
            ports.STATUS,
            lambda: Value(StationStatus()),
            self._calc_status,
            {*now, self._commands.ticket},
        )

    def measurement(self, context: Context) -> Measurement:
        """Returns the measurement that the ports output.

        Args:
            context: The system's own context.
        """
        return context.get_abstract_state(int(self._cell)).get_value()

    def receive(self, context: Context) -> None:
        """Stores the packets that the link has received in the state.

        It is called between two steps of the diagram. It is no event of the
        diagram, since Drake would then copy the state of the whole diagram at
        every step.

        Args:
            context: The system's own context.
        """
        value = context.get_mutable_abstract_state(int(self._cell))
        value.set_value(self._link.updated(value.get_value()))

    def _initialize(self, context: Context, state: State) -> None:
        measurement = self._link.updated(self.measurement(context))
        state.get_mutable_abstract_state(int(self._cell)).set_value(measurement)

    def _send(self, context: Context) -> None:
        command = self._commands.read(context)
        self._link.send(command.u)
        for hand in command.hands:
            if hand.width is not None:
                self._link.send_hand(hand.width, hand.force)

    def _calc_arm(self, context: Context, output: BasicVector) -> None:
        arm = self.measurement(context).arm
        output.SetFromVector(arm.q if arm else _unknown(output))

    def _calc_rates(self, context: Context, output: BasicVector) -> None:
        arm = self.measurement(context).arm
        output.SetFromVector(arm.v if arm else _unknown(output))

    def _calc_base(self, context: Context, output: BasicVector) -> None:
        output.SetFromVector(
            self.measurement(context).base_pose(
                context.get_time(), self._config.base_status_expiry
            )
        )

    def _calc_base_velocity(
        self, context: Context, output: BasicVector
    ) -> None:
        base = self.measurement(context).base
        output.SetFromVector(
            base.velocity[self._axes] if base else _unknown(output)
        )

    def _calc_hand(self, context: Context, output: BasicVector) -> None:
        reading = self.measurement(context).hand_reading(
            context.get_time(), self._config.hand_status_expiry
        )
        output.SetFromVector(reading)

    def _calc_status(self, context: Context, output: Value) -> None:
        command = self._commands.read(context)
        status = station_status(
            self.measurement(context),
            self._config,
            self._robot.n_base > 0,
            context.get_time(),
        )
        if status.mode == RUNNING and command.status.mode != RUNNING:
            status = command.status
        problem = self._link.command_problem(command.u)
        if status.mode == RUNNING and problem:
            status = dc.replace(status, mode=STOPPED, stop_reason=problem)
        output.set_value(status)


def _unknown(output: BasicVector) -> np.ndarray:
    return np.full(output.size(), np.nan)
