"""`PandaDriver`: executes LCM commands on a Franka Panda arm.

Its rules for commands are those of `panda_commands`. A `CallbackProcess`, in
another process, controls the arm.
"""

from collections.abc import Sequence
from typing import Protocol

import numpy as np
from pydrake.lcm import DrakeLcmInterface

from remosplat_drake.hardware.drivers.arm_record import panda_status
from remosplat_drake.hardware.drivers.panda_commands import (
    JOINTS,
    ArmCommands,
)
from remosplat_drake.hardware.drivers.velocity_servo import AT_REST_BELOW
from remosplat_drake.hardware.wire.channels import (
    COMMAND_RAMP,
    PANDA_COMMAND,
    PANDA_STATUS,
)
from remosplat_drake.hardware.wire.inbox import CommandSource, Inbox


class ControlledArm(Protocol):
    """Protocol of an arm that `PandaDriver` drives."""

    def command(self, velocity: Sequence[float], end: bool = False) -> None:
        """Sends joint rates, seven [rad/s], or ends the motion."""
        ...

    def fresh_record(self) -> tuple[float, ...] | None:
        """Returns the latest `arm_record`; None if there is no new one."""
        ...


class PandaDriver:
    """Sends commands from LCM to the arm, and publishes the arm's statuses."""

    def __init__(
        self,
        lcm: DrakeLcmInterface,
        arm: ControlledArm,
        inbox: CommandSource | None = None,
    ):
        """Subscribes to commands; the arm stays at rest before the first one.

        Args:
            lcm: The LCM network.
            arm: The arm that the driver controls.
            inbox: Source of commands. If it is None, commands of all senders
                are accepted.
        """
        self._lcm = lcm
        self._arm = arm
        self._inbox = inbox or Inbox(lcm, [COMMAND_RAMP, PANDA_COMMAND])
        self._commands = ArmCommands()

    def step(self, now: int) -> None:
        """Runs a period: receives commands, sends a command and a status.

        Args:
            now: Wall clock [us].
        """
        for channel, data in self._inbox.fetch():
            self._commands.hear(channel, data)
        self._arm.command(self._commands.velocity(now).tolist())
        self._tell()

    def brake(self) -> bool:
        """Commands zero velocity, and then ends the arm's motion.

        Returns:
            Whether the arm's command is already zero.
        """
        self._arm.command([0.0] * JOINTS, end=True)
        status = self._tell()
        rates = np.abs(status.joint_velocity_desired) if status else np.inf
        return bool(np.max(rates) < AT_REST_BELOW)

    def _tell(self):
        record = self._arm.fresh_record()
        if record is None:
            return None
        status = panda_status(record)
        self._lcm.Publish(PANDA_STATUS, status.encode())
        return status
