"""`HardwareConfig`: addresses of a robot's drivers, and limits for them."""

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
"""LCM takes no longer names of channels."""

REHEARSAL_URL = "udpm://239.255.76.67:7670?ttl=0"
"""Address of the stand-in robot: within this computer, on a port that no real
robot's driver uses."""

ROBOT_URL = "udpm://239.255.76.67:7667?ttl=0"
"""Address of a real robot's drivers: LCM's own default, within this
computer."""

ChannelName = Annotated[str, Len(1, _LONGEST_NAME)]
"""Name of an LCM channel: 1 to 63 characters."""


@dc.dataclass
class ChannelNames(Config):
    """Names of one robot's LCM channels, each different from all others."""

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
    # Channel of all that moves, mover_list.
    movers: ChannelName = wire.MOVERS
    # Channel of which map counts, counting_map.
    counting_map: ChannelName = wire.COUNTING_MAP
    # Channel of the wrist camera's images, lcmt_image_array.
    wrist_camera: ChannelName = wire.WRIST_CAMERA

    def check(self) -> Iterator[tuple[str, str]]:
        """Yields an error for each name that is given twice."""
        names = dc.asdict(self)
        for field, name in names.items():
            if list(names.values()).count(name) > 1:
                yield field, f"must be a name of its own, got {name!r}"


