"""Detects that a base does not follow its commands, from its displacement.

On ROS, a base that stops by itself does not report the stop. Its measured speed
does not show the stop, either: at 0.05 m/s, the difference between motion and
standstill is less than the lag of a base that accelerates. Its displacement
over some time shows the stop: errors of the speed average out, and at this
speed, a base at rest falls behind by 5 cm per second.

The measured speeds are compared with the measured poses in the same way, to
detect poses that drift.

The base should move as commanded, after a delay. Only an upper limit of the
delay is known. So the motion is compared with the commands for several delays
up to this limit, and the best fit counts. Differences that a delay between two
of these would explain do not count as errors.
"""

import dataclasses as dc
import math

import numpy as np

from remosplat_drake.hardware.client.base_residual_kernel import (
    path_motions,
    path_residuals,
)
from remosplat_drake.hardware.wire.base import extrapolated_pose
from remosplat_drake.hardware.wire.channels import COMMAND_EXPIRY
from remosplat_drake.robot.planar_pose import relative

WINDOWS = np.array([0.4, 2.0])
"""Measured motions of these durations are compared with expected ones [s]. The
short one detects a stop quickly, the long one a slow drift."""

SLACK = np.array([0.008, 0.012])
"""Permitted difference between the two compared motions [m, rad]."""

SHARE = 0.06
"""Permitted difference in addition to `SLACK`, as a fraction of the distance.
Wheels slip, and calibrations have errors.
"""

OWN_DELAY = 0.15
"""A base may report its speeds late by up to this time [s]."""

_OWN_HELD = 0.25
"""A measured speed is assumed to last for at most this time [s]."""

_DELAYS = 6
"""This many delays are tried, from zero to the longest one."""

_CAPACITY = 4096
"""At least this many of the latest commands are stored: 4 s at 1 kHz."""


@dc.dataclass(frozen=True, eq=False)
class ArcPath:
    """A path of circular arcs; each row describes one arc.

    Attributes:
        rows: Time, x, y, yaw, speeds forward and to the left, and turning rate
            at each arc's beginning, shape (k, 7 or more), C-contiguous. Further
            columns are ignored.
        held: A speed is assumed to last for at most this time [s].
    """

    rows: np.ndarray
    held: float

    def motions(self, start: np.ndarray, end: np.ndarray) -> np.ndarray:
        """Returns the motions along the path from n start times to n end times.

        Args:
            start: Times at which the motions begin, shape (n,) [s].
            end: Times at which they end, shape (n,) [s].

        Returns:
            x, y, yaw at the end, relative to the pose at the start, shape (n,
            3) [m, m, rad].
        """
        return path_motions(self.rows, self.held, start, end)

    def residuals(
        self,
        start: np.ndarray,
        end: np.ndarray,
        moved: np.ndarray,
        delay: float,
        share: float = SHARE,
    ) -> tuple[np.ndarray, np.ndarray]:
        """Compares n motions with delayed motions along this path.

        Args:
            start: Times at which the motions began, shape (n,) [s].
            end: Times at which they ended, shape (n,) [s].
            moved: The motions, relative to their starts, shape (n, 3) [m, m,
                rad].
            delay: Longest delay that is tried [s].
            share: Permitted difference, as a fraction of the distance.

        Returns:
            For each motion, the best-fitting motion along this path, shape (n,
            3), and the ratio of their difference to the permitted difference,
            shape (n,).
        """
        late = np.linspace(0.0, delay, _DELAYS)
        return path_residuals(
            self.rows, self.held, start, end, moved, late, SLACK, share
        )


@dc.dataclass(frozen=True)
class BaseSample:
    """Pose and speed of a base by its own odometry, at one time.

    Attributes:
        stamp: Time of measurement, by the base's clock [s].
        received: Time of arrival, by our clock [s].
        pose: x, y, yaw by odometry, shape (3,) [m, m, rad].
        velocity: Speeds forward and to the left, and turning rate, shape (3,)
            [m/s, m/s, rad/s].
        driven: x, y, yaw by integration of the speeds, from (0, 0, 0) at the
            first sample, shape (3,) [m, m, rad].
    """

    stamp: float
    received: float
    pose: np.ndarray
    velocity: np.ndarray
    driven: np.ndarray = dc.field(default_factory=lambda: np.zeros(3))

    def then(
        self,
        stamp: float,
        received: float,
        pose: np.ndarray,
        velocity: np.ndarray,
    ) -> "BaseSample":
        """Returns the next sample.

        Its `driven` is the pose from the speeds, integrated until its stamp.
        """
        held = min(max(stamp - self.stamp, 0.0), _OWN_HELD)
        driven = extrapolated_pose(self.driven, self.velocity, held)
        return BaseSample(stamp, received, pose, velocity, driven)


_POSE, _VELOCITY, _DRIVEN = slice(1, 4), slice(4, 7), slice(8, 11)
_RECEIVED = 7


