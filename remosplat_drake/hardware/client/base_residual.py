"""Detects a base that does not follow its commands, by its displacement.

A base that stops by itself does not say so on ROS. Its speed tells little: at
0.05 m/s it differs from a standstill by less than it does from its command
while the base speeds up. Its displacement over a while tells much: the errors
of speed even out, and a base that stands falls behind by 5 cm a second.

Its measured speeds are compared with its pose in the same way, which detects a
pose that drifts.

Its expected motion is that of the commands, some delay ago. That delay is known
roughly: the delay counts, of all up to the longest, with which the motion fits
best, and differences between neighbouring delays are not errors.
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
"""Times over which motions are compared [s]: a short one sees a stop at once, a
long one a slow drift."""

SLACK = np.array([0.008, 0.012])
"""How far a motion may differ from the commanded one [m, rad]."""

SHARE = 0.06
"""Further permitted error, as a share of the distance driven: wheels slip, and
no base is calibrated perfectly."""

OWN_DELAY = 0.15
"""Longest delay of a base's reported speeds [s]."""

_OWN_HELD = 0.25
"""Longest time for which a measured speed replaces the next ones [s]."""

_DELAYS = 6
"""Number of delays that are tried, from none to the longest."""

_CAPACITY = 4096
"""Number of commands that are remembered: 4 s at 1 kHz."""


@dc.dataclass(frozen=True, eq=False)
class ArcPath:
    """A path that is made of arcs, one for each row.

    Attributes:
        rows: Time, x, y, yaw, speeds forward and to the left and turning rate
            at each arc's beginning, and further columns, shape (k, 7 or more),
            C-contiguous.
        held: Longest time for which a speed counts [s].
    """

    rows: np.ndarray
    held: float

    def motions(self, start: np.ndarray, end: np.ndarray) -> np.ndarray:
        """Returns motions between pairs of times, by their own axes.

        Args:
            start: Times at which the motions begin, shape (n,) [s].
            end: Times at which they end, shape (n,) [s].

        Returns:
            x, y, yaw at the end as seen from the start, shape (n, 3)
            [m, m, rad].
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
        """Compares n motions with those along this path, which is delayed.

        Args:
            start: Times at which the motions began, shape (n,) [s].
            end: Times at which they ended, shape (n,) [s].
            moved: The motions, by their own axes, shape (n, 3) [m, m, rad].
            delay: Longest delay of this path [s].
            share: Share of its way by which a motion may differ.

        Returns:
            The motion along this path that fits each best, shape (n, 3), and
            its error, relative to the permitted one, shape (n,).
        """
        late = np.linspace(0.0, delay, _DELAYS)
        return path_residuals(
            self.rows, self.held, start, end, moved, late, SLACK, share
        )


@dc.dataclass(frozen=True)
class BaseSample:
    """Pose of a base by its own odometry.

    Attributes:
        stamp: When, by the base's clock [s].
        received: Time of arrival, by our clock [s].
        pose: x, y, yaw by odometry, shape (3,) [m, m, rad].
        velocity: Speeds forward and to the left, and turning rate, shape (3,)
            [m/s, m/s, rad/s].
        driven: x, y, yaw by the speeds alone, from (0, 0, 0) at the first
            sample, shape (3,) [m, m, rad].
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
        """Returns the next sample; the arguments are its attributes."""
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
        """When the base was there, by its clock, shape (k,) [s]."""
        return self.rows[:, 0]

    @property
    def received(self) -> np.ndarray:
        """Time of arrival, by our clock, shape (k,) [s]."""
        return self.rows[:, _RECEIVED]

    @property
    def pose(self) -> np.ndarray:
        """x, y, yaw by odometry, shape (k, 3) [m, m, rad]."""
        return self.rows[:, _POSE]

    @property
    def driven(self) -> np.ndarray:
        """x, y, yaw by the speeds alone, shape (k, 3) [m, m, rad]."""
        return self.rows[:, _DRIVEN]

    @property
    def latest(self) -> BaseSample:
        """The latest sample, of which there must be one."""
        row = self.rows[-1]
        return BaseSample(
            float(row[0]),
            float(row[_RECEIVED]),
            row[_POSE],
            row[_VELOCITY],
            row[_DRIVEN],
        )

    def with_sample(self, sample: BaseSample) -> "BaseSamples":
        """Adds a sample."""
        row = (
            sample.stamp,
            *sample.pose,
            *sample.velocity,
            sample.received,
            *sample.driven,
        )
        return BaseSamples(np.vstack([self.rows, row]))

    def where(self, chosen: np.ndarray | slice) -> "BaseSamples":
        """Keeps some of the samples.

        Args:
            chosen: Which, shape (k,), bool; or a slice.
        """
        return BaseSamples(self.rows[chosen])


class CommandedPath:
    """Pose of a base that follows its commands at once, from (0, 0, 0).

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
            time: When it was sent, by our wall clock [s].
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
        """The path; a command counts no longer than drivers let it."""
        return ArcPath(self._rows[: self._n], COMMAND_EXPIRY)


def speed_problem(samples: BaseSamples, share: float = SHARE) -> str:
    """Says that a base's pose is not where its own speeds put it.

    Speeds are reported late, so the poses are delayed here.

    Args:
        samples: Where it was.
        share: Share of its way by which a motion may differ.

    Returns:
        In words; empty if it is.
    """
    found = _compared(
        ArcPath(samples.rows, _OWN_HELD),
        samples.stamp,
        samples.driven,
        # Of earlier poses nothing is known.
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
    """Says that a base does not follow its commands; empty if it does.

    Args:
        commanded: Its commands.
        samples: Where it was.
        delay: Longest time from a command to its effect in the odometry [s].
        share: Share of its way by which a motion may differ.
    """
    found = _compared(
        commanded.arcs,
        samples.stamp,
        samples.pose,
        # The first command follows those of other programs.
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
        path: Where the base should have been, delayed.
        stamp: When it was somewhere, ascending, shape (k,) [s].
        poses: Where it was, shape (k, 3) [m, m, rad].
        began: Since when that is known [s].
        delay: Longest delay [s].
        share: Share of its way by which a motion may differ.

    Returns:
        The motion, and that which should be, in words, and how long it took
        [s]; empty if they agree.
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
