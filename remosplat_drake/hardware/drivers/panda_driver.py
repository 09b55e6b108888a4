"""`PandaDriver`: serves `PANDA_COMMAND` with a Franka Panda arm, at 1 kHz.

It keeps drake-franka-driver's rules. Between the wire and the arm stands the
same filter as in libfranka's velocity mode.
"""

from typing import Any, Protocol

import numpy as np
from drake import lcmt_panda_status
from pydrake.lcm import DrakeLcmInterface

from remosplat_drake.hardware.drivers.panda_commands import (
    JOINTS,
    PandaCommands,
)
from remosplat_drake.hardware.drivers.panda_limits import (
    AT_REST,
    JointCommand,
    next_command,
)
from remosplat_drake.hardware.wire.channels import PANDA_COMMAND, PANDA_STATUS
from remosplat_drake.hardware.wire.inbox import CommandSource, Inbox


class FrankaArm(Protocol):
    """What `PandaDriver` needs of an arm: joint rates in, states out."""

    def state(self) -> Any:
        """Returns the latest `RobotState`, with libfranka's attributes."""
        ...

    def set_velocity(self, velocity: np.ndarray) -> None:
        """Makes the joints move at these rates, shape (7,) [rad/s]."""
        ...

    def problem(self) -> str:
        """Says why the arm has stopped by itself; empty while it has not."""
        ...


class PandaDriver:
    """Hears commands, sets joint rates and publishes statuses, at 1 kHz."""

    def __init__(
        self,
        lcm: DrakeLcmInterface,
        arm: FrankaArm,
        inbox: CommandSource | None = None,
    ):
        """Subscribes; nothing moves before a command comes.

        Args:
            lcm: The LCM network.
            arm: The arm under control.
            inbox: Where commands come from; None obeys everybody.
        """
        self._lcm = lcm
        self._arm = arm
        self._inbox = inbox or Inbox(lcm, [PANDA_COMMAND])
        self._commands = PandaCommands()
        self._command: JointCommand = AT_REST

    def step(self, now: int) -> None:
        """Runs one millisecond: hears commands, sets rates, publishes.

        Args:
            now: Wall clock [us].
        """
        for _, data in self._inbox.fetch():
            self._commands.receive(data)
        self._advance(self._commands.velocity(now))
        status = panda_status(self._arm.state(), self._command, now)
        self._lcm.Publish(PANDA_STATUS, status.encode())

    def brake(self) -> bool:
        """Runs one millisecond of a ramp to zero velocity.

        Returns:
            Whether the commanded rates have come to zero.
        """
        self._advance(np.zeros(JOINTS))
        return not np.abs(self._command.velocity).max() > 1e-4

    def _advance(self, target: np.ndarray) -> None:
        self._command = next_command(target, self._command)
        self._arm.set_velocity(self._command.velocity)


def panda_status(
    state: Any, command: JointCommand, now: int
) -> lcmt_panda_status:
    """Makes the status message that drake-franka-driver would make.

    Desired rates and accelerations are the driver's own: an arm under torque
    control knows none.

    Args:
        state: A `RobotState` of libfranka.
        command: The driver's latest command to the joints.
        now: Wall clock [us].
    """
    status = lcmt_panda_status()
    status.utime = now
    status.num_joints = JOINTS
    status.joint_position = list(state.q)
    status.joint_position_desired = list(state.q_d)
    status.joint_velocity = list(state.dq)
    status.joint_velocity_desired = command.velocity.tolist()
    status.joint_acceleration_desired = command.acceleration.tolist()
    status.joint_torque = list(state.tau_J)
    status.joint_torque_desired = list(state.tau_J_d)
    status.joint_torque_external = list(state.tau_ext_hat_filtered)
    status.control_command_success_rate = state.control_command_success_rate
    status.robot_mode = int(state.robot_mode)
    status.robot_utime = round(1000 * state.time.to_msec())
    return status
