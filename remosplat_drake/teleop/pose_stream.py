"""A stream of target poses from another program, and its watchdog."""

import dataclasses as dc
import math

import numpy as np
from pydrake.common.eigen_geometry import Quaternion
from pydrake.math import RigidTransform

from remosplat_drake.hardware.wire.messages.pose_target import pose_target
from remosplat_drake.hardware.wire.packets import (
    BrokenMessage,
    decode,
    finite_vector,
    is_expired,
    to_utime,
)
from remosplat_drake.signals.operator_command import OperatorCommand

SOURCE = "pose stream"
"""Name of this source of commands in texts."""


@dc.dataclass(frozen=True, eq=False)
class StreamState:
    """A stream of poses so far; copying returns the object itself.

    Attributes:
        command: The command that the stream amounts to.
        utime: Stamp of the latest pose that was used [us].
        received: When that pose came, by our wall clock [s].
        flows: Whether poses are coming.
    """

    command: OperatorCommand = dc.field(
        default_factory=lambda: OperatorCommand(source=SOURCE)
    )
    utime: int = 0
    received: float = -math.inf
    flows: bool = False

    def __deepcopy__(self, memo) -> "StreamState":
        return self


def advance_stream(
    state: StreamState, packet: bytes | None, now: float, expiry: float
) -> StreamState:
    """Advances a stream by a look at the network.

    A stream takes the target when it begins, and again when it continues after
    a silence. While it flows it does not take it again, so an operator may
    press hold meanwhile.

    Args:
        state: The stream before.
        packet: The newest packet since the last look; None for none.
        now: Our wall clock [s].
        expiry: Time without a pose, or age of a pose, at which the stream has
            ended [s].
    """
    if packet is not None:
        try:
            return _take(state, packet, now, expiry)
        except BrokenMessage as error:
            return _end(state, f"the {SOURCE} is broken: {error}")
    if state.flows and not 0 <= now - state.received < expiry:
        text = f"the {SOURCE} has been silent for {expiry:g} s"
        return _end(state, text)
    return state


def decode_pose_target(data: bytes) -> tuple[int, np.ndarray]:
    """Decodes and checks a `pose_target` message.

    Args:
        data: The encoded packet.

    Returns:
        The stamp [us] and the pose X_WT, shape (4, 4).

    Raises:
        BrokenMessage: The packet holds no pose.
    """
    message = decode(pose_target, data)
    position = finite_vector("position", message.position, 3)
    quaternion = finite_vector("quaternion", message.quaternion, 4)
    length = math.hypot(*quaternion)
    if not 1e-6 < length < math.inf:
        raise BrokenMessage(f"quaternion has the length {length:g}")
    X_WT = RigidTransform(Quaternion(quaternion / length), position)
    return message.utime, X_WT.GetAsMatrix4()


def _take(
    state: StreamState, packet: bytes, now: float, expiry: float
) -> StreamState:
    utime, X_WT = decode_pose_target(packet)
    if is_expired(utime, to_utime(now), expiry):
        age = now - 1e-6 * utime
        return _end(state, f"the {SOURCE} is {age:.1f} s old on arrival")
    if utime == state.utime:
        return advance_stream(state, None, now, expiry)
    begins = not state.flows
    command = dc.replace(
        state.command,
        X_WT=X_WT,
        moves=state.command.moves + begins,
        choices=state.command.choices
        + (begins and bool(state.command.effector)),
        trouble="",
    )
    return StreamState(command, utime, now, flows=True)


def _end(state: StreamState, trouble: str) -> StreamState:
    command = dc.replace(state.command, trouble=trouble)
    return dc.replace(state, command=command, flows=False)
