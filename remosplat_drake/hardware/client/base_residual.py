"""Whether a base does what it is told, by how far it came.

A base that stops by itself does not say so on ROS. Its speed tells little: at
0.05 m/s it differs from a standstill by less than it does from its command
while the base speeds up. How far it came over a while tells much: the errors of
speed even out, and a base that stands falls behind by 5 cm a second.

The same goes for the speeds that the base measures itself: a pose that drifts
leaves them behind.

What it should have done is what it was told, some delay ago. That delay is
known roughly: of all delays up to the longest the one counts with which the
motion fits best, and what neighbouring delays differ by is no error.
"""

import dataclasses as dc
import math
from bisect import bisect_right
from collections.abc import Callable, Sequence

import numpy as np

from remosplat_drake.hardware.wire.base import extrapolated_pose
from remosplat_drake.hardware.wire.channels import COMMAND_EXPIRY

WINDOWS = (0.4, 2.0)
"""Times over which motions are compared [s]: a short one sees a stop at once, a
long one a slow drift."""

SLACK = np.array([0.008, 0.012])
"""How far a motion may differ from the commanded one [m, rad]."""

SHARE = 0.06
"""Share of its way by which a motion may differ besides: wheels slip, and no
base is calibrated perfectly."""

OWN_DELAY = 0.15
"""Longest time by which a base tells its speeds late [s]."""

_OWN_HELD = 0.25
"""Longest time for which a measured speed stands for the next ones [s]."""

Motions = Callable[[np.ndarray, np.ndarray], np.ndarray]
"""Motions between pairs of times, as `CommandedPath.motions` has them."""

_DELAYS = 6
"""Number of delays that are tried, from none to the longest."""

_CAPACITY = 4096
"""Number of commands that are remembered: 4 s at 1 kHz."""


@dc.dataclass(frozen=True)
class BaseSample:
    """Where a base was by its own account.

    Attributes:
        stamp: When, by the base's clock [s].
        received: When it was heard, by ours [s].
        pose: x, y, yaw by odometry, shape (3,) [m, m, rad].
        velocity: Speed forward and turning rate, shape (2,) [m/s, rad/s].
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


class CommandedPath:
    """Where a base would be that follows its commands at once, from (0, 0, 0).

    Attributes:
        began: When the first command was sent [s]; infinite before.
    """

    def __init__(self):
        """Starts without commands."""
        self.began = math.inf
        self._n = 0
        # Time, x, y, yaw, speed forward, turning rate.
        self._rows = np.zeros((2 * _CAPACITY, 6))

    def append(self, time: float, u: np.ndarray) -> None:
        """Adds a command.

        Args:
            time: When it was sent, by our wall clock [s].
            u: Speed forward and turning rate, shape (2,) [m/s, rad/s].
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
        self._rows[self._n] = time, *pose, *u
        self._n += 1

    def motions(self, start: np.ndarray, end: np.ndarray) -> np.ndarray:
        """Returns motions between pairs of times, by their own axes.

        A command counts until the next one, and no longer than drivers let it.

        Args:
            start: Times at which the motions begin, shape (...) [s].
            end: Times at which they end, shape (...) [s].

        Returns:
            x, y, yaw at the end as seen from the start, shape (..., 3)
            [m, m, rad].
        """
        return _motions(self._rows[: self._n], start, end, COMMAND_EXPIRY)


def speed_problem(samples: Sequence[BaseSample], share: float = SHARE) -> str:
    """Says that a base's pose is not where its own speeds put it.

    Speeds are told late, so that it is the poses that are delayed here.

    Args:
        samples: Where it was, the latest last.
        share: Share of its way by which a motion may differ.

    Returns:
        In words; empty if it is.
    """
    rows = np.array([(s.stamp, *s.pose, *s.velocity) for s in samples])
    found = _compared(
        lambda start, end: _motions(rows, start, end, _OWN_HELD),
        samples,
        np.array([sample.driven for sample in samples]),
        # Of earlier poses nothing is known.
        samples[0].stamp + OWN_DELAY,
        OWN_DELAY,
        share,
    )
    if not found:
        return ""
    driven, moved, seconds = found
    return (
        f"it moved by {moved} in {seconds:.1f} s, not by {driven} by its speeds"
    )


def follow_problem(
    commanded: CommandedPath,
    samples: Sequence[BaseSample],
    delay: float,
    share: float = SHARE,
) -> str:
    """Says that a base does not do what it is told; empty if it does.

    Args:
        commanded: What it was told.
        samples: Where it was, the latest last.
        delay: Longest time from a command to its effect in the odometry [s].
        share: Share of its way by which a motion may differ.
    """
    # The first command follows whatever others had the base do.
    poses = np.array([sample.pose for sample in samples])
    found = _compared(
        commanded.motions, samples, poses, commanded.began, delay, share
    )
    if not found:
        return ""
    moved, told, seconds = found
    return (
        f"it moved by {moved} in {seconds:.1f} s, not by {told} by its commands"
    )


