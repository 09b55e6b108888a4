"""A process that disturbs the LCM network of a robot.

    python -m remosplat_drake.acceptance.stranger URL WHAT

Like other programs that use LCM, it has no lease (the exclusive right to
command the robot), and requests none.
"""

import argparse
import time

import numpy as np
from drake import lcmt_panda_status
from pydrake.lcm import DrakeLcm

from remosplat_drake.base.clock import wall_utime
from remosplat_drake.hardware.stand_in import faults
from remosplat_drake.hardware.wire import channels
from remosplat_drake.hardware.wire.base import encode_base_command
from remosplat_drake.hardware.wire.inbox import Inbox
from remosplat_drake.hardware.wire.lease import (
    DRIVER_REPORT,
    OPERATOR_REQUEST,
    SESSION_LEASE,
)
from remosplat_drake.hardware.wire.messages.base_status import base_status
from remosplat_drake.hardware.wire.panda import encode_panda_command

COMMANDS, ARM, BASE, GARBAGE = (
    "commands",
    "arm-status",
    "base-status",
    "garbage",
)

STRANGERS = {
    COMMANDS: "drives the base and turns joint 1, a hundred times a second",
    ARM: "repeats the arm's statuses with joint 1 off by 0.6 rad",
    BASE: "repeats the base's statuses 0.3 m away",
    GARBAGE: "sends invalid bytes on every channel",
}
"""Descriptions of the disturbances, keyed by name."""

CHANNELS = (
    channels.COMMAND_RAMP,
    channels.PANDA_COMMAND,
    channels.PANDA_STATUS,
    channels.PANDA_HAND_COMMAND,
    channels.PANDA_HAND_STATUS,
    channels.BASE_COMMAND,
    channels.BASE_STATUS,
    channels.WRIST_CAMERA,
    SESSION_LEASE,
    DRIVER_REPORT,
    OPERATOR_REQUEST,
    faults.CHANNEL,
)
"""All LCM channels of a robot."""

_PERIOD = 0.01

_OFF = 0.6
_AWAY = 0.3

_SPEED = 0.2
"""Speed of base and joint 1 in the commands of this process [m/s, rad/s]."""


def command(lcm: DrakeLcm) -> None:
    """Sends one command to arm and base."""
    now = time.time()
    rates = np.array([_SPEED, *np.zeros(6)])
    lcm.Publish(channels.PANDA_COMMAND, encode_panda_command(rates, now))
    forward = np.array([_SPEED, 0.0, 0.0])
    lcm.Publish(channels.BASE_COMMAND, encode_base_command(forward, now))


def arm_status(status: lcmt_panda_status) -> bytes:
    """Copies a status, with the present time and a wrong joint 1."""
    status.utime = status.robot_utime = wall_utime()
    q = list(status.joint_position)
    status.joint_position = [q[0] + _OFF, *q[1:]]
    return status.encode()


def shifted(status: base_status) -> bytes:
    """Copies a status, with the present time and a wrong pose."""
    status.utime = wall_utime()
    status.pose = [status.pose[0] + _AWAY, *status.pose[1:]]
    return status.encode()


def garbage(lcm: DrakeLcm, rng: np.random.Generator) -> None:
    """Sends 0 to 200 random bytes on every channel."""
    for channel in CHANNELS:
        size = int(rng.choice([0, 7, 8, 40, 200]))
        lcm.Publish(channel, rng.bytes(size))


def _first(lcm: DrakeLcm, channel: str) -> bytes:
    """Returns the first message on a channel, for repetition."""
    inbox = Inbox(lcm, [channel])
    while True:
        for _, data in inbox.fetch(0.1):
            return data


def main() -> None:
    """Disturbs the LCM network until a signal ends the process."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("url")
    parser.add_argument("what", choices=STRANGERS)
    arguments = parser.parse_args()
    lcm, rng = DrakeLcm(arguments.url), np.random.default_rng(0)
    heard = b""
    if arguments.what == ARM:
        heard = _first(DrakeLcm(arguments.url), channels.PANDA_STATUS)
    elif arguments.what == BASE:
        heard = _first(DrakeLcm(arguments.url), channels.BASE_STATUS)
    while True:
        if arguments.what == COMMANDS:
            command(lcm)
        elif arguments.what == ARM:
            status = arm_status(lcmt_panda_status.decode(heard))
            lcm.Publish(channels.PANDA_STATUS, status)
        elif arguments.what == BASE:
            status = shifted(base_status.decode(heard))
            lcm.Publish(channels.BASE_STATUS, status)
        else:
            garbage(lcm, rng)
        time.sleep(_PERIOD)


if __name__ == "__main__":
    main()
