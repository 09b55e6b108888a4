"""`HardwareConfig`: settings of the connection to a robot's drivers."""

import dataclasses as dc
import ipaddress
import re
from collections.abc import Iterator
from typing import Annotated

import numpy as np
from annotated_types import Interval, Len
from pydrake.lcm import DrakeLcm, DrakeLcmParams

from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.base.ranges import Config
from remosplat_drake.hardware.driver_config import (
    ArmDriverMaker,
    BaseDriverMaker,
    HandDriverMaker,
    Ros1Base,
    Ros2Arm,
    Ros2Base,
    Ros2Hand,
    UrArm,
)
from remosplat_drake.hardware.localization_config import LocalizationConfig
from remosplat_drake.hardware.mover_sensing_config import MoverSensingConfig
from remosplat_drake.hardware.wire import channels as wire

_LONGEST_NAME = 63
"""Greatest length of LCM channel names."""

REHEARSAL_URL = "udpm://239.255.76.67:7670?ttl=0"
"""LCM URL of the stand-in robot: only on this computer, with a port that no
driver of a real robot uses.
"""

ROBOT_URL = "udpm://239.255.76.67:7667?ttl=0"
"""LCM URL of a real robot's drivers: LCM's default address, only on this
computer.
"""

ChannelName = Annotated[str, Len(1, _LONGEST_NAME)]
"""Name of an LCM channel: 1 to 63 characters."""


@dc.dataclass
class ChannelNames(Config):
    """Names of one robot's LCM channels, which must all differ."""

    # Channel of the ramps by which the drivers brake, command_ramp.
    command_ramp: ChannelName = wire.COMMAND_RAMP
    # Channel of the arm's velocity commands, lcmt_panda_command.
    arm_command: ChannelName = wire.PANDA_COMMAND
    # Channel of the arm's statuses, lcmt_panda_status.
    arm_status: ChannelName = wire.PANDA_STATUS
    # Channel of the gripper's commands, lcmt_schunk_wsg_command.
    hand_command: ChannelName = wire.PANDA_HAND_COMMAND
    # Channel of the gripper's statuses, lcmt_schunk_wsg_status.
    hand_status: ChannelName = wire.PANDA_HAND_STATUS
    # Channel of the mobile base's velocity commands, base_command.
    base_command: ChannelName = wire.BASE_COMMAND
    # Channel of the mobile base's odometry and stops, base_status.
    base_status: ChannelName = wire.BASE_STATUS
    # Channel of the mobile base's localisation, base_localization.
    localization: ChannelName = wire.BASE_LOCALIZATION
    # Channel of movers (moving objects), mover_list.
    movers: ChannelName = wire.MOVERS
    # Channel of the map version in use, counting_map.
    counting_map: ChannelName = wire.COUNTING_MAP
    # Channel of the wrist camera's images, lcmt_image_array.
    wrist_camera: ChannelName = wire.WRIST_CAMERA

    def check(self) -> Iterator[tuple[str, str]]:
        """Yields an error for each name that occurs twice."""
        names = dc.asdict(self)
        for field, name in names.items():
            if list(names.values()).count(name) > 1:
                yield field, f"must differ from other channels, got {name!r}"


