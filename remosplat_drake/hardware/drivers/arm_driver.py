"""`ArmDriver`: executes LCM commands on an arm that accepts joint rates.

The channels (`PANDA_COMMAND`, `PANDA_STATUS`), the messages and the rules for
commands are those of drake-franka-driver. Its messages can represent arms with
any number of joints.
"""

import dataclasses as dc
import math
from typing import Protocol

import numpy as np
from drake import lcmt_panda_status
from pydrake.lcm import DrakeLcmInterface

from remosplat_drake.hardware.drivers.panda_commands import ArmCommands
from remosplat_drake.hardware.wire.channels import (
    COMMAND_RAMP,
    PANDA_COMMAND,
    PANDA_STATUS,
)
from remosplat_drake.hardware.wire.inbox import CommandSource, Inbox

AT_REST = 1e-3
"""Speed below which a joint counts as at rest [rad/s]."""

COMMAND_PERIOD = 0.008
"""Shortest time between two commands to an arm [s]. A Universal Robots
controller takes some milliseconds for each command."""


@dc.dataclass(frozen=True, eq=False)
class ArmReport:
    """A status of an arm of n joints.

    Attributes:
        q: Joint positions, shape (n,) [rad].
        v: Joint rates, shape (n,) [rad/s].
        time: The arm's own clock [s].
        mode: A value of lcmt_panda_status.robot_mode.
        problem: Reason why the arm no longer follows commands; empty if it
            does.
        utime: Time of the measurement, by the wall clock [us]. If the arm does
            not send it, this is None, and the time of arrival is used.
    """

    q: np.ndarray
    v: np.ndarray
    time: float
    mode: int = lcmt_panda_status.kMove
    problem: str = ""
    utime: int | None = None


class ArmLink(Protocol):
    """Protocol of an arm that `ArmDriver` drives."""

    def command(self, velocity: np.ndarray) -> None:
        """Sends joint rates to the arm, shape (n,) [rad/s]."""
        ...

    def fetch(self) -> ArmReport | None:
        """Returns the latest report; None if there is no new one."""
        ...

    def close(self) -> None:
        """Disconnects from the arm, which must be at rest."""
        ...


class ArmDriver:
    """Sends commands from LCM to an arm, and publishes the arm's statuses."""

    def __init__(
        self,
        lcm: DrakeLcmInterface,
        link: ArmLink,
        joints: int,
        inbox: CommandSource | None = None,
    ):
        """Subscribes to commands; sends nothing before the first command.

        Args:
            lcm: The LCM network.
            link: The arm.
            joints: Number of the arm's joints.
            inbox: Source of commands. If it is None, commands of all senders
                are accepted.
        """
        self._lcm, self._link = lcm, link
        self._inbox = inbox or Inbox(lcm, [COMMAND_RAMP, PANDA_COMMAND])
        self._commands = ArmCommands(joints)
        self._joints = joints
        self._commanded = -math.inf

    def step(self, now: int, t: float) -> ArmReport | None:
        """Runs a period: receives commands, sends a command and a status.

        The arm receives a setpoint every `COMMAND_PERIOD`, even if there is no
        new command.

        Args:
            now: Wall clock [us].
            t: Time now, by a monotonic clock [s].

        Returns:
            The arm's report, if it is new.
        """
        for channel, data in self._inbox.fetch():
            self._commands.hear(channel, data)
        is_due = t - self._commanded >= COMMAND_PERIOD
        if self._commands.received and is_due:
            self._commanded = t
            self._link.command(self._commands.velocity(now))
        return self._tell(now)

    def brake(self, now: int) -> bool:
        """Commands zero rates; returns whether the arm is at rest."""
        self._link.command(np.zeros(self._joints))
        report = self._tell(now)
        return report is not None and bool(np.abs(report.v).max() < AT_REST)

    def _tell(self, now: int) -> ArmReport | None:
        report = self._link.fetch()
        if report is not None:
            status = arm_status(report, now)
            self._lcm.Publish(PANDA_STATUS, status.encode())
        return report


def arm_status(report: ArmReport, now: int) -> lcmt_panda_status:
    """Makes the status message of a report.

    Args:
        report: The arm's report.
        now: Present wall clock time [us], which is the stamp if the report
            contains no time.
    """
    status, zeros = lcmt_panda_status(), [0.0] * len(report.q)
    status.utime = now if report.utime is None else report.utime
    status.num_joints = len(report.q)
    status.joint_position = status.joint_position_desired = report.q.tolist()
    status.joint_velocity = status.joint_velocity_desired = report.v.tolist()
    status.joint_acceleration_desired = zeros
    status.joint_torque = status.joint_torque_desired = zeros
    status.joint_torque_external = zeros
    status.control_command_success_rate = float(not report.problem)
    status.robot_mode = report.mode
    status.robot_utime = round(1e6 * report.time)
    return status
