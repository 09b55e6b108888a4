"""`HardwareConfig`: where the robot's drivers are, and what they may do."""

import dataclasses as dc
import ipaddress
import re
from collections.abc import Iterator
from typing import Annotated

from annotated_types import Interval, Len

from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.base.ranges import Config
from remosplat_drake.hardware.wire import channels as wire

ChannelName = Annotated[str, Len(1, 63)]
"""LCM takes no longer names."""


@dc.dataclass
class ChannelNames(Config):
    """The LCM channels of one robot."""

    arm_command: ChannelName = wire.PANDA_COMMAND
    arm_status: ChannelName = wire.PANDA_STATUS
    hand_command: ChannelName = wire.PANDA_HAND_COMMAND
    hand_status: ChannelName = wire.PANDA_HAND_STATUS
    base_command: ChannelName = wire.BASE_COMMAND
    base_status: ChannelName = wire.BASE_STATUS
    wrist_camera: ChannelName = wire.WRIST_CAMERA

    def check(self) -> Iterator[tuple[str, str]]:
        """See `Config`."""
        names = dc.asdict(self)
        for field, name in names.items():
            if list(names.values()).count(name) > 1:
                yield field, f"must be a name of its own, got {name!r}"


@dc.dataclass
class HardwareConfig(Config):
    """The real robot, behind LCM."""

    # Where the messages are: ttl=1 reaches the local network, ttl=0 this
    # machine only.
    lcm_url: str = "udpm://239.255.76.67:7667?ttl=1"
    channels: ChannelNames = dc.field(default_factory=ChannelNames)
    # How long to wait for the first status of each driver [s].
    connect_timeout: Annotated[float, Interval(gt=0, le=600)] = 10.0
    # Ages at which a status is stale and the robot is stopped [s].
    arm_status_expiry: Annotated[float, Interval(gt=0, le=1)] = (
        wire.STATUS_EXPIRY
    )
    base_status_expiry: Annotated[float, Interval(gt=0, le=1)] = (
        wire.BASE_STATUS_EXPIRY
    )
    # A status whose content has not changed for so long while the robot
    # should be moving is frozen [s].
    frozen_after: Annotated[float, Interval(gt=0, le=1)] = 0.2
    # Speeds of the base: a command outside is scaled as a whole. Its rear is
    # not watched by safety-rated sensors, so it may only creep backwards
    # [m/s, rad/s].
    base_forward_lower: Annotated[float, Interval(ge=-2, le=0)] = -0.25
    base_forward_upper: Annotated[float, Interval(gt=0, le=2)] = 0.5
    base_yaw_rate: Annotated[float, Interval(gt=0, le=4)] = 0.87
    # Time between two commands to the hand [s].
    hand_period: Annotated[float, Interval(ge=0.01, le=10)] = 0.1

    def check(self) -> Iterator[tuple[str, str]]:
        """See `Config`."""
        try:
            check_lcm_url(self.lcm_url)
        except RemoSplatError as error:
            yield "lcm_url", str(error)


def check_lcm_url(url: str) -> None:
    """Raises `RemoSplatError` where LCM would print a line and stay deaf."""
    if url.startswith("memq://"):
        return
    match = re.fullmatch(r"udpm://([\d.]+):(\d+)(\?ttl=\d+)?", url)
    try:
        good = match is not None and _is_group(match[1], int(match[2]))
    except ValueError:
        good = False
    if not good:
        raise RemoSplatError(
            f"LCM URL {url!r}: expected udpm://ADDRESS:PORT?ttl=N with a"
            " multicast address, or memq://"
        )


def _is_group(address: str, port: int) -> bool:
    return ipaddress.IPv4Address(address).is_multicast and 0 < port < 2**16