def _compared(
    motions: Motions,
    samples: Sequence[BaseSample],
    poses: np.ndarray,
    began: float,
    delay: float,
    share: float,
) -> tuple[str, str, float] | tuple[()]:
    """Finds motions that differ from what they should be.

    Args:
        motions: The motions that should be, delayed.
        samples: When the base was somewhere, the latest last, length k.
        poses: Where it was, shape (k, 3) [m, m, rad].
        began: Since when that is known [s].
        delay: Longest delay [s].
        share: Share of its way by which a motion may differ.

    Returns:
        The motion, and that which should be, in words, and how long it took
        [s]; empty if they agree.
    """
    latest = samples[-1]
    since = [max(latest.stamp - window, began) for window in WINDOWS]
    first = [bisect_right(samples, t, key=lambda s: s.stamp) for t in since]
    if max(first) >= len(samples) - 1:
        return ()
    start = np.array([samples[i].stamp for i in first])
    moved = _relative(poses[first], poses[-1])
    meant, excess = residuals(motions, start, latest.stamp, moved, delay, share)
    wrong = np.flatnonzero(~(excess <= 1.0))
    if not len(wrong):
        return ()
    i = wrong[0]
    seconds = float(latest.stamp - start[i])
    return _words(moved[i]), _words(meant[i]), seconds


def residuals(
    motions: Motions,
    start: np.ndarray,
    end: np.ndarray | float,
    moved: np.ndarray,
    delay: float,
    share: float = SHARE,
) -> tuple[np.ndarray, np.ndarray]:
    """Compares n motions of a base with those that should be.

    Args:
        motions: The motions that should be, between pairs of times.
        start: Times at which the motions began, shape (n,) [s].
        end: Times at which they ended, shape (n,) or one for all [s].
        moved: The motions, by their own axes, shape (n, 3) [m, m, rad].
        delay: Longest delay of what should be [s].
        share: Share of its way by which a motion may differ.

    Returns:
        The motion that should be and fits each best, shape (n, 3), and how far
        it differs, relative to what is allowed, shape (n,).
    """
    late = np.linspace(0.0, delay, _DELAYS)
    ends = np.broadcast_to(end, start.shape)[:, None] - late
    told = motions(start[:, None] - late, ends)
    error = _size(_relative(told, moved[:, None]))
    spread = 0.5 * _size(_relative(told[:, :-1], told[:, 1:])).max(axis=1)
    way = np.maximum(_size(told).max(axis=1), _size(moved))
    allowed = SLACK + share * way + spread
    # A heading that is off swings the way.
    allowed[:, 0] += 0.5 * allowed[:, 1] * way[:, 0]
    excess = (error / allowed[:, None]).max(axis=2)
    best = excess.argmin(axis=1)
    each = np.arange(len(best))
    return told[each, best], excess[each, best]


def _motions(
    rows: np.ndarray, start: np.ndarray, end: np.ndarray, held: float
) -> np.ndarray:
    """Motions between times along a path of arcs, shape (..., 3).

    Args:
        rows: Time, x, y, yaw, speed forward and turning rate at each arc's
            beginning, shape (k, 6).
        start: Times at which the motions begin, shape (...) [s].
        end: Times at which they end, shape (...) [s].
        held: Longest time for which a speed counts [s].
    """
    time = np.stack([start, end])
    i = np.searchsorted(rows[:, 0], time, "right") - 1
    before = rows[np.maximum(i, 0)]
    late = np.clip(time - before[..., 0], 0.0, held)
    return _relative(*_extrapolated(before[..., 1:4], before[..., 4:], late))


def _extrapolated(
    pose: np.ndarray, u: np.ndarray, duration: np.ndarray
) -> np.ndarray:
    """`extrapolated_pose` for many poses, shape (..., 3)."""
    half = 0.5 * u[..., 1] * duration
    chord = u[..., 0] * duration * np.sinc(half / np.pi)
    yaw = pose[..., 2] + half
    return pose + np.stack(
        [chord * np.cos(yaw), chord * np.sin(yaw), 2 * half], axis=-1
    )


def _relative(X_AB: np.ndarray, X_AC: np.ndarray) -> np.ndarray:
    """`planar_pose.relative` for many poses, shape (..., 3)."""
    x, y, yaw = np.moveaxis(X_AC - X_AB, -1, 0)
    c, s = np.cos(X_AB[..., 2]), np.sin(X_AB[..., 2])
    yaw = (yaw + np.pi) % (2 * np.pi) - np.pi
    return np.stack([c * x + s * y, c * y - s * x, yaw], axis=-1)


def _size(motion: np.ndarray) -> np.ndarray:
    """Lengths and angles of motions, shape (..., 2) [m, rad]."""
    length = np.hypot(motion[..., 0], motion[..., 1])
    return np.stack([length, np.abs(motion[..., 2])], axis=-1)


def _words(motion: np.ndarray) -> str:
    length, angle = _size(motion)
    return f"{1e3 * length:.0f} mm and {math.degrees(angle):.1f} deg"
