"""Receives streams of target poses and velocities from another program."""

import dataclasses as dc
import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from pydrake.common.eigen_geometry import Quaternion
from pydrake.math import RigidTransform

from remosplat_drake.hardware.wire.messages.pose_target import pose_target
from remosplat_drake.hardware.wire.messages.velocity_target import (
    velocity_target,
)
from remosplat_drake.hardware.wire.packets import (
    BrokenMessage,
    decode,
    finite_vector,
    is_expired,
    to_utime,
)
from remosplat_drake.signals.operator_command import OperatorCommand


class StreamKind(NamedTuple):
    """A kind of stream: poses or velocities.

    Attributes:
        source: Name of the stream, for messages to the operator.
        take: Function with three arguments: the present command, a packet, and
            whether the stream begins with this packet. It returns the packet's
            stamp [us] and the command with the packet's content. It raises
            BrokenMessage if the packet is not a message of the stream.
    """

    source: str
    take: Callable[[OperatorCommand, bytes, bool], tuple[int, OperatorCommand]]


@dc.dataclass(frozen=True, eq=False)
class StreamState:
    """State of a stream of messages; a deep copy is the object itself.

    Attributes:
        command: The operator's command, the result of all messages so far.
        utime: Stamp of the latest message that was used [us].
        received: Time at which that message arrived, by our wall clock [s].
        flows: Whether the stream has begun and has not ended.
    """

    command: OperatorCommand = dc.field(default_factory=OperatorCommand)
    utime: int = 0
    received: float = -math.inf
    flows: bool = False

    def __deepcopy__(self, memo) -> "StreamState":
        return self


def advance_stream(
    kind: StreamKind,
    state: StreamState,
    packet: bytes | None,
    now: float,
    expiry: float,
) -> StreamState:
    """Advances a stream by the newest packet, if there is a new packet.

    A stream takes control of the target when it begins, and when it continues
    after a pause. While messages arrive without pause, it does not take control
    again, so that an operator may press hold.

    Args:
        kind: The kind of stream: poses or velocities.
        state: The previous state of the stream.
        packet: The newest packet since the previous call; None if none arrived.
        now: Our wall clock [s].
        expiry: Longest time without a message, and greatest age of a message
            [s]. Beyond it, the stream ends.
    """
    if packet is not None:
        try:
            return _take(kind, state, packet, now, expiry)
        except BrokenMessage as error:
            return _end(state, f"the {kind.source} is broken: {error}")
    if state.flows and not 0 <= now - state.received < expiry:
        text = f"the {kind.source} has been silent for {expiry:g} s"
        return _end(state, text)
    return state


def merged_command(streams: tuple[StreamState, StreamState]) -> OperatorCommand:
    """Merges the commands of a stream of poses and a stream of velocities.

    The problem (`trouble`) of the merged command is the problem of the stream
    with the latest message.

    Args:
        streams: The stream of poses, and the stream of velocities.
    """
    poses, velocities = streams
    latest = max(streams, key=lambda stream: stream.received).command
    return dc.replace(
        poses.command,
        source=latest.source,
        trouble=latest.trouble,
        V_W=velocities.command.V_W,
        choices=poses.command.choices + velocities.command.choices,
    )


def decode_pose_target(data: bytes) -> tuple[int, np.ndarray]:
    """Decodes and checks a `pose_target` message.

    Args:
        data: The encoded packet.

    Returns:
        The stamp [us] and the pose X_WT, shape (4, 4).

    Raises:
        BrokenMessage: The packet contains no valid pose.
    """
    message = decode(pose_target, data)
    position = finite_vector("position", message.position, 3)
    quaternion = finite_vector("quaternion", message.quaternion, 4)
    length = math.hypot(*quaternion)
    if not 1e-6 < length < math.inf:
        raise BrokenMessage(f"quaternion has the norm {length:g}, not 1")
    X_WT = RigidTransform(Quaternion(quaternion / length), position)
    return message.utime, X_WT.GetAsMatrix4()


def decode_velocity_target(data: bytes) -> tuple[int, np.ndarray]:
    """Decodes and checks a `velocity_target` message.

    Args:
        data: The encoded packet.

    Returns:
        The stamp [us] and the velocity V_W, angular above translational, shape
        (6,) [rad/s, m/s].

    Raises:
        BrokenMessage: The packet contains no valid velocity.
    """
    message = decode(velocity_target, data)
    w_W = finite_vector("angular", message.angular, 3)
    v_W = finite_vector("linear", message.linear, 3)
    return message.utime, np.concatenate([w_W, v_W])


def _take_pose(
    command: OperatorCommand, packet: bytes, begins: bool
) -> tuple[int, OperatorCommand]:
    utime, X_WT = decode_pose_target(packet)
    moves = command.moves + begins
    return utime, dc.replace(command, X_WT=X_WT, moves=moves)


def _take_velocity(
    command: OperatorCommand, packet: bytes, begins: bool
) -> tuple[int, OperatorCommand]:
    utime, V_W = decode_velocity_target(packet)
    return utime, dc.replace(command, V_W=V_W)


POSES = StreamKind("pose stream", _take_pose)
VELOCITIES = StreamKind("velocity stream", _take_velocity)


def _take(
    kind: StreamKind,
    state: StreamState,
    packet: bytes,
    now: float,
    expiry: float,
) -> StreamState:
    begins = not state.flows
    utime, command = kind.take(state.command, packet, begins)
    if is_expired(utime, to_utime(now), expiry):
        age = now - 1e-6 * utime
        return _end(state, f"the {kind.source} is {age:.1f} s old on arrival")
    if utime == state.utime:
        return advance_stream(kind, state, None, now, expiry)
    command = dc.replace(
        command,
        source=kind.source,
        choices=command.choices + (begins and bool(command.effector)),
        trouble="",
    )
    return StreamState(command, utime, now, flows=True)


def _end(state: StreamState, trouble: str) -> StreamState:
    command = dc.replace(state.command, trouble=trouble, V_W=None)
    return dc.replace(state, command=command, flows=False)
