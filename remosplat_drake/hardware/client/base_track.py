"""`BaseTrack`: a base's recent poses, and faults of their measurement.

Measurements of the base's pose may be wrong in several ways. Odometry jumps
when a program corrects it, a clock may be wrong, wheels may spin, and a bridge
to ROS may not report that the base has stopped. The messages of the last
seconds show each of these faults.
"""

import dataclasses as dc
import math

import numpy as np

from remosplat_drake.hardware.client.base_filter import (
    BaseFilter,
    doubted,
    with_fix,
    with_odometry,
)
from remosplat_drake.hardware.client.base_residual import (
    WINDOWS,
    BaseSample,
    BaseSamples,
    CommandedPath,
    follow_problem,
    speed_problem,
)
from remosplat_drake.hardware.client.stream import Stream, advanced, broken
from remosplat_drake.hardware.hardware_config import HardwareConfig
from remosplat_drake.hardware.wire.base import BaseState, extrapolated_pose
from remosplat_drake.hardware.wire.localization import decode_localization
from remosplat_drake.hardware.wire.messages.base_status import base_status
from remosplat_drake.hardware.wire.packets import BrokenMessage
from remosplat_drake.robot.planar_pose import (
    composed,
    odometry_frame,
    relative,
)

_KEPT = WINDOWS.max() + 0.5
"""Samples older than this are removed [s]."""

_SPACING = 0.015
"""Least time between two samples that are kept [s]."""

_LATENCY_SPAN = 0.2
"""The base's latency is the least delay among the statuses that arrived within
this time [s]."""

_STEP = np.array([0.015, 0.03])
"""Permitted difference between a measured pose and its prediction from the
previous pose and the speed [m, rad]."""

_STEP_RATE = np.array([0.15, 0.4])
"""The permitted difference increases by this much per second of prediction,
since speeds are reported late [m/s, rad/s]."""

CERTAIN = np.zeros(2)
"""Error bounds of the pose if there is no localisation [m, rad]: odometry is
then assumed to be exact.
"""


_CLOCK_STEP = 0.1
"""If the delays of two consecutive statuses differ by more than this time [s],
a clock was set, or the network stalled.
"""


@dc.dataclass(frozen=True, eq=False)
class BaseTrack:
    """The base's recent statuses and their faults; a copy is the object itself.

    Attributes:
        samples: The statuses of the last seconds.
        jumped: Pose of the odometry's frame after all jumps, relative to the
            frame of the first status, shape (3,) [m, m, rad].
        disobeys: Description of the difference between the base's motion and
            its commands or its measured speeds; empty if there is none.
        filter: The fusion of odometry and localisation; None without a
            localisation.
        fixes: Timing and faults of the localisation's channel.
    """

    samples: BaseSamples = dc.field(default_factory=BaseSamples)
    jumped: np.ndarray = dc.field(default_factory=lambda: np.zeros(3))
    disobeys: str = ""
    filter: BaseFilter | None = None
    fixes: Stream = dc.field(default_factory=Stream)

    def __deepcopy__(self, memo) -> "BaseTrack":
        return self

    @property
    def latency(self) -> float:
        """Least age of the latest statuses on arrival [s].

        It includes the difference between the base's clock and this computer's
        clock, which cannot be measured separately.
        """
        received = self.samples.received
        recent = received >= received[-1] - _LATENCY_SPAN
        late = (received - self.samples.stamp)[recent]
        return float(late[np.abs(late).argmin()])

    def pose(self, X_OB: np.ndarray) -> np.ndarray:
        """Converts a pose X_OB by odometry to x, y, yaw in W, shape (3,)."""
        return X_OB if self.filter is None else self.filter.pose(X_OB)

    @property
    def uncertainty(self) -> np.ndarray:
        """Bound on the error of the pose in W: shift and turn, (2,) [m, rad].

        It applies to the latest pose at the time of its stamp. It grows with
        the latency, since the time of a pose is uncertain if its stamp may be
        late.
        """
        bound = CERTAIN if self.filter is None else self.filter.uncertainty
        if not len(self.samples):
            return bound
        return bound + abs(self.latency) * _speeds(self.samples)


