"""A base that speaks ROS, as the tests of both bridges see it."""

import subprocess
import time
from collections.abc import Callable

import pytest
from patience import PATIENCE
from pydrake.lcm import DrakeLcm

from remosplat_drake.base.clock import wall_utime
from remosplat_drake.hardware.client.wire_guard import WireGuard
from remosplat_drake.hardware.hardware_config import HardwareConfig
from remosplat_drake.hardware.wire.channels import (
    BASE_COMMAND,
    BASE_LOCALIZATION,
    BASE_STATUS,
)
from remosplat_drake.hardware.wire.inbox import Inbox
from remosplat_drake.hardware.wire.localization import decode_localization
from remosplat_drake.hardware.wire.messages.base_command import base_command
from remosplat_drake.hardware.wire.messages.base_status import base_status

SILENCE = 0.3
"""Thirty times the period at which a bridge sends [s]."""


class Station:
    """The station's end of the wire."""

    def __init__(self, url: str):
        self._lcm = DrakeLcm(url)
        self._inbox = Inbox(self._lcm, [BASE_STATUS])
        self._guard = WireGuard(
            self._lcm, HardwareConfig(lcm_url=url), "a test"
        )

    def send(self, forward: float, yaw_rate: float) -> None:
        """Sends one command, freshly stamped, with the lease."""
        self._guard.listen()
        self._guard.take_command(0.0)
        message = base_command()
        message.utime = wall_utime()
        message.forward, message.yaw_rate = forward, yaw_rate
        self._lcm.Publish(BASE_COMMAND, message.encode())

    def statuses(self) -> list[base_status]:
        """What has come since the last call."""
        return [base_status.decode(data) for _, data in self._inbox.fetch()]


def check_bridge(
    bridge: subprocess.Popen[str],
    station: Station,
    commands: list[tuple[float, float]],
    send_odometry: Callable[[float, float], None],
) -> None:
    """Drives a base through a bridge: there, back, and its watchdog.

    Args:
        bridge: The bridge's process.
        station: The other end.
        commands: Grows by what arrives at the base (forward, yaw rate).
        send_odometry: Sends a pose x and a speed as the base would.
    """
    statuses: list[base_status] = []

    def exchange(done: Callable[[], bool], command=None) -> None:
        end = time.monotonic() + PATIENCE
        while not done():
            assert bridge.poll() is None, "the bridge ended"
            assert time.monotonic() < end, "the bridge did not do it in time"
            if command is not None:
                station.send(*command)
            send_odometry(1.5, 0.3)
            statuses.extend(station.statuses())
            time.sleep(0.01)

    exchange(lambda: len(statuses) > 5)
    assert statuses[-1].pose[0] == 1.5
    assert statuses[-1].forward == 0.3
    assert not commands, "a bridge that hears nothing says nothing"

    exchange(lambda: len(commands) > 5, (0.4, -0.2))
    assert commands[-1] == pytest.approx((0.4, -0.2))
    exchange(lambda: commands[-1] == pytest.approx((1.0, 0.4)), (2.0, 0.8))
    # The station falls silent: zeros, and then silence.
    exchange(lambda: commands[-1] == (0.0, 0.0))
    since, heard = time.monotonic(), len(commands)

    def is_silent() -> bool:
        nonlocal since, heard
        if len(commands) > heard:
            since, heard = time.monotonic(), len(commands)
        return time.monotonic() - since > SILENCE

    exchange(is_silent)
    commands.clear()


SENSES = """emergency_stop: /e_stop, stop_expiry: 5,
localization: /amcl_pose, transform: [map, odom]"""
"""Fields of a base that tells more than odometry."""


def bridge_to(kind: str, url: str, fields: str = "") -> list[str]:
    """The command line of a bridge to Frankie's base.

    Args:
        kind: Name of the base's driver.
        url: LCM URL of the other end.
        fields: Fields of the driver besides its topics.
    """
    topics = "commands: /frankie/cmd_vel, odometry: /frankie/odom"
    driver = f"!{kind} {{{topics}, {fields}}}"
    bounds = "base_forward_upper: 1.0, base_forward_lower: -0.25"
    text = f"{{hardware: {{{bounds}, base_driver: {driver}}}}}"
    line = ["base-driver", "TableReach", "--scenario-text", text]
    return [*line, "--lcm-url", url]


def check_senses(
    bridge: subprocess.Popen[str],
    url: str,
    tell: Callable[[bool | None], None],
) -> None:
    """Presses and releases an emergency stop, and looks for localisations.

    Args:
        bridge: The bridge's process, with the arguments `SENSES`.
        url: The other end.
        tell: Lets the base tell its odometry, a pose in "map" and a transform
            to "odom", and whether its emergency stop is pressed; None: it
            says nothing about that.
    """
    inbox = Inbox(DrakeLcm(url), [BASE_STATUS, BASE_LOCALIZATION])
    heard: list[tuple[int, int]] = []
    children: set[str] = set()

    def exchange(pressed: bool | None, done: Callable[[], bool]) -> None:
        end = time.monotonic() + PATIENCE
        heard.clear()
        while not done():
            assert bridge.poll() is None, "the bridge ended"
            assert time.monotonic() < end, "the bridge did not tell it in time"
            tell(pressed)
            for channel, data in inbox.fetch(0.01):
                if channel == BASE_STATUS:
                    status = base_status.decode(data)
                    heard.append((status.mode, status.emergency_stop))
                else:
                    fix = decode_localization(data)
                    assert fix.frame == "map"
                    children.add(fix.child_frame)

    fault, moving = (base_status.FAULT, 0), (base_status.MOVING, 0)
    # Whether it is pressed is not known yet.
    exchange(None, lambda: fault in heard)
    exchange(False, lambda: moving in heard)
    exchange(True, lambda: (base_status.STOPPED, 1) in heard)
    exchange(False, lambda: moving in heard)
    exchange(False, lambda: children == {"base_link", "odom"})
