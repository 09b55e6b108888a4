"""The stand-in robot as a process, and a client of it."""

import contextlib
import math
import os
import subprocess
import time
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

import numpy as np
from drake import (
    lcmt_panda_command,
    lcmt_panda_status,
    lcmt_schunk_wsg_command,
    lcmt_schunk_wsg_status,
)
from patience import PATIENCE
from pydrake.lcm import DrakeLcm
from runs import command_line

from remosplat_drake.base.clock import wall_utime
from remosplat_drake.hardware.client.wire_guard import WireGuard
from remosplat_drake.hardware.hardware_config import HardwareConfig
from remosplat_drake.hardware.stand_in import faults
from remosplat_drake.hardware.wire import channels
from remosplat_drake.hardware.wire.base import base_velocity
from remosplat_drake.hardware.wire.inbox import Inbox
from remosplat_drake.hardware.wire.messages.base_command import base_command
from remosplat_drake.hardware.wire.messages.base_status import base_status

TYPES = {
    channels.PANDA_STATUS: lcmt_panda_status,
    channels.BASE_STATUS: base_status,
    channels.PANDA_HAND_STATUS: lcmt_schunk_wsg_status,
}

COMMAND_PERIOD = 10_000  # [us]


def free_address() -> str:
    """An address of this computer for a controller, which no other has."""
    pid = os.getpid()
    return f"127.1.{pid // 250 % 250 + 1}.{pid % 250 + 1}"


@contextlib.contextmanager
def running(
    *arguments: str,
    environment: dict[str, str] | None = None,
    folder: Path | None = None,
) -> Iterator[subprocess.Popen[str]]:
    """A command of `remosplat` as a process; ended by SIGTERM."""
    with subprocess.Popen(
        command_line(*arguments),
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env=environment,
        cwd=folder,
    ) as process:
        try:
            yield process
        finally:
            process.terminate()


def robot_process(
    url: str, *arguments: str
) -> contextlib.AbstractContextManager[subprocess.Popen[str]]:
    """`remosplat hardware-sim` on a wire."""
    return running("hardware-sim", "--lcm-url", url, *arguments)


class Client:
    """Keeps all statuses, in order, and sends commands."""

    def __init__(
        self, wire: str | DrakeLcm, clock: Callable[[], int] = wall_utime
    ):
        """Starts to listen.

        Args:
            wire: A URL, or the other end itself, which then waits for no other.
            clock: What stamps the commands [us].
        """
        self._lcm = DrakeLcm(wire) if isinstance(wire, str) else wire
        self._clock = clock
        self._inbox = Inbox(self._lcm, list(TYPES))
        self._guard = None
        if isinstance(wire, str):
            config = HardwareConfig(lcm_url=wire)
            self._guard = WireGuard(self._lcm, config, "a test")
        self.arm: list[lcmt_panda_status] = []
        self.base: list[base_status] = []
        self.hand: list[lcmt_schunk_wsg_status] = []
        self.latest = lcmt_panda_status()
        self.latest_base = base_status()

    @property
    def time(self) -> float:
        """The robot's own clock, as the arm's latest status has it [s]."""
        return 1e-6 * self.latest.robot_utime

    def listen(self, timeout: float = 0.001) -> None:
        """Takes what has come, or waits for it [s]."""
        if self._guard is not None:
            self._guard.listen()
        for channel, data in self._inbox.fetch(timeout):
            message = TYPES[channel].decode(data)
            if channel == channels.PANDA_STATUS:
                self.latest = message
                self.arm.append(message)
            elif channel == channels.BASE_STATUS:
                self.latest_base = message
                self.base.append(message)
            else:
                self.hand.append(message)

    def wait_for(self, done: Callable[[], bool]) -> None:
        """Listens until something is so."""
        end = time.monotonic() + PATIENCE
        while not done():
            assert time.monotonic() < end, "the robot does not do it"
            self.listen()

    def wait_for_robot(self) -> None:
        """Listens until arm, base and hand have all been heard."""
        self.wait_for(lambda: all((self.arm, self.base, self.hand)))

    def catch_up(self) -> None:
        """Listens until the arm's latest status is a present one."""
        self.listen(0.0)  # Drake keeps the oldest packets until they are read.
        heard = len(self.arm)
        self.wait_for(lambda: len(self.arm) > heard)

    def listen_for(self, duration: float) -> None:
        """Listens from now on, for some time of the robot's clock [s]."""
        self.catch_up()
        end = self.time + duration
        self.wait_for(lambda: self.time >= end)

    def drive(
        self,
        until: Callable[[], bool],
        arm: np.ndarray | None = None,
        base: Sequence[float] | None = None,
    ) -> None:
        """Repeats a command at 100 Hz, freshly stamped, until something is so.

        Args:
            until: What ends it.
            arm: Joint rates, shape (7,); None sends none.
            base: Forward speed, that to the left where there is one, and yaw
                rate; None sends none.
        """
        due = -math.inf
        self.take_command()

        def done() -> bool:
            nonlocal due
            if until():
                return True
            now = self._clock()
            if now >= due:
                due = now + COMMAND_PERIOD
                if arm is not None:
                    self.send_arm(arm)
                if base is not None:
                    self.send_base(base)
            return False

        self.wait_for(done)

    def take_command(self) -> None:
        """Takes the lease: without one, drivers follow no command."""
        if self._guard is not None:
            self._guard.take_command(0.0)

    def send_arm(self, velocity: np.ndarray, age: float = 0.0) -> None:
        """Sends one command, stamped `age` seconds ago."""
        self.take_command()
        message = lcmt_panda_command()
        message.utime = self._clock() - round(1e6 * age)
        message.num_joint_velocity = len(velocity)
        message.joint_velocity = [float(x) for x in velocity]
        message.control_mode_expected = 2
        self._lcm.Publish(channels.PANDA_COMMAND, message.encode())

    def send_base(self, u: Sequence[float], age: float = 0.0) -> None:
        """Sends one command, stamped `age` seconds ago."""
        self.take_command()
        message = base_command()
        message.utime = self._clock() - round(1e6 * age)
        message.forward, message.left, message.yaw_rate = base_velocity(
            np.array(u)
        )
        self._lcm.Publish(channels.BASE_COMMAND, message.encode())

    def send_hand(self, width: float, force: float) -> None:
        """Sends one command [m, N]."""
        self.take_command()
        message = lcmt_schunk_wsg_command()
        message.utime = self._clock()
        message.target_position_mm, message.force = 1e3 * width, force
        self._lcm.Publish(channels.PANDA_HAND_COMMAND, message.encode())

    def inject(self, name: str, value: float = 0.0) -> None:
        """Makes something go wrong now; `recover` ends it."""
        self._lcm.Publish(faults.CHANNEL, faults.encode_request(name, value))

    def arm_velocities(self) -> np.ndarray:
        """Measured joint rates of all statuses, shape (n, 7) [rad/s]."""
        return np.array([status.joint_velocity for status in self.arm])