@dc.dataclass(frozen=True, eq=False)
class BaseSamples:
    """Statuses of a base over the last seconds; the latest sample is the last.

    Attributes:
        rows: Stamp, x, y, yaw, speeds forward and to the left, turning rate,
            time of receipt and `driven` of each sample, shape (k, 11).
    """

    rows: np.ndarray = dc.field(default_factory=lambda: np.zeros((0, 11)))

    def __len__(self) -> int:
        return len(self.rows)

    @property
    def stamp(self) -> np.ndarray:
        """Times of measurement on the base's clock, shape (k,) [s]."""
        return self.rows[:, 0]

    @property
    def received(self) -> np.ndarray:
        """Times of arrival on this computer's clock, shape (k,) [s]."""
        return self.rows[:, _RECEIVED]

    @property
    def pose(self) -> np.ndarray:
        """x, y, yaw by odometry, shape (k, 3) [m, m, rad]."""
        return self.rows[:, _POSE]

    @property
    def driven(self) -> np.ndarray:
        """x, y, yaw by integration of the speeds, shape (k, 3) [m, m, rad]."""
        return self.rows[:, _DRIVEN]

    @property
    def latest(self) -> BaseSample:
        """The latest sample; raises an error if there is none."""
        row = self.rows[-1]
        return BaseSample(
            float(row[0]),
            float(row[_RECEIVED]),
            row[_POSE],
            row[_VELOCITY],
            row[_DRIVEN],
        )

    def with_sample(self, sample: BaseSample) -> "BaseSamples":
        """Returns the samples with a newer one at the end."""
        row = (
            sample.stamp,
            *sample.pose,
            *sample.velocity,
            sample.received,
            *sample.driven,
        )
        return BaseSamples(np.vstack([self.rows, row]))

    def where(self, chosen: np.ndarray | slice) -> "BaseSamples":
        """Returns the chosen samples.

        Args:
            chosen: Mask of the samples to keep, shape (k,), bool; or a slice.
        """
        return BaseSamples(self.rows[chosen])


class CommandedPath:
    """Path of an ideal base that follows its commands without delay.

    Attributes:
        began: When the first command was sent [s]; infinite before.
    """

    def __init__(self):
        """Starts without commands."""
        self.began = math.inf
        self._n = 0
        # Time, x, y, yaw, speeds forward and to the left, turning rate.
        self._rows = np.zeros((2 * _CAPACITY, 7))

    def append(self, time: float, velocity: np.ndarray) -> None:
        """Adds a command.

        Args:
            time: Time at which the command was sent, by our wall clock [s].
            velocity: Speeds forward and to the left, and turning rate, shape
                (3,) [m/s, m/s, rad/s].
        """
        if self._n and time < self._rows[self._n - 1, 0]:
            self.began, self._n = math.inf, 0  # A clock that went back.
        self.began = min(self.began, time)
        if self._n == len(self._rows):
            self._n = _CAPACITY
            self._rows[:_CAPACITY] = self._rows[_CAPACITY:]
        pose = np.zeros(3)
        if self._n:
            before = self._rows[self._n - 1]
            held = min(time - before[0], COMMAND_EXPIRY)
            pose = extrapolated_pose(before[1:4], before[4:], held)
        self._rows[self._n] = time, *pose, *velocity
        self._n += 1

    @property
    def arcs(self) -> ArcPath:
        """The path, on which commands end at the latest when they expire."""
        return ArcPath(self._rows[: self._n], COMMAND_EXPIRY)


def speed_problem(samples: BaseSamples, share: float = SHARE) -> str:
    """Compares a base's poses with the integral of its measured speeds.

    Speeds are reported late, so the integral is compared with delayed poses.

    Args:
        samples: The measured poses and speeds of the base.
        share: Permitted difference, as a fraction of the distance.

    Returns:
        A description of the difference; empty if they agree.
    """
    found = _compared(
        ArcPath(samples.rows, _OWN_HELD),
        samples.stamp,
        samples.driven,
        # Earlier poses are unknown.
        samples.stamp[0] + OWN_DELAY,
        OWN_DELAY,
        share,
    )
    if not found:
        return ""
    driven, moved, seconds = found
    return (
        f"it moved by {moved} in {seconds:.1f} s; its speeds amount to {driven}"
    )


def follow_problem(
    commanded: CommandedPath,
    samples: BaseSamples,
    delay: float,
    share: float = SHARE,
) -> str:
    """Describes how a base deviates from its commands; empty if it does not.

    Args:
        commanded: Its commands.
        samples: The measured poses and speeds of the base.
        delay: Longest time from a command to its effect in the odometry [s].
        share: Permitted difference, as a fraction of the distance.
    """
    found = _compared(
        commanded.arcs,
        samples.stamp,
        samples.pose,
        # Before this program's first command, other programs may have moved it.
        commanded.began,
        delay,
        share,
    )
    if not found:
        return ""
    moved, told, seconds = found
    return (
        f"it moved by {moved} in {seconds:.1f} s; its commands amount to {told}"
    )


def _compared(
    path: ArcPath,
    stamp: np.ndarray,
    poses: np.ndarray,
    began: float,
    delay: float,
    share: float,
) -> tuple[str, str, float] | tuple[()]:
    """Finds motions that differ from the expected ones.

    Args:
        path: The expected path, which the base follows with a delay.
        stamp: Times of the measured poses, ascending, shape (k,) [s].
        poses: The measured poses, shape (k, 3) [m, m, rad].
        began: Time since which the expected path is known [s].
        delay: Longest delay [s].
        share: Permitted difference, as a fraction of the distance.

    Returns:
        Descriptions of the measured and of the expected motion, and their
        duration [s]; empty if they agree.
    """
    since = np.maximum(stamp[-1] - WINDOWS, began)
    first = np.searchsorted(stamp, since, "right")
    if first.max() >= len(stamp) - 1:
        return ()
    start, end = stamp[first], np.full(len(first), stamp[-1])
    moved = np.array([relative(poses[i], poses[-1]) for i in first])
    meant, excess = path.residuals(start, end, moved, delay, share)
    wrong = np.flatnonzero(~(excess <= 1.0))
    if not len(wrong):
        return ()
    i = wrong[0]
    return _words(moved[i]), _words(meant[i]), float(end[i] - start[i])


def _words(motion: np.ndarray) -> str:
    length, angle = math.hypot(motion[0], motion[1]), abs(motion[2])
    return f"{1e3 * length:.0f} mm and {math.degrees(angle):.1f} deg"
