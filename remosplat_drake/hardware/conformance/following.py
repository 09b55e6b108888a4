"""Measures how the axes of a part follow their commands.

The actuator model in the robot's description predicts a motion from the
commands. The measured motion is compared with this prediction, for several
delays that are added to the delay of the model.
"""

import dataclasses as dc
from collections.abc import Sequence

import numpy as np

from remosplat_drake.hardware.conformance.robot_record import PartRecord
from remosplat_drake.robot.actuators import Actuator

_GRID = 0.002
"""The actuator models are simulated in steps of this length [s]."""

_DELAYS = np.arange(-0.1, 0.4, 0.005)
"""Measured and modelled motions are compared with each of these delays, in
addition to the model's own delay [s].
"""

_WINDOW = 0.1
"""Motions of this duration are compared [s]. It is short, since drift and times
at rest contain no information.
"""

MOVED = 0.02
"""An axis is evaluated if its commanded motion is larger than this [rad, m]."""

_HELD = 0.1
"""A command is valid for at most this time, as in the drivers [s]."""


@dc.dataclass(frozen=True, eq=False)
class Following:
    """Result of the comparison of n axes with their commands.

    Attributes:
        moved: Mask of the axes with enough commanded motion for an evaluation,
            shape (n,).
        gains: Motion of axis i per commanded motion of axis j, shape (n, n);
            zero if axis j was not evaluated.
        late: Delay of each axis in addition to the delay in its model, shape
            (n,) [s].
        velocity: Ratio of each axis' reported velocity to the change of its
            position per time, shape (n,); NaN if the axis has not moved.
    """

    moved: np.ndarray
    gains: np.ndarray
    late: np.ndarray
    velocity: np.ndarray


def examine(part: PartRecord, actuators: Sequence[Actuator]) -> Following:
    """Compares a part's motion with its commands.

    Args:
        part: Messages of the part.
        actuators: Actuator models of the part's axes, in the order of the axes.
    """
    n = len(part.axes)
    gains, late = np.zeros((n, n)), np.full(n, np.nan)
    velocity = np.full(n, np.nan)
    if not len(part.sent) or len(part.stamp) < 2:
        return Following(np.zeros(n, bool), gains, late, velocity)
    time, way = _model(part, actuators)
    stamp, first = np.unique(part.stamp, return_index=True)
    moved = np.ptp(way, axis=0) > MOVED
    columns = np.flatnonzero(moved)
    ends = stamp[(stamp > time[0] + _WINDOW) & (stamp < time[-1])]
    if not len(columns) or not len(ends):
        return Following(np.zeros(n, bool), gains, late, velocity)

    def steps(t: np.ndarray, ways: np.ndarray, axis: int, delay: float):
        at = ends - delay
        values = np.interp(at, t, ways[:, axis])
        return values - np.interp(at - _WINDOW, t, ways[:, axis])

    measured = part.way[first]
    told = [
        np.column_stack([steps(time, way, int(j), delay) for j in columns])
        for delay in _DELAYS
    ]
    for i in range(n):
        came = steps(stamp, measured, i, 0.0)
        fits = [np.linalg.lstsq(A, came, rcond=None)[0] for A in told]
        errors = [
            float(np.square(A @ x - came).sum())
            for A, x in zip(told, fits, strict=True)
        ]
        best = int(np.argmin(errors))
        gains[i, columns] = fits[best]
        late[i] = _DELAYS[best]
        velocity[i] = _velocity_share(stamp, measured[:, i], part.v[first, i])
    return Following(moved, gains, late, velocity)


def commanded_ways(part: PartRecord) -> np.ndarray:
    """Integrates a part's commands, without a model of its actuators.

    Args:
        part: Messages of the part.

    Returns:
        Positions at the ends of all commands except the latest, which has not
        ended, relative to the start, shape (c - 1, n) [rad, m].
    """
    held = np.minimum(np.diff(part.sent), _HELD)
    return np.cumsum(held[:, None] * part.u[:-1], axis=0)


def _model(
    part: PartRecord, actuators: Sequence[Actuator]
) -> tuple[np.ndarray, np.ndarray]:
    """Predicts a part's motion from its commands, by the actuator models.

    Returns:
        Times, shape (m,) [s], and positions relative to the first, shape (m,
        n).
    """
    time = np.arange(part.sent[0], part.sent[-1] + 1.0, _GRID)
    way = np.zeros((len(time), len(part.axes)))
    for axis, actuator in enumerate(actuators):
        at = time - actuator.delay
        row = np.searchsorted(part.sent, at, "right") - 1
        target = np.where(row >= 0, part.u[np.maximum(row, 0), axis], 0.0)
        expired = at - part.sent[np.maximum(row, 0)] > _HELD
        target[expired] = 0.0
        v = s = 0.0
        for k, goal in enumerate(target.tolist()):
            v, step = actuator.step(v, goal, _GRID)
            s += step
            way[k, axis] = s
    return time, way


def _velocity_share(stamp: np.ndarray, way: np.ndarray, v: np.ndarray) -> float:
    """Ratio of reported velocity to measured velocity; NaN at rest.

    The ratio is fitted by least squares over the whole motion.
    """
    mean = 0.5 * (v[1:] + v[:-1])
    step = np.diff(stamp)
    by_way = np.diff(way) / step
    moving = float(step @ np.square(by_way))
    return float(step @ (mean * by_way)) / moving if moving > 1e-6 else np.nan
