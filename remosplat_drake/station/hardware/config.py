"""`HardwareConfig`: where the robot's drivers are, and what they may do."""

import dataclasses as dc
import ipaddress
import math
import re

from remosplat_drake.errors import FieldError, RemoSplatError
from remosplat_drake.messages import channels as wire


@dc.dataclass
class ChannelNames:
    """The LCM channels of one robot."""

    arm_command: str = wire.PANDA_COMMAND
    arm_status: str = wire.PANDA_STATUS
    hand_command: str = wire.PANDA_HAND_COMMAND
    hand_status: str = wire.PANDA_HAND_STATUS
    base_command: str = wire.BASE_COMMAND
    base_status: str = wire.BASE_STATUS
    wrist_camera: str = wire.WRIST_CAMERA


@dc.dataclass
class HardwareConfig:
    """The real robot, behind LCM."""

    # Where the messages are: ttl=1 reaches the local network, ttl=0 this
    # machine only.
    lcm_url: str = "udpm://239.255.76.67:7667?ttl=1"
    channels: ChannelNames = dc.field(default_factory=ChannelNames)
    # How long to wait for the first status of each driver [s].
    connect_timeout: float = 10.0
    # Ages at which a status is stale and the robot is stopped [s].
    arm_status_expiry: float = wire.STATUS_EXPIRY
    base_status_expiry: float = wire.BASE_STATUS_EXPIRY
    # A status whose content has not changed for so long while the robot
    # should be moving is frozen [s].
    frozen_after: float = 0.2
    # Speeds of the base: a command outside is scaled as a whole. Its rear is
    # not watched by safety-rated sensors, so it may only creep backwards
    # [m/s, rad/s].
    base_forward_lower: float = -0.25
    base_forward_upper: float = 0.5
    base_yaw_rate: float = 0.87
    # Time between two commands to the hand [s].
    hand_period: float = 0.1


def check_hardware_config(config: HardwareConfig, where: str) -> None:
    """Raises `FieldError` where a value is unusable."""
    try:
        check_lcm_url(config.lcm_url)
    except RemoSplatError as error:
        raise FieldError(where, "hardware.lcm_url", str(error)) from error
    for name in (
        "connect_timeout",
        "arm_status_expiry",
        "base_status_expiry",
        "frozen_after",
        "base_forward_upper",
        "base_yaw_rate",
        "hand_period",
    ):
        value = getattr(config, name)
        if not (math.isfinite(value) and value > 0):
            raise FieldError(
                where, f"hardware.{name}", f"must be positive, got {value!r}"
            )
    if not config.base_forward_lower <= 0:
        raise FieldError(
            where,
            "hardware.base_forward_lower",
            f"must not be positive, got {config.base_forward_lower!r}",
        )
    names = dc.asdict(config.channels)
    for field, name in names.items():
        if not name or list(names.values()).count(name) > 1:
            raise FieldError(
                where,
                f"hardware.channels.{field}",
                f"must be a name of its own, got {name!r}",
            )


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