@dc.dataclass
class HardwareConfig(Config):
    """The real robot: the LCM wire to its drivers, and limits on commands."""

    # URL of the LCM network; the default is that of the stand-in robot. The
    # multicast time to live decides how far messages go: ttl=1 reaches the
    # local network, ttl=0 this machine only.
    lcm_url: str = REHEARSAL_URL
    # URL of the LCM network of the wrist camera. Empty stands for the address
    # of `lcm_url` with the next port: images of that size would otherwise
    # load the socket on which the robot's statuses come.
    camera_url: str = ""
    # Drake's settings of LCM: its URL goes in place of `lcm_url`, and its
    # `channel_suffix` behind the names of all channels.
    lcm: DrakeLcmParams | None = None
    # Whether to compute, show and record everything, and send nothing.
    shadow: bool = False
    # Names of the LCM channels.
    channels: ChannelNames = dc.field(default_factory=ChannelNames)
    # Longest wait for the first status of each driver [s].
    connect_timeout: Annotated[float, Interval(gt=0, le=600)] = 10.0
    # How often the arm's driver tells its state [Hz]. Control stays at the rate
    # of `control_period`. Limits on the age of a status follow: each is longer
    # by one period, so that a stop of a slow arm is noticed later.
    arm_status_rate: Annotated[float, Interval(ge=20, le=1000)] = 1000.0
    # Age at which a status of the arm is stale and the robot is stopped, less
    # the period of its statuses [s].
    arm_status_expiry: Annotated[float, Interval(gt=0, le=1)] = (
        wire.STATUS_EXPIRY
    )
    # Age at which a status of the base is stale and the robot is stopped
    # [s]. Up to this age its odometry is extrapolated.
    base_status_expiry: Annotated[float, Interval(gt=0, le=1)] = (
        wire.BASE_STATUS_EXPIRY
    )
    # Age at which a status of the hand is stale: its width is unknown, and a
    # task that carries something has failed [s].
    hand_status_expiry: Annotated[float, Interval(gt=0, le=5)] = (
        wire.HAND_STATUS_EXPIRY
    )
    # Time after which a status whose content does not change while the robot
    # should be moving counts as frozen, and the robot is stopped [s].
    frozen_after: Annotated[float, Interval(gt=0, le=1)] = 0.2
    # Lower bound on the base's speed forward, not positive [m/s]; a command
    # beyond it is scaled as a whole. Safety-rated sensors do not watch the
    # base's rear, so that it may only creep backwards.
    base_forward_lower: Annotated[float, Interval(ge=-2, le=0)] = -0.25
    # Upper bound on the base's speed forward [m/s]; a command beyond it is
    # scaled as a whole.
    base_forward_upper: Annotated[float, Interval(gt=0, le=2)] = 0.5
    # Bound on the speed of an omnidirectional base to either side [m/s]; a
    # command beyond it is scaled as a whole.
    base_sideways: Annotated[float, Interval(gt=0, le=2)] = 0.25
    # Bound on the base's turning rate, either way [rad/s]; a command beyond
    # it is scaled as a whole.
    base_yaw_rate: Annotated[float, Interval(gt=0, le=4)] = 0.87
    # Longest time from a command to the base until its odometry shows it [s].
    # A base that has not done by then what it was told is stopped.
    base_delay: Annotated[float, Interval(ge=0, le=1)] = 0.25
    # Share of its way by which the base's motion may differ from its commands
    # and from its own speeds: wheels slip. A base that differs by more is
    # stopped.
    base_share: Annotated[float, Interval(ge=0.01, le=0.5)] = 0.06
    # Greatest age of the base's statuses when they come, or how far their
    # clock may be ahead [s]; with more of it the robot is stopped.
    base_latency: Annotated[float, Interval(gt=0, le=0.5)] = 0.15
    # Where the base is in the map, besides its odometry; absent: the pose in
    # the base's status is that in the map.
    localization: LocalizationConfig | None = None
    # What moves, as another process sees it; absent: none does, and nothing
    # is taken to move.
    movers: MoverSensingConfig | None = None
    # How the arm is reached by `remosplat arm-driver`: `!Ros2Arm`, `!UrArm` or
    # one's own, as `!my_arm:MyArm`; absent: by a driver of another program.
    arm_driver: Ros2Arm | UrArm | ArmDriverMaker | None = None
    # How the base is reached by `remosplat base-driver`: `!Ros2Base`,
    # `!Ros1Base` or one's own; absent: by a driver of another program.
    base_driver: Ros2Base | Ros1Base | BaseDriverMaker | None = None
    # How the hand is reached by `remosplat hand-driver`: `!Ros2Hand` or one's
    # own; absent: by a driver of another program.
    hand_driver: Ros2Hand | HandDriverMaker | None = None
    # Shortest time between two commands to the hand [s].
    hand_period: Annotated[float, Interval(ge=0.01, le=10)] = 0.1

    def check(self) -> Iterator[tuple[str, str]]:
        """Yields an error for each setting with which LCM would stay deaf."""
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
                f"differs from lcm_url {self.lcm_url!r}: give one of them",
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
                "must be false: statuses are heard from the start",
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
        """Takes another LCM network; the names of its channels stay.

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
        """Lower and upper bounds on the base's velocity: forward, left, turn.

        Both have the shape (3,) [m/s, m/s, rad/s].
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
        """Text behind the names of all channels."""
        return "" if self.lcm is None else self.lcm.channel_suffix

    def open_lcm(self) -> DrakeLcm:
        """Opens the LCM network, which appends the suffix to channel names."""
        return self._open(self.url)

    def open_camera_lcm(self) -> DrakeLcm:
        """Opens the LCM network of the wrist camera, likewise."""
        return self._open(self.camera_url or beside(self.url))

    def _open(self, url: str) -> DrakeLcm:
        return DrakeLcm(DrakeLcmParams(lcm_url=url, channel_suffix=self.suffix))


def leaves_computer(url: str) -> bool:
    """Returns whether messages at an LCM URL reach other computers."""
    match = re.search(r"[?&]ttl=(\d+)", url)
    return match is not None and int(match[1]) > 0


def beside(url: str) -> str:
    """Returns the LCM URL of the same address with the next port.

    Args:
        url: For example `udpm://239.255.76.67:7667?ttl=0`; one without a port
            is returned as it is.
    """
    return re.sub(r":(\d+)", lambda port: f":{int(port[1]) + 1}", url, count=1)


def check_lcm_url(url: str) -> None:
    """Checks an LCM URL, with which LCM itself would only stay deaf.

    Args:
        url: For example `udpm://239.255.76.67:7667?ttl=0`, or `memq://` for
            messages within one object.

    Raises:
        RemoSplatError: It is not a multicast address with a port.
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
