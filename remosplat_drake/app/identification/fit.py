"""Fits an actuator model to a recording, and bounds its error."""

import dataclasses as dc
import itertools
from collections.abc import Callable, Sequence

import numpy as np
from scipy.optimize import minimize

from remosplat_drake.controller.prediction.history import History
from remosplat_drake.controller.prediction.predict import modelled_way
from remosplat_drake.robot.actuators import Actuator, ActuatorModel
from remosplat_drake.robot.base_motion import base_way

MARGIN = 1.5
"""Ratio of the model's error bound (the tube) to the largest error in the
recording. It is a safety factor, since later motions may have larger errors."""

_LEAST_TUBE = 0.002
"""The tube (the error bound per commanded speed) is at least this [s], since a
recording does not show all errors."""

_LEAST_NOISE = 0.003
"""The noise of an axis at rest is assumed to be at least this [rad, m]."""

_LEAST_BASE_NOISE = 0.02
"""The noise of a base's axes is assumed to be at least this [rad, m]. The value
is larger than `_LEAST_NOISE`, since a localisation corrects the base's pose
during motion."""

_STILL = 1e-6
"""An axis counts as at rest if its commanded speed is below this [rad/s, m/s].
The bound is not zero, since a solver returns small values instead of zeros."""

_DELAYS = np.arange(0.0, 0.5, 0.02)
_LAGS = (0.0, 0.03, 0.08, 0.2)
_RAMPS = 0.3, 0.6, 1.0  # Shares of the commands' own ramp.


@dc.dataclass(frozen=True, eq=False)
class Recording:
    """Commands and measurements, with one row per tick.

    Attributes:
        sent: Times at which commands were sent, shape (k,) [s].
        u: The commands, shape (k, n_u) [m/s, rad/s].
        stamp: Time of each axis' latest measurement when the command was sent,
            shape (k, n_u) [s].
        q: The measurements, shape (k, n_q) [m, rad].
        n_base: Number of base velocities, which come first in u: 0, 2 or 3.
    """

    sent: np.ndarray
    u: np.ndarray
    stamp: np.ndarray
    q: np.ndarray
    n_base: int

    @property
    def gap(self) -> float:
        """Longest pause between two commands [s]."""
        return float(np.diff(self.sent).max())

    @property
    def way(self) -> np.ndarray:
        """Displacements of the axes since the first row, (k, n_u) [m, rad]."""
        if not self.n_base:
            return self.q
        steps = [
            base_way(before, after, self.n_base)
            for before, after in itertools.pairwise(self.q[:, :3])
        ]
        base = np.cumsum([np.zeros(self.n_base), *steps], axis=0)
        return np.hstack([base, self.q[:, 3:]])


@dc.dataclass(frozen=True)
class Fit:
    """The identified model of one axis, and its remaining error.

    Attributes:
        actuator: The model, with its error bound (the tube).
        residual: Range of the differences between measured and modelled
            positions, largest minus smallest [m, rad].
    """

    actuator: Actuator
    residual: float


def fit_axis(
    recording: Recording,
    axis: int,
    acceleration: float,
    crawls: Sequence[float],
) -> Fit:
    """Fits the model of one axis: dead time, lag or ramp, and dead band.

    Args:
        recording: Commands to this axis and its measurements.
        axis: Index of the axis in u.
        acceleration: Bound on the rate of change of the commands [m/s^2,
            rad/s^2].
        crawls: The speeds of the recording's slow motions, ascending [m/s,
            rad/s].
    """
    sent, u = recording.sent, recording.u[:, axis]
    stamp, way = recording.stamp[:, axis], recording.way[:, axis]

    def error(actuator: Actuator) -> float:
        return float(np.std(way - _response(actuator, sent, u, stamp)))

    ramps = [share * acceleration for share in _RAMPS]
    found = [
        _best(error, "time_constant", [0.0], 0.0),
        _best(error, "time_constant", _LAGS, 1.0),
        _best(error, "acceleration", ramps, 1000.0),
    ]
    least = min(found, key=error)
    found += [
        dc.replace(least, dead_band=min(1.05 * speed, 0.5)) for speed in crawls
    ]
    smallest = min(error(actuator) for actuator in found)
    # Among the models with nearly the least error, the simplest is chosen.
    actuator = next(a for a in found if error(a) <= 1.05 * smallest + 1e-6)
    left = way - _response(actuator, sent, u, stamp)
    is_base = axis < recording.n_base
    least_noise = _LEAST_BASE_NOISE if is_base else _LEAST_NOISE
    tube, noise = _tube(recording, axis, actuator, least_noise)
    return Fit(
        dc.replace(actuator, tube=tube, noise=noise), float(np.ptp(left))
    )


def _best(
    error: Callable[[Actuator], float],
    field: str,
    starts: Sequence[float],
    largest: float,
) -> Actuator:
    """Fits the dead time and another field: grid search, then Nelder-Mead."""

    def make(x) -> Actuator:
        delay, value = np.clip(x, [0.0, min(starts[0], 0.05)], [1.0, largest])
        return Actuator(delay=float(delay), **{field: float(value)})

    grid = [np.array([delay, x]) for delay in _DELAYS for x in starts]
    best = min(grid, key=lambda x: error(make(x)))
    width = np.array([0.015, 0.03 + 0.1 * best[1]])
    answer = minimize(
        lambda x: error(make(x)),
        best,
        method="Nelder-Mead",
        options={
            "initial_simplex": best + np.vstack([np.zeros(2), np.diag(width)]),
            "xatol": 1e-4,
            "fatol": 1e-9,
        },
    )
    return make(answer.x)


def _response(actuator: Actuator, sent, u, stamp) -> np.ndarray:
    """Returns the modelled displacement at each stamp, shape (k,)."""
    model = ActuatorModel.make([actuator])
    start = min(sent[0], stamp[0])
    way, _ = model.response(
        sent, u[:, None], np.array([start]), np.zeros(1), stamp[:, None]
    )
    return way[:, 0]


def _tube(
    recording: Recording, axis: int, actuator: Actuator, least_noise: float
) -> tuple[float, float]:
    """Returns the tube [s] and the noise that bound the errors of all rows.

    The tube is the error bound per commanded speed. The function processes the
    recording tick by tick, as a run processes its `History`.
    """
    model = ActuatorModel.make([actuator])
    history = History.at_rest(1)
    off, peaks = [], []
    rows = zip(
        recording.sent,
        recording.u[:, axis],
        recording.stamp[:, axis],
        recording.way[:, axis],
        strict=True,
    )
    for sent, u, stamp, way in rows:
        known = modelled_way(model, history, np.array([stamp]))
        history = history.with_measurement(np.array([way]), known, 0)
        off.append(history.residual(sent)[0])
        peaks.append(history.peak()[0])
        history = history.with_command(model, sent, np.array([u]))
    off, peaks = np.array(off), np.array(peaks)
    still = peaks < _STILL
    noise = max(float(off[still].max(initial=0.0)) * MARGIN, least_noise)
    moving = ~still
    seen = float(off[still].max(initial=0.0))
    over = np.maximum(off[moving] - seen, 0.0) / peaks[moving]
    tube = max(MARGIN * float(over.max(initial=0.0)), _LEAST_TUBE)
    return min(tube, 1.0), min(noise, 0.1)
