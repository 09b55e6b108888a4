"""`KinematicRobot`: integrates commanded velocities, without dynamics."""

from collections.abc import Sequence
from functools import partial

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
from remosplat_drake.station.commands import CommandInputs, HandCommand
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

    The state consists of q and the width of each gripper. It is *continuous*,
    so a command acts from the tick at which the controller computed it. The
    state at the next tick is then `robot.advance(q, u, period)`, which the
    controller has verified. With a discrete state, commands would act one tick
    too late.

    The ports have the names of `signals.station_ports`. A robot on a fixed base
    has no `base` ports, and each gripper has its own `hand` ports. The output
    `posture`, q followed by the finger positions, is used to draw the robot. If
    a command is not finite, the robot does not move, and `status` contains the
    reason. Joint stops are not modelled, since the controller keeps the joint
    limits.
    """

    def __init__(
        self,
        *,
        robot: RobotModel,
        hands: Sequence[HandGeometry],
        hand_speed: float,
        q0: np.ndarray,
        odometry_drift: Sequence[float] = (0.0, 0.0, 0.0),
    ):
        """Declares state and ports.

        Args:
            robot: The robot; its description names the ports.
            hands: Geometry of the robot's grippers.
            hand_speed: Speed at which a gripper's width changes [m/s].
            q0: Configuration at the start, shape (n_q,).
            odometry_drift: Rate at which the measured pose of the base drifts
                away from the true pose [m/s, m/s, rad/s].
        """
        super().__init__()
        self._robot = robot
        self._hands = tuple(hands)
        self._hand_speed = hand_speed
        self._odometry_drift = np.array(odometry_drift)
        self._commands = CommandInputs(self, robot)
        widths = [hand.start_width for hand in hands]
        self.DeclareContinuousState(BasicVector([*q0, *widths]))
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
                self._robot.n_q + sum(len(x.joints) for x in self._hands),
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
        for i, hand in enumerate(self._hands):
            name, calc = (
                ports.hand_state(hand.hand),
                partial(self._calc_hand, i),
            )
            outputs.append((name, 3, calc, state | command))
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
        """Computes q_dot = N(q) u, and the rates of the grippers' widths."""
        q, widths = self._state(context)
        command = self._commands.read(context)
        rates = map(self._width_rate, self._hands, command.hands, widths)
        q_dot = self._robot.velocity_map(q) @ command.u
        derivatives.SetFromVector([*q_dot, *rates])

    def _state(self, context: Context) -> tuple[np.ndarray, np.ndarray]:
        x = context.get_continuous_state_vector().CopyToVector()
        return x[: self._robot.n_q], x[self._robot.n_q :]

    def _width_rate(
        self, hand: HandGeometry, command: HandCommand, width: float
    ) -> float:
        if command.width is None:
            return 0.0
        return width_rate(width, command.width, hand, self._hand_speed)

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

    def _calc_hand(self, i: int, context: Context, output: BasicVector) -> None:
        width = float(self._state(context)[1][i])
        command = self._commands.read(context).hands[i]
        rate = self._width_rate(self._hands[i], command, width)
        output.SetFromVector([width, rate, 0.0])  # Nothing resists.

    def _calc_posture(self, context: Context, output: BasicVector) -> None:
        q, widths = self._state(context)
        counts = [len(hand.joints) for hand in self._hands]
        output.SetFromVector([*q, *np.repeat(widths / counts, counts)])

    def _calc_status(self, context: Context, output: Value) -> None:
        output.set_value(self._commands.read(context).status)
