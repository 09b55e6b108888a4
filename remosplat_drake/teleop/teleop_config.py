"""`TeleopConfig`: how an operator may move the target."""

import dataclasses as dc
from collections.abc import Iterator
from typing import Annotated

import numpy as np
from annotated_types import Interval
from pydrake.math import RigidTransform, RollPitchYaw

from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.base.ranges import Config, Position, RollPitchYawDeg
from remosplat_drake.hardware.hardware_config import ChannelName, check_lcm_url


@dc.dataclass
class SavedPose(Config):
    """A pose of the end effector in W that an operator can pick."""

    translation: Position = dc.field(default_factory=lambda: [0.0] * 3)
    # Roll, pitch, yaw [deg]; the default points a gripper down.
    rpy_deg: RollPitchYawDeg = dc.field(
        default_factory=lambda: [180.0, 0.0, 0.0]
    )

    def matrix(self) -> np.ndarray:
        """The pose X_WE, shape (4, 4)."""
        R = RollPitchYaw(np.radians(self.rpy_deg))
        return RigidTransform(R, self.translation).GetAsMatrix4()


@dc.dataclass
class GamepadConfig(Config):
    """A gamepad in the browser, by the standard layout's numbers."""

    # The button without which nothing moves: 5 is the right shoulder.
    dead_man: Annotated[int, Interval(ge=0, le=63)] = 5
    # Speeds with a stick fully pushed [m/s], [rad/s].
    speed: Annotated[float, Interval(gt=0, le=2)] = 0.15
    rotation: Annotated[float, Interval(gt=0, le=10)] = 0.6
    # A stick counts as released so near to its centre.
    dead_zone: Annotated[float, Interval(ge=0, lt=1)] = 0.1
    # The target gets no farther ahead of the end effector, lest it run away
    # from one that an obstacle holds back [m].
    max_lead: Annotated[float, Interval(gt=0, le=2)] = 0.2


@dc.dataclass
class PoseStreamConfig(Config):
    """Target poses that another program sends by LCM."""

    # Where the messages are: ttl=0 is this machine only.
    lcm_url: str = "udpm://239.255.76.67:7667?ttl=0"
    channel: ChannelName = "POSE_TARGET"
    # A stream that is silent for so long is not followed any more [s].
    expiry: Annotated[float, Interval(gt=0, le=10)] = 0.3

    def check(self) -> Iterator[tuple[str, str]]:
        """See `Config`."""
        try:
            check_lcm_url(self.lcm_url)
        except RemoSplatError as error:
            yield "lcm_url", str(error)


@dc.dataclass
class ScanConfig(Config):
    """Looking around for the first map."""

    # The wrist camera looks so far to either side, in two rows: so far below
    # the horizon [deg].
    pan_deg: Annotated[float, Interval(ge=0, le=90)] = 60.0
    steep_deg: Annotated[float, Interval(ge=0, le=90)] = 60.0
    flat_deg: Annotated[float, Interval(ge=0, le=90)] = 25.0
    # Time at a pose before its frame is taken [s].
    dwell: Annotated[float, Interval(ge=0, le=60)] = 0.3
    # A robot that has not come to a pose so long after the target has its
    # frame taken where it is [s].
    timeout: Annotated[float, Interval(gt=0, le=60)] = 2.0


@dc.dataclass
class TeleopConfig(Config):
    """Bounds of the target's motion, and where an operator's wishes come from.

    The page is one of the sources wherever there is one.
    """

    # The target moves no faster [m/s], [rad/s].
    max_speed: Annotated[float, Interval(gt=0, le=2)] = 0.25
    max_rotation: Annotated[float, Interval(gt=0, le=10)] = 1.0
    # It gains and loses speed no faster [m/s^2], [rad/s^2].
    max_acceleration: Annotated[float, Interval(gt=0, le=20)] = 0.5
    max_rotation_acceleration: Annotated[float, Interval(gt=0, le=100)] = 2.0
    # Box in W in which the target stays [m].
    workspace_lower: Position = dc.field(
        default_factory=lambda: [-5.0, -5.0, 0.05]
    )
    workspace_upper: Position = dc.field(
        default_factory=lambda: [5.0, 5.0, 2.0]
    )
    # Poses to pick from, by the names on their buttons.
    poses: dict[str, SavedPose] = dc.field(default_factory=dict)
    gamepad: GamepadConfig = dc.field(default_factory=GamepadConfig)
    scan: ScanConfig = dc.field(default_factory=ScanConfig)
    # A file of timed poses and presses, relative to the scenario's: see
    # teleop/trajectory_file.py. Empty for none.
    trajectory: str = ""
    # Poses by LCM; absent: nobody listens.
    pose_stream: PoseStreamConfig | None = None

    def check(self) -> Iterator[tuple[str, str]]:
        """See `Config`."""
        lower, upper = self.workspace_lower, self.workspace_upper
        for axis, low, high in zip("xyz", lower, upper, strict=True):
            if not low < high:
                yield (
                    "workspace_upper",
                    f"must exceed workspace_lower: {axis} of {high} is not"
                    f" above {low}",
                )
        for name, pose in self.poses.items():
            p_WE = pose.translation
            if np.less(p_WE, lower).any() or np.greater(p_WE, upper).any():
                yield (
                    f"poses.{name}.translation",
                    f"{p_WE} is outside the workspace from {lower} to {upper}",
                )
