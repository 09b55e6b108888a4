"""`TeleopConfig`: limits within which an operator moves the target."""

import dataclasses as dc
from collections.abc import Iterator
from typing import Annotated

import numpy as np
from annotated_types import Interval, Len
from pydrake.math import RigidTransform, RollPitchYaw

from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.base.ranges import (
    Config,
    OneOf,
    Position,
    RollPitchYawDeg,
)
from remosplat_drake.hardware.hardware_config import ChannelName, check_lcm_url
from remosplat_drake.signals.target import DIRECTIONS, weights_problem


@dc.dataclass
class SavedPose(Config):
    """A pose of the end effector that an operator can pick by its name."""

    # Position of the end effector in the world frame W [m].
    translation: Position = dc.field(default_factory=lambda: [0.0] * 3)
    # Roll, pitch and yaw of the end effector in W [deg]; the default points a
    # gripper down.
    rpy_deg: RollPitchYawDeg = dc.field(
        default_factory=lambda: [180.0, 0.0, 0.0]
    )

    def matrix(self) -> np.ndarray:
        """Returns the pose X_WE, shape (4, 4)."""
        R = RollPitchYaw(np.radians(self.rpy_deg))
        return RigidTransform(R, self.translation).GetAsMatrix4()


@dc.dataclass
class GamepadConfig(Config):
    """The page's gamepad; buttons have the numbers of W3C's standard layout."""

    # Number of the button that is the dead-man switch; the target moves only
    # while it is held. 5 is the right shoulder button.
    dead_man: Annotated[int, Interval(ge=0, le=63)] = 5
    # Speed of the target with a stick fully pushed [m/s].
    speed: Annotated[float, Interval(gt=0, le=2)] = 0.15
    # Turning rate of the target with a stick fully pushed [rad/s].
    rotation: Annotated[float, Interval(gt=0, le=10)] = 0.6
    # Dead zone: fraction of a stick's range around its centre that counts as
    # released.
    dead_zone: Annotated[float, Interval(ge=0, lt=1)] = 0.1
    # Greatest distance of the target from the end effector [m]. It limits how
    # far the target moves away from an end effector that an obstacle holds.
    max_lead: Annotated[float, Interval(gt=0, le=2)] = 0.2


@dc.dataclass
class PoseStreamConfig(Config):
    """Target poses and velocities that another program sends by LCM."""

    # URL of the LCM network. The multicast time to live decides how far
    # messages go: ttl=0 stays on this machine, ttl=1 in the local network.
    lcm_url: str = "udpm://239.255.76.67:7667?ttl=0"
    # Name of the end effector that the poses move, if there are several; empty
    # for the one that the operator has selected.
    effector: str = ""
    # Channel of the poses, of type pose_target.
    channel: ChannelName = "POSE_TARGET"
    # Channel of the velocities, of type velocity_target. They move the target
    # as a gamepad does, within the gamepad's `max_lead`.
    velocity_channel: ChannelName = "VELOCITY_TARGET"
    # Time without a message after which the target stops following the stream,
    # and greatest age of a message [s].
    expiry: Annotated[float, Interval(gt=0, le=10)] = 0.3

    def check(self) -> Iterator[tuple[str, str]]:
        """Yields an error for an unusable LCM URL, or for equal channels."""
        try:
            check_lcm_url(self.lcm_url)
        except RemoSplatError as error:
            yield "lcm_url", str(error)
        if self.velocity_channel == self.channel:
            yield "velocity_channel", "must differ from `channel`"


@dc.dataclass
class ScanConfig(Config):
    """A scan: the wrist camera looks around for a map, in two rows of views."""

    # Largest pan angle of the camera, to either side of straight ahead [deg].
    pan_deg: Annotated[float, Interval(ge=0, le=90)] = 60.0
    # Angle below the horizon at which the camera looks in the row of steep
    # views [deg].
    steep_deg: Annotated[float, Interval(ge=0, le=90)] = 60.0
    # Angle below the horizon at which the camera looks in the row of flat views
    # [deg].
    flat_deg: Annotated[float, Interval(ge=0, le=90)] = 25.0
    # Time at a pose before its frame is taken [s].
    dwell: Annotated[float, Interval(ge=0, le=60)] = 0.3
    # Longest time for which a scan waits for the robot after the target has
    # arrived at a pose [s]. Then the camera takes the frame from the robot's
    # present pose.
    timeout: Annotated[float, Interval(gt=0, le=60)] = 2.0


@dc.dataclass
class FoundObjectConfig(Config):
    """Objects that an operator finds in the map by a point on them."""

    # Mass that is assumed for them, since a map shows no masses [kg].
    mass: Annotated[float, Interval(gt=0, le=1000)] = 0.5
    # Largest extent of such an object along each axis of W [m].
    largest: Annotated[float, Interval(ge=0.02, le=2)] = 0.4


@dc.dataclass
class TeleopConfig(Config):
    """Bounds of the target's motion, and the sources of operators' requests.

    If there is a page, its controls are one of the sources.
    """

    # Greatest speed of the target [m/s].
    max_speed: Annotated[float, Interval(gt=0, le=2)] = 0.25
    # Greatest turning rate of the target [rad/s].
    max_rotation: Annotated[float, Interval(gt=0, le=10)] = 1.0
    # Greatest acceleration of the target [m/s^2].
    max_acceleration: Annotated[float, Interval(gt=0, le=20)] = 0.5
    # Greatest angular acceleration of the target [rad/s^2].
    max_rotation_acceleration: Annotated[float, Interval(gt=0, le=100)] = 2.0
    # Lower corner, in the world frame W, of the box in which the target stays
    # [m].
    workspace_lower: Position = dc.field(
        default_factory=lambda: [-5.0, -5.0, 0.05]
    )
    # Upper corner of that box, in W [m].
    workspace_upper: Position = dc.field(
        default_factory=lambda: [5.0, 5.0, 2.0]
    )
    # Free directions of the target while the operator moves it, as in a
    # scenario's `targets`: [rz] for a tool that may turn about its own axis. A
    # target that is held or that scans has no free directions.
    free: Annotated[
        list[Annotated[str, OneOf(DIRECTIONS, "direction")]], Len(0, 6)
    ] = dc.field(default_factory=list)
    # Force with which the hand closes [N].
    grip_force: Annotated[float, Interval(gt=0, le=1000)] = 20.0
    # Poses that an operator can pick; their names are on the buttons.
    poses: dict[str, SavedPose] = dc.field(default_factory=dict)
    # The gamepad with which an operator moves the target on the page.
    gamepad: GamepadConfig = dc.field(default_factory=GamepadConfig)
    # The scan with the wrist camera.
    scan: ScanConfig = dc.field(default_factory=ScanConfig)
    # Objects that an operator finds in the map by a point on them.
    found_objects: FoundObjectConfig = dc.field(
        default_factory=FoundObjectConfig
    )
    # Path of a YAML file of timed poses and presses of buttons, relative to the
    # scenario's file; empty: no such file.
    trajectory: str = ""
    # Targets that another program sends by LCM; absent: no targets are
    # received.
    pose_stream: PoseStreamConfig | None = None

    def check(self) -> Iterator[tuple[str, str]]:
        """Yields errors if fields contradict each other.

        The workspace must not be empty and must contain the saved poses. At
        least one direction must not be free.
        """
        asked = [float(name not in self.free) for name in DIRECTIONS]
        problem = weights_problem(np.array(asked))
        if problem:
            yield "free", problem
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