def compile_kernels(config: HardwareConfig) -> None:
    """Compiles the kernels that process a base's statuses.

    Args:
        config: The settings that the track will use.
    """
    track, commanded = BaseTrack(), CommandedPath()
    commanded.append(0.0, np.zeros(3))
    for stamp in np.arange(0.0, 1.0, 0.1).tolist():
        pose, velocity = np.zeros(3), np.zeros(3)
        state = BaseState(
            pose, velocity, stamp, base_status.READY, False, False, 1.0
        )
        track = with_base_sample(track, state, stamp, commanded, config)


def with_base_sample(
    track: BaseTrack,
    state: BaseState,
    received: float,
    commanded: CommandedPath | None,
    config: HardwareConfig,
) -> BaseTrack:
    """Returns the track after a status of the base.

    Args:
        track: The previous track.
        state: The status.
        received: Time of its arrival, by our wall clock [s].
        commanded: The commands that were sent to the base; None if they are
            unknown.
        config: Settings, with the longest delay of commands and the accuracy of
            fixes.
    """
    values = state.stamp, received, state.pose, state.velocity
    sample, expected, begins_anew = BaseSample(*values), state.pose, False
    if len(track.samples):
        before = track.samples.latest
        sample = before.then(*values)
        expected = _expected(before, sample)
        silence = sample.stamp - before.stamp
        begins_anew = silence > config.base_status_expiry or _sets_its_clock(
            before, sample
        )
    off = relative(expected, state.pose)
    jumped = composed(odometry_frame(state.pose, expected), track.jumped)
    samples = _kept(track.samples, sample.stamp)
    if off.any() or begins_anew:
        # A jump does not mean that the base ignores its commands. Without
        # messages, the base's speed is unknown.
        samples = BaseSamples()
    samples = samples.with_sample(sample)
    share = config.base_share
    disobeys = speed_problem(samples, share)
    if commanded is not None:
        disobeys = (
            follow_problem(commanded, samples, config.base_delay, share)
            or disobeys
        )
    fusion = track.filter
    if fusion is None and config.localization is not None:
        fusion = BaseFilter(config.localization)
    if fusion is not None:
        fusion = with_odometry(fusion, state.stamp, state.pose)
        fusion = doubted(fusion, *_sizes(off)) if off.any() else fusion
    return dc.replace(
        track,
        samples=samples,
        jumped=jumped,
        disobeys=disobeys,
        filter=fusion,
    )


def with_localization(
    track: BaseTrack, data: bytes, received: float
) -> BaseTrack:
    """Returns the track after a packet of the base's localisation.

    Args:
        track: The previous track; without odometry the packet is ignored.
        data: The encoded packet.
        received: Time of its arrival, by our wall clock [s].
    """
    if track.filter is None:
        return track
    try:
        fix = decode_localization(data)
    except BrokenMessage as error:
        return dc.replace(
            track, fixes=broken(track.fixes, received, str(error))
        )
    fusion = with_fix(track.filter, fix)
    fixes = advanced(track.fixes, fix.stamp, received, True, math.inf)
    return dc.replace(track, filter=fusion, fixes=fixes)


