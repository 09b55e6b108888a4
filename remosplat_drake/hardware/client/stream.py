"""Judges streams of stamped messages: fresh, frozen, late or broken."""

import dataclasses as dc
import math


@dc.dataclass(frozen=True)
class Stream:
    """The history of one status channel, in a few numbers.

    Attributes:
        stamp: Stamp of the latest good message, by the sender's wall clock
            [s].
        received: When the latest message came, by our wall clock [s].
        jump: How far the sender's clock was set, by the latest message that
            showed it [s]; 0 if it was never set.
        changed: When the content of a message last differed from the one
            before, by our wall clock [s].
        broken: Faults of the latest message; empty if nothing is.
    """

    stamp: float = -math.inf
    received: float = -math.inf
    jump: float = 0.0
    changed: float = -math.inf
    broken: str = ""


@dc.dataclass(frozen=True)
class StreamLimits:
    """When a stream of messages is no longer to be trusted.

    Attributes:
        expiry: Difference from our clock, into the past or the future, at
            which a stamp is stale [s].
        frozen_after: How long the content may stay the same while it should
            be changing [s].
    """

    expiry: float
    frozen_after: float


def advanced(
    stream: Stream, stamp: float, received: float, changed: bool, expiry: float
) -> Stream:
    """Returns a stream's history after another good message.

    A clock that was set shows as stamps that advance by another amount than
    the time between their arrivals.

    Args:
        stream: The history so far.
        stamp: Stamp of the new message, by the sender's wall clock [s].
        received: When it came, by our wall clock [s].
        changed: Whether its content differs from that of the message before.
        expiry: Size from which on a jump of the clock is noted [s].
    """
    first = math.isinf(stream.stamp)
    jump = (stamp - stream.stamp) - (received - stream.received)
    return Stream(
        stamp=stamp,
        received=received,
        jump=stream.jump if first or not abs(jump) > expiry else jump,
        changed=received if changed or first else stream.changed,
    )


def broken(stream: Stream, received: float, problem: str) -> Stream:
    """Returns a stream's history after a message that cannot be used.

    Args:
        stream: The history so far.
        received: When the message came, by our wall clock [s].
        problem: Faults of it.
    """
    return dc.replace(stream, received=received, broken=problem)


def stream_problem(
    stream: Stream, now: float, limits: StreamLimits, should_change: bool
) -> str:
    """Describes the fault of a stream in a few words; empty if there is none.

    Args:
        stream: The stream's history.
        now: Our wall clock [s].
        limits: When a stream is stale or frozen.
        should_change: Whether the content should be changing by now, because
            the robot was commanded to move.
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
        return f"its stamps jumped by {jump}: a clock, or the network's delay"
    if age < 0:
        return f"stamped {_seconds(-age)} in the future: set the clocks"
    return f"stamped {_seconds(age)} ago"


def _seconds(time: float) -> str:
    return f"{1e3 * time:.0f} ms" if abs(time) < 0.9995 else f"{time:.3g} s"