@dc.dataclass
class HardwareConfig(Config):
    """Settings of a real robot: its LCM network, and limits of messages."""

    # URL of the LCM network; the default is the URL of the stand-in robot. The
    # multicast time to live limits the range of messages: with ttl=1, they
    # reach the local network; with ttl=0, they reach only this computer.
    lcm_url: str = REHEARSAL_URL
    # URL of the LCM network of the wrist camera. If empty, it is the address of
    # `lcm_url` with the next port, so that large images do not share the socket
    # of the robot's statuses.
    camera_url: str = ""
    # Drake's settings of LCM: its URL replaces `lcm_url`, and its
    # `channel_suffix` is appended to the names of all channels.
    lcm: DrakeLcmParams | None = None
    # Whether the run is in shadow mode: it computes, displays and records
    # commands, but sends nothing.
    shadow: bool = False
    # Names of the LCM channels.
    channels: ChannelNames = dc.field(default_factory=ChannelNames)
    # Longest wait for the first status of each driver [s].
    connect_timeout: Annotated[float, Interval(gt=0, le=600)] = 10.0
    # Rate of the arm driver's statuses [Hz]. It does not change the control
    # rate. One period of statuses is added to the limits on the age of a
    # status, so at a low rate, faults of the arm are detected later.
    arm_status_rate: Annotated[float, Interval(ge=20, le=1000)] = 1000.0
    # Age at which a status of the arm is stale and the robot is stopped [s].
    # One period of the arm's statuses is added to it.
    arm_status_expiry: Annotated[float, Interval(gt=0, le=1)] = (
        wire.STATUS_EXPIRY
    )
    # Age at which a status of the base is stale and the robot is stopped
    # [s]. Up to this age its odometry is extrapolated.
    base_status_expiry: Annotated[float, Interval(gt=0, le=1)] = (
        wire.BASE_STATUS_EXPIRY
    )
    # Age at which a status of the hand is stale [s]. The hand's width is then
    # unknown, and a task in which the hand holds an object fails.
    hand_status_expiry: Annotated[float, Interval(gt=0, le=5)] = (
        wire.HAND_STATUS_EXPIRY
    )
    # Time after which statuses without any change count as frozen, and the
    # robot is stopped [s]. It applies only while the robot should move.
    frozen_after: Annotated[float, Interval(gt=0, le=1)] = 0.2
    # Lower bound on the base's speed forward, not positive [m/s]; a command
    # beyond it is scaled by one factor. Safety-rated sensors do not watch the
    # space behind the base, so it may only move slowly backwards.
    base_forward_lower: Annotated[float, Interval(ge=-2, le=0)] = -0.25
    # Upper bound on the base's speed forward [m/s]; a command beyond it is
    # scaled by one factor.
    base_forward_upper: Annotated[float, Interval(gt=0, le=2)] = 0.5
    # Bound on the speed of an omnidirectional base to either side [m/s]; a
    # command beyond it is scaled by one factor.
    base_sideways: Annotated[float, Interval(gt=0, le=2)] = 0.25
    # Bound on the base's turning rate, either way [rad/s]; a command beyond it
    # is scaled by one factor.
    base_yaw_rate: Annotated[float, Interval(gt=0, le=4)] = 0.87
    # Longest time from a command to the base until its odometry shows the
    # motion [s]. The robot is stopped if the base has not followed within this
    # time.
    base_delay: Annotated[float, Interval(ge=0, le=1)] = 0.25
    # Permitted difference of the base's motion from its commands and from its
    # measured speeds, as a fraction of the distance, since wheels slip. Beyond
    # it, the robot is stopped.
    base_share: Annotated[float, Interval(ge=0.01, le=0.5)] = 0.06
    # Greatest age of the base's statuses on arrival, or greatest time by which
    # their stamps may be in the future [s]. Beyond it, the robot is stopped.
    base_latency: Annotated[float, Interval(gt=0, le=0.5)] = 0.15
    # Settings of the localisation of the base in the map. If absent, the pose
    # in the base's status is used as the pose in the map.
    localization: LocalizationConfig | None = None
    # Settings of movers (moving objects) from a perception process. If absent,
    # the controller assumes that no object moves.
    movers: MoverSensingConfig | None = None
    # Driver of the arm for `remosplat arm-driver`: `!Ros2Arm`, `!UrArm` or a
    # class of another package, such as `!my_arm:MyArm`. If absent, another
    # program is the driver.
    arm_driver: Ros2Arm | UrArm | ArmDriverMaker | None = None
    # Driver of the base for `remosplat base-driver`: `!Ros2Base`, `!Ros1Base`
    # or a class of another package. If absent, another program is the driver.
    base_driver: Ros2Base | Ros1Base | BaseDriverMaker | None = None
    # Driver of the hand for `remosplat hand-driver`: `!Ros2Hand` or a class of
    # another package. If absent, another program is the driver.
    hand_driver: Ros2Hand | HandDriverMaker | None = None
    # Shortest time between two commands to the hand [s].
    hand_period: Annotated[float, Interval(ge=0.01, le=10)] = 0.1

    def check(self) -> Iterator[tuple[str, str]]:
        """Yields an error for each setting with which LCM would not work."""
        try:
            check_lcm_url(self.url)
        except RemoSplatError as error:
            is_ours = self.url == self.lcm_url
            yield "lcm_url" if is_ours else "lcm.lcm_url", str(error)
        yield from self._check_camera_url()
        if self.lcm is None:
            return
        if self.lcm_url not in (self.url, HardwareConfig.lcm_url):
            yield (
                "lcm.lcm_url",
                f"differs from lcm_url {self.lcm_url!r}: set only one of them",
            )
        longest = max(map(len, dc.asdict(self.channels).values()))
        if longest + len(self.lcm.channel_suffix) > _LONGEST_NAME:
            yield (
                "lcm.channel_suffix",
                f"makes names of channels longer than {_LONGEST_NAME}",
            )
        if self.lcm.defer_initialization:
            yield (
                "lcm.defer_initialization",
                "must be false, since statuses are received from the start",
            )

    def _check_camera_url(self) -> Iterator[tuple[str, str]]:
        try:
            check_lcm_url(self.camera_url or beside(self.url))
        except RemoSplatError as error:
            yield "camera_url", str(error)

    @property
    def url(self) -> str:
        """URL of the LCM network, from `lcm` or from `lcm_url`."""
        return (self.lcm and self.lcm.lcm_url) or self.lcm_url

    def use_url(self, url: str) -> None:
        """Changes the LCM network, but not the names of the channels.

        Args:
            url: LCM URL of the network.

        Raises:
            RemoSplatError: The URL is unusable.
        """
        check_lcm_url(url)
        self.lcm_url = url
        if self.lcm is not None:
            self.lcm.lcm_url = ""

    @property
    def base_bounds(self) -> tuple[np.ndarray, np.ndarray]:
        """Lower and upper bounds on the base's velocity.

        They are speeds forward and to the left, and turning rate; both bounds
        have the shape (3,) [m/s, m/s, rad/s].
        """
        aside, turn = self.base_sideways, self.base_yaw_rate
        return (
            np.array([self.base_forward_lower, -aside, -turn]),
            np.array([self.base_forward_upper, aside, turn]),
        )

    @property
    def arm_status_period(self) -> float:
        """Time between two statuses of the arm [s]."""
        return 1.0 / self.arm_status_rate

    @property
    def arm_status_limit(self) -> float:
        """Age at which a status of the arm is stale [s]."""
        return self.arm_status_expiry + self.arm_status_period

    @property
    def suffix(self) -> str:
        """Suffix of the names of all channels."""
        return "" if self.lcm is None else self.lcm.channel_suffix

    def open_lcm(self) -> DrakeLcm:
        """Opens the LCM network, which appends the suffix to channel names."""
        return self._open(self.url)

    def open_camera_lcm(self) -> DrakeLcm:
        """Opens the wrist camera's LCM network, with the same suffix."""
        return self._open(self.camera_url or beside(self.url))

    def _open(self, url: str) -> DrakeLcm:
        return DrakeLcm(DrakeLcmParams(lcm_url=url, channel_suffix=self.suffix))


def leaves_computer(url: str) -> bool:
    """Returns whether messages to an LCM URL reach other computers."""
    match = re.search(r"[?&]ttl=(\d+)", url)
    return match is not None and int(match[1]) > 0


def beside(url: str) -> str:
    """Returns the LCM URL of the same address with the next port.

    Args:
        url: For example `udpm://239.255.76.67:7667?ttl=0`. A URL without a port
            is returned unchanged.
    """
    return re.sub(r":(\d+)", lambda port: f":{int(port[1]) + 1}", url, count=1)


def check_lcm_url(url: str) -> None:
    """Checks an LCM URL, since LCM does not report an unusable one.

    Args:
        url: For example `udpm://239.255.76.67:7667?ttl=0`, or `memq://` for
            messages within one LCM object.

    Raises:
        RemoSplatError: The URL is not a multicast address with a port.
    """
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
