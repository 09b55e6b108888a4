"""Detects missing messages, stale stamps and frozen content of a channel."""

import dataclasses as dc
import math


@dc.dataclass(frozen=True)
class Stream:
    """Times of the latest messages of a status channel, and their faults.

    Attributes:
        stamp: Stamp of the latest valid message, by the sender's wall clock
            [s].
        received: Time at which the latest message came, by our wall clock [s].
        jump: Latest jump of the sender's clock [s]; 0 if there was none, or if
            a message has been fresh since then.
        changed: Time at which the content of a message last differed from the
            previous one, by our wall clock [s].
        broken: Faults of the latest message; empty if there are none.
    """

    stamp: float = -math.inf
    received: float = -math.inf
    jump: float = 0.0
    changed: float = -math.inf
    broken: str = ""


@dc.dataclass(frozen=True)
class StreamLimits:
    """Limits beyond which a channel's messages are not reliable.

    Attributes:
        expiry: A stamp is stale if it differs from our clock by more than this
            time, in the past or the future [s].
        frozen_after: While the content should change, it may be constant for at
            most this time [s].
    """

    expiry: float
    frozen_after: float


def advanced(
    stream: Stream, stamp: float, received: float, changed: bool, expiry: float
) -> Stream:
    """Returns a stream's history after another valid message.

    If the sender's clock was set, the differences of stamps and of times of
    arrival are not equal; this is a jump.

    Args:
        stream: The history so far.
        stamp: Stamp of the new message, by the sender's wall clock [s].
        received: Time of its arrival, by our wall clock [s].
        changed: Whether its content differs from that of the previous message.
        expiry: A jump of the sender's clock is stored if it exceeds this time,
            and forgotten if a stamp differs from our clock by no more [s].
    """
    first = math.isinf(stream.stamp)
    jump = (stamp - stream.stamp) - (received - stream.received)
    if abs(received - stamp) <= expiry:
        jump = 0.0
    elif first or not abs(jump) > expiry:
        jump = stream.jump
    return Stream(
        stamp=stamp,
        received=received,
        jump=jump,
        changed=received if changed or first else stream.changed,
    )


def broken(stream: Stream, received: float, problem: str) -> Stream:
    """Returns a stream's history after an unusable message.

    Args:
        stream: The history so far.
        received: Time at which the message came, by our wall clock [s].
        problem: Description of the message's faults.
    """
    return dc.replace(stream, received=received, broken=problem)


def stream_problem(
    stream: Stream, now: float, limits: StreamLimits, should_change: bool
) -> str:
    """Describes the fault of a stream; empty if there is none.

    Args:
        stream: The stream's history.
        now: Our wall clock [s].
        limits: Limits beyond which a stream is stale or frozen.
        should_change: Whether the content should change, because the robot has
            been commanded to move.
    """
    if math.isinf(stream.received):
        return "nothing came yet"
    if stream.broken:
        return stream.broken
    silence, age = now - stream.received, now - stream.stamp
    if max(silence, abs(age)) > limits.expiry:
        return _why_stale(stream, silence, age, limits)
    if should_change and now - stream.changed > limits.frozen_after:
        return f"frozen for {_seconds(now - stream.changed)}"
    return ""


def _why_stale(
    stream: Stream, silence: float, age: float, limits: StreamLimits
) -> str:
    if silence > 0.5 * limits.expiry:
        return f"nothing came for {_seconds(silence)}"
    if abs(stream.jump) > limits.expiry:
        jump = _seconds(stream.jump)
        return f"its stamps jumped by {jump}: check clocks and network"
    if age < 0:
        return f"stamped {_seconds(-age)} in the future: set the clocks"
    return f"stamped {_seconds(age)} ago"


def _seconds(time: float) -> str:
    return f"{1e3 * time:.0f} ms" if abs(time) < 0.9995 else f"{time:.3g} s"
