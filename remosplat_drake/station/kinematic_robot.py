"""`KinematicRobot`: integrates commanded velocities; no mass, no contact."""

from collections.abc import Sequence

import numpy as np
from pydrake.common.value import Value
from pydrake.systems.framework import (
    BasicVector,
    Context,
    ContinuousState,
    LeafSystem,
)

from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.signals import station_ports as ports
from remosplat_drake.signals.station_status import StationStatus
from remosplat_drake.station.commands import CommandInputs, StationCommand
from remosplat_drake.station.hand import HandGeometry, width_rate


class KinematicRobot(LeafSystem):
    """A robot that moves exactly at its commanded velocities.

    .. pydrake_system::

        name: KinematicRobot
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
        - posture

    The state (q, width) is *continuous*: a command that the controller
    decided at a tick acts from that very instant, so the state reached at
    the next tick is `robot.advance(q, u, period)`, which is the one that the
    controller verified. A discrete update would act one tick late.

    Names are those of `signals.station_ports`; a fixed robot has no `base`
    ports, one without a gripper no `hand` ports. `posture` (q, then the
    finger positions) is for drawing. A command that is not finite makes the
    robot hold still, and `status` says so. Joint stops are not modelled: the
    controller's limits are.
    """

    def __init__(
        self,
        *,
        robot: RobotModel,
        hand: HandGeometry,
        hand_speed: float,
        q0: np.ndarray,
        odometry_drift: Sequence[float] = (0.0, 0.0, 0.0),
    ):
        """Declares state and ports.

        Args:
            robot: The robot; its description names the ports.
            hand: Geometry of its gripper.
            hand_speed: Speed at which the gripper's width changes [m/s].
            q0: Configuration to start from, shape (n_q,).
            odometry_drift: Velocity with which the measured pose of the base
                leaves the true one [m/s, m/s, rad/s].
        """
        super().__init__()
        self._robot = robot
        self._hand = hand
        self._hand_speed = hand_speed
        self._odometry_drift = np.array(odometry_drift)
        self._commands = CommandInputs(self, robot)
        self.DeclareContinuousState(BasicVector([*q0, hand.start_width]))
        self._declare_outputs()

    def _declare_outputs(self) -> None:
        description = self._robot.description
        state, command = {self.xc_ticket()}, {self._commands.ticket}
        n_arm = len(description.arm.joints)
        outputs = [
            (ports.arm_position(description), n_arm, self._calc_arm, state),
            (
                ports.arm_velocity(description),
                n_arm,
                self._calc_arm_velocity,
                command,
            ),
            (
                "posture",
                self._robot.n_q + len(self._hand.joints),
                self._calc_posture,
                state,
            ),
        ]
        if description.base:
            outputs += [
                (
                    ports.BASE_POSE,
                    3,
                    self._calc_base,
                    state | {self.time_ticket()},
                ),
                (
                    ports.BASE_VELOCITY,
                    description.n_base,
                    self._calc_base_velocity,
                    command,
                ),
            ]
        if description.hand:
            outputs.append(
                (
                    ports.hand_state(description),
                    3,
                    self._calc_hand,
                    state | command,
                )
            )
        for name, size, calc, prerequisites in outputs:
            self.DeclareVectorOutputPort(name, size, calc, prerequisites)
        self.DeclareAbstractOutputPort(
            ports.STATUS,
            lambda: Value(StationStatus()),
            self._calc_status,
            command,
        )

    def DoCalcTimeDerivatives(
        self, context: Context, derivatives: ContinuousState
    ) -> None:
        """Computes q_dot = N(q) u, and the rate of the gripper's width."""
        q, width = self._state(context)
        command = self._commands.read(context)
        rates = np.empty(len(q) + 1)
        rates[:-1] = self._robot.velocity_map(q) @ command.u
        rates[-1] = self._width_rate(width, command)
        derivatives.SetFromVector(rates)

    def _state(self, context: Context) -> tuple[np.ndarray, float]:
        x = context.get_continuous_state_vector().CopyToVector()
        return x[:-1], float(x[-1])

    def _width_rate(self, width: float, command: StationCommand) -> float:
        if command.width is None:
            return 0.0
        return width_rate(width, command.width, self._hand, self._hand_speed)

    def _calc_base(self, context: Context, output: BasicVector) -> None:
        drift = self._odometry_drift * context.get_time()
        output.SetFromVector(self._state(context)[0][:3] + drift)

    def _calc_base_velocity(
        self, context: Context, output: BasicVector
    ) -> None:
        output.SetFromVector(self._commands.read(context).u[: output.size()])

    def _calc_arm(self, context: Context, output: BasicVector) -> None:
        output.SetFromVector(self._state(context)[0][-output.size() :])

    def _calc_arm_velocity(self, context: Context, output: BasicVector) -> None:
        output.SetFromVector(self._commands.read(context).u[-output.size() :])

    def _calc_hand(self, context: Context, output: BasicVector) -> None:
        _, width = self._state(context)
        rate = self._width_rate(width, self._commands.read(context))
        output.SetFromVector([width, rate, 0.0])  # Nothing resists.

    def _calc_posture(self, context: Context, output: BasicVector) -> None:
        q, width = self._state(context)
        fingers = len(self._hand.joints)
        output.SetFromVector([*q, *[width / max(fingers, 1)] * fingers])

    def _calc_status(self, context: Context, output: Value) -> None:
        output.set_value(self._commands.read(context).status)