def track_problem(track: BaseTrack, config: HardwareConfig) -> str:
    """Returns the reason why the base's pose is unreliable, or "".

    Args:
        track: The base's track.
        config: Settings, with the limits of age and uncertainty.
    """
    status, fixes = config.channels.base_status, config.channels.localization
    if not len(track.samples):
        return ""
    if not abs(track.latency) <= config.base_latency:
        late = 1e3 * track.latency
        kind = "before it comes" if late > 0 else "in the future"
        return f"{status}: stamped {abs(late):.0f} ms {kind}: set the clocks"
    X_OB = track.samples.latest.pose
    shift, turn = _sizes(relative(relative(track.jumped, X_OB), X_OB))
    is_far = shift > _STEP[0] or turn > _STEP[1]
    if track.filter is None and is_far:
        return (
            f"the base's pose jumped by {1e3 * shift:.0f} mm and"
            f" {np.degrees(turn):.1f} deg, and has not come back"
        )
    if track.disobeys:
        return f"the base does not move as it should: {track.disobeys}"
    if track.filter is None or config.localization is None:
        return ""
    problem = _fix_problem(track, track.filter)
    return f"{fixes}: {problem}" if problem else _doubt(track)


def _fix_problem(track: BaseTrack, fusion: BaseFilter) -> str:
    """Returns the fault of the localisation; empty if there is none."""
    if fusion.refusal:
        return fusion.refusal
    if track.fixes.broken:
        return track.fixes.broken
    if math.isinf(track.fixes.received):
        return "nothing came yet"
    silence = track.samples.latest.stamp - fusion.fixed
    if not silence <= fusion.config.expiry:
        return f"nothing new came for {silence:.2g} s"
    return ""


def _doubt(track: BaseTrack) -> str:
    """Returns a reason to stop if the pose is too uncertain, or ""."""
    assert track.filter is not None
    config, (shift, turn) = track.filter.config, track.uncertainty
    if shift <= config.max_shift and turn <= config.max_turn:
        return ""
    return (
        f"the base's position is uncertain by {1e3 * shift:.0f} mm and"
        f" {np.degrees(turn):.1f} deg: at most {1e3 * config.max_shift:.0f} mm"
        f" and {np.degrees(config.max_turn):.1f} deg are allowed"
    )


def _speeds(samples: BaseSamples) -> np.ndarray:
    """Speed and turning rate of the base, shape (2,) [m/s, rad/s].

    Measured speeds may be late, for example while the base starts, so the
    motion between the latest two poses counts, too.
    """
    forward, left, turn = samples.latest.velocity
    measured = np.array([math.hypot(forward, left), abs(turn)])
    if len(samples) == 1:
        return measured
    motion = relative(samples.pose[-2], samples.pose[-1])
    seconds = samples.stamp[-1] - samples.stamp[-2]
    return np.maximum(measured, _sizes(motion) / seconds)


def _kept(samples: BaseSamples, stamp: float) -> BaseSamples:
    """Removes old samples, and the last one if it soon follows another.

    Args:
        samples: The samples before.
        stamp: Stamp of the next sample [s].
    """
    age = stamp - samples.stamp
    kept = samples.where((age > 0) & (age <= _KEPT))
    close = len(kept) > 1 and kept.stamp[-1] - kept.stamp[-2] < _SPACING
    return kept.where(slice(-1)) if close else kept


def _expected(before: BaseSample, after: BaseSample) -> np.ndarray:
    """Predicts a pose from the previous one, shape (3,).

    Returns the measured pose if noise and a change of speed explain its
    difference from the prediction.
    """
    seconds = max(after.stamp - before.stamp, 0.0)
    velocity = 0.5 * (before.velocity + after.velocity)
    expected = extrapolated_pose(before.pose, velocity, seconds)
    off = _sizes(relative(expected, after.pose))
    is_near = (off <= _STEP + _STEP_RATE * seconds).all()
    return after.pose if is_near else expected


def _sets_its_clock(before: BaseSample, after: BaseSample) -> bool:
    """Whether stamps and times of arrival advance by different amounts."""
    passed = after.received - before.received
    return abs(after.stamp - before.stamp - passed) > _CLOCK_STEP


def _sizes(motion: np.ndarray) -> np.ndarray:
    """Length and angle of a motion, shape (2,) [m, rad]."""
    turn = (motion[2] + np.pi) % (2 * np.pi) - np.pi
    return np.array([math.hypot(motion[0], motion[1]), abs(turn)])
