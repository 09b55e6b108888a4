"""`Measurement`: the latest received states of arm, base and gripper."""

import dataclasses as dc
import math

import numpy as np

from remosplat_drake.hardware.client.base_residual import CommandedPath
from remosplat_drake.hardware.client.base_track import (
    BaseTrack,
    with_base_sample,
)
from remosplat_drake.hardware.client.plausibility import arm_jump
from remosplat_drake.hardware.client.stream import Stream, advanced, broken
from remosplat_drake.hardware.hardware_config import HardwareConfig
from remosplat_drake.hardware.wire.base import (
    BaseState,
    decode_base_status,
    extrapolated_pose,
)
from remosplat_drake.hardware.wire.hand import HandState, decode_hand_status
from remosplat_drake.hardware.wire.packets import BrokenMessage
from remosplat_drake.hardware.wire.panda import PandaState, decode_panda_status


@dc.dataclass(frozen=True, eq=False)
class Measurement:
    """The latest valid states of a robot's parts; a copy is the object itself.

    The state of a part that has sent no status is None. After an unusable
    message, the previous state is kept, and the part's stream contains the
    problem.

    Attributes:
        arm: Latest valid state of the arm.
        arm_stream: Timing and faults of the arm's status channel.
        base: Latest valid state of the base.
        base_stream: Timing and faults of the base's status channel.
        base_track: The base's recent poses, and its pose in the map.
        hand: Latest valid state of the gripper.
        counts: Numbers of packets so far, from arm, base, gripper and
            localisation.
        moving_since: Time at which the arm was commanded to move, by our wall
            clock [s]; infinite while its command is zero.
        intruder: Description of another program that sends commands or
            statuses; empty if there is none.
        sent: Time at which our latest command was sent, by our wall clock [s];
            -inf before the first.
    """

    arm: PandaState | None = None
    arm_stream: Stream = dc.field(default_factory=Stream)
    base: BaseState | None = None
    base_stream: Stream = dc.field(default_factory=Stream)
    base_track: BaseTrack = dc.field(default_factory=BaseTrack)
    hand: HandState | None = None
    counts: tuple[int, ...] = (0, 0, 0, 0)
    moving_since: float = math.inf
    intruder: str = ""
    sent: float = -math.inf

    def __deepcopy__(self, memo) -> "Measurement":
        return self

    def base_pose(self, now: float, expiry: float) -> np.ndarray:
        """Returns the base's pose in the map, shape (3,) [m, m, rad].

        The latest odometry is extrapolated to the present.

        Args:
            now: The time, by our wall clock [s].
            expiry: The pose is extrapolated for at most this time [s].

        Returns:
            The pose; NaN before the first status, or while it is unknown.
        """
        base = self.base
        if base is None:
            return np.full(3, np.nan)
        age = self.base_age(now, expiry)
        X_OB = extrapolated_pose(base.pose, base.velocity, age)
        return self.base_track.pose(X_OB)

    def base_age(self, now: float, expiry: float) -> float:
        """Returns the time by which the base's pose is extrapolated [s].

        Args:
            now: The time, by our wall clock [s].
            expiry: Largest time that is returned [s].

        Returns:
            The time; 0 before the first status, and for a robot without a base.
        """
        if self.base is None:
            return 0.0
        return min(max(now - self.base.stamp, 0.0), expiry)

    def hand_reading(self, now: float, expiry: float) -> np.ndarray:
        """Returns opening, rate and force of the gripper, (3,) [m, m/s, N].

        Args:
            now: The time, by our wall clock [s].
            expiry: Age at which the gripper's latest status is stale [s].

        Returns:
            The measured values; NaN if there is no status, or if it is stale.
        """
        if self.hand is None or now - self.hand.stamp > expiry:
            return np.full(3, np.nan)
        return self.hand.reading


def with_arm_status(
    measurement: Measurement,
    data: bytes,
    received: float,
    n: int,
    config: HardwareConfig,
    rate_limit: np.ndarray | None = None,
) -> Measurement:
    """Returns the measurement after a status packet from the arm.

    A packet that implies an impossible motion of the arm is also used. The
    robot stops, since either this packet or the previous one is wrong. The next
    packet is compared with this one.

    Args:
        measurement: The previous measurement.
        data: The encoded packet.
        received: Time of its arrival, by our wall clock [s].
        n: Number of the arm's joints.
        config: Settings, with the expiry times.
        rate_limit: Bounds on the joints' speeds, shape (n,) [rad/s]; None for
            no bounds.
    """
    stream, before = measurement.arm_stream, measurement.arm
    try:
        arm = decode_panda_status(data, n)
    except BrokenMessage as error:
        stream = broken(stream, received, str(error))
        return dc.replace(measurement, arm_stream=stream)
    changed = before is None or _arm_changed(before, arm)
    last = stream
    stream = advanced(
        stream, arm.stamp, received, changed, config.arm_status_limit
    )
    if before is not None and rate_limit is not None:
        duration = max(arm.stamp - last.stamp, received - last.received)
        jump = arm_jump(before, arm, duration, rate_limit)
        stream = dc.replace(stream, broken=jump)
    return dc.replace(measurement, arm=arm, arm_stream=stream)


def _arm_changed(before: PandaState, after: PandaState) -> bool:
    """Whether the robot's clock or, if there is none, a joint has changed."""
    if after.robot_stamp:
        return after.robot_stamp != before.robot_stamp
    return not (
        np.array_equal(after.q, before.q) and np.array_equal(after.v, before.v)
    )


def with_base_status(
    measurement: Measurement,
    data: bytes,
    received: float,
    config: HardwareConfig,
    commanded: CommandedPath | None = None,
) -> Measurement:
    """Returns the measurement after a status packet from the base.

    Args:
        measurement: The previous measurement.
        data: The encoded packet.
        received: Time of its arrival, by our wall clock [s].
        config: Settings, with the expiry times.
        commanded: The base's commands; None if they are unknown.
    """
    stream = measurement.base_stream
    try:
        base = decode_base_status(data)
    except BrokenMessage as error:
        stream = broken(stream, received, str(error))
        return dc.replace(measurement, base_stream=stream)
    # The base may be at rest while the arm moves, so its odometry need not
    # change.
    stream = advanced(
        stream, base.stamp, received, True, config.base_status_expiry
    )
    track = with_base_sample(
        measurement.base_track, base, received, commanded, config
    )
    return dc.replace(
        measurement, base=base, base_stream=stream, base_track=track
    )


def with_hand_status(measurement: Measurement, data: bytes) -> Measurement:
    """Returns the measurement after a status packet from the gripper.

    A malformed packet is ignored, since no safety function of the robot depends
    on the gripper's width.
    """
    try:
        return dc.replace(measurement, hand=decode_hand_status(data))
    except BrokenMessage:
        return measurement
