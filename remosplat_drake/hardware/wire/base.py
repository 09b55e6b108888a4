"""LCM messages of the mobile base: base_command and base_status.

`extrapolated_pose` is the odometry extrapolation of control ticks.
"""

import dataclasses as dc
import math

import numpy as np

from remosplat_drake.hardware.wire.messages.base_command import base_command
from remosplat_drake.hardware.wire.messages.base_status import base_status
from remosplat_drake.hardware.wire.packets import (
    BrokenMessage,
    decode,
    finite_vector,
    from_utime,
    to_utime,
)

MODE_NAMES = {
    base_status.READY: "ready",
    base_status.MOVING: "moving",
    base_status.STOPPED: "stopped",
    base_status.FAULT: "fault",
}
"""Names of the base's modes, keyed by their numbers in base_status."""


@dc.dataclass(frozen=True, eq=False)
class BaseState:
    """Measurements of the base's driver; a copy is the object itself.

    Attributes:
        pose: x, y and yaw in the map, shape (3,) [m, m, rad].
        velocity: Speeds forward and to the left, and turning rate, shape (3,)
            [m/s, m/s, rad/s].
        stamp: Time of measurement, by the driver's wall clock [s].
        mode: A key of `MODE_NAMES`.
        protective_stop: Whether the safety scanner stops the motors; this stop
            ends by itself.
        emergency_stop: Whether an emergency stop is latched.
        battery: State of charge, 0 to 1; negative if unknown.
    """

    pose: np.ndarray
    velocity: np.ndarray
    stamp: float
    mode: int
    protective_stop: bool
    emergency_stop: bool
    battery: float

    def __deepcopy__(self, memo) -> "BaseState":
        return self


def base_axes(n_base: int) -> list[int]:
    """Returns the components of a base's velocity that can be commanded.

    Args:
        n_base: Number of the base's commands: 2 for a differential base, 3 for
            an omnidirectional base, 0 for a robot without a base.
    """
    return [0, 2] if n_base == 2 else list(range(n_base))


def base_velocity(u: np.ndarray) -> np.ndarray:
    """Returns the velocity that a command requests.

    Args:
        u: Speed forward, speed to the left for an omnidirectional base, and
            turning rate, shape (2,) or (3,) [m/s, rad/s].

    Returns:
        Speeds forward and to the left, and turning rate, shape (3,).
    """
    velocity = np.zeros(3)
    velocity[base_axes(len(u))] = u
    return velocity


def encode_base_command(velocity: np.ndarray, time: float) -> bytes:
    """Encodes a velocity command to the base.

    Args:
        velocity: Speeds forward and to the left, and turning rate, shape (3,)
            [m/s, m/s, rad/s].
        time: Wall clock now [s].
    """
    message = base_command()
    message.utime = to_utime(time)
    message.forward, message.left, message.yaw_rate = map(float, velocity)
    return message.encode()


def decode_base_status(data: bytes) -> BaseState:
    """Decodes and checks a status of the base.

    Raises:
        BrokenMessage: The packet is not a status of a base.
    """
    message = decode(base_status, data)
    if message.mode not in MODE_NAMES:
        valid = ", ".join(map(str, MODE_NAMES))
        raise BrokenMessage(f"mode is {message.mode}; valid: {valid}")
    return BaseState(
        pose=finite_vector("pose", message.pose, 3),
        velocity=finite_vector(
            "velocity", [message.forward, message.left, message.yaw_rate], 3
        ),
        stamp=from_utime(message.utime),
        mode=message.mode,
        protective_stop=bool(message.protective_stop),
        emergency_stop=bool(message.emergency_stop),
        battery=float(message.battery),
    )


def extrapolated_pose(
    pose: np.ndarray, velocity: np.ndarray, duration: float
) -> np.ndarray:
    """Extrapolates odometry along the exact arc of a planar twist.

    Odometry arrives at 10 to 37 Hz, but a control tick needs the present pose.

    Args:
        pose: Measured x, y and yaw, shape (3,) [m, m, rad].
        velocity: Constant speeds forward and to the left, and turning rate,
            shape (3,) [m/s, m/s, rad/s].
        duration: Duration of the extrapolation [s].

    Returns:
        x, y and yaw at the end of the arc, shape (3,) [m, m, rad].
    """
    x, y, yaw = pose
    forward, left, yaw_rate = velocity
    half = 0.5 * yaw_rate * duration
    # The chord of the arc points in the direction of the mean heading.
    share = duration * (math.sin(half) / half if half != 0.0 else 1.0)
    c, s = share * math.cos(yaw + half), share * math.sin(yaw + half)
    return np.array(
        [
            x + forward * c - left * s,
            y + forward * s + left * c,
            yaw + 2 * half,
        ]
    )
