"""`History`: the latest commands, and the motion in the actuator model."""

import dataclasses as dc
import math

import numpy as np

from remosplat_drake.controller.prediction.kernels.append_command import (
    append_command,
)
from remosplat_drake.controller.prediction.kernels.lead_forward import LONG_AGO
from remosplat_drake.controller.prediction.station_ramp import StationRamp
from remosplat_drake.robot.actuators import ActuatorModel
from remosplat_drake.robot.base_motion import base_way

WINDOW = 1.0
"""Time over which predictions are compared with measurements [s]. It is about
the time that a robot needs to stop."""

_SETTLED = 5.0
"""After this many time constants, the response to a command counts as
settled."""


@dc.dataclass(frozen=True, eq=False)
class History:
    """Past commands and measurements; copying returns the object itself.

    Row i of `v` and `way` is the state of the actuator model at the time at
    which command i was sent.

    Attributes:
        sent: Times at which commands were sent, ascending, shape (h,) [s].
        u: The commands, shape (h, n_u) [m/s, rad/s].
        v: Velocities of the model, shape (h, n_u) [m/s, rad/s].
        way: Distances in the model since the start of the history, shape (h,
            n_u) [m, rad].
        drift: Measured distances minus distances in the model, at the time at
            which each command was sent, shape (h, n_u) [m, rad].
        pose: Latest measured pose of the base, shape (3,) [m, m, rad]; shape
            (0,) if the robot has no base.
        measured: Measured distances since the start, shape (n_u,) [m, rad]; NaN
            before the first measurement.
    """

    sent: np.ndarray
    u: np.ndarray
    v: np.ndarray
    way: np.ndarray
    drift: np.ndarray
    pose: np.ndarray
    measured: np.ndarray

    @staticmethod
    def at_rest(n_u: int) -> "History":
        """Makes the history of a robot before its first command."""
        zeros = np.zeros((1, n_u))
        return History(
            np.array([LONG_AGO]),
            zeros,
            zeros,
            zeros,
            zeros,
            np.zeros(0),
            np.full(n_u, math.nan),
        )

    def __deepcopy__(self, memo) -> "History":
        return self

    def with_command(
        self,
        model: ActuatorModel,
        time: float,
        u: np.ndarray,
        ramp: StationRamp | None = None,
    ) -> "History":
        """Adds a command, and removes commands that no longer have an effect.

        Args:
            model: Actuator model of the axes.
            time: Time at which the command was sent [s].
            u: The command, shape (n_u,) [m/s, rad/s].
            ramp: Braking ramp of the station if no newer command arrives; None
                if the station holds the latest command.
        """
        if time <= self.sent[-1]:
            return self
        history, before, braking = self, self.sent[-1], self.u[-1]
        if ramp is not None and math.isfinite(time):
            for age, command in ramp.steps(braking, time - before):
                history = history._appended(model, before + age, command)
        return history._appended(model, time, u)

    def _appended(
        self, model: ActuatorModel, time: float, u: np.ndarray
    ) -> "History":
        span = WINDOW + model.delay.max() + _SETTLED * model.lag.max()
        sent, told, v, way, drift = append_command(
            model.parameters,
            (self.sent, self.u, self.v, self.way, self.drift),
            float(time),
            # The array is copied, since kernels are compiled for writable
            # arrays.
            np.array(u, float),
            span,
        )
        return History(sent, told, v, way, drift, self.pose, self.measured)

    def with_measurement(
        self, q: np.ndarray, modelled: np.ndarray, n_base: int
    ) -> "History":
        """Stores a measured configuration and its difference from the model.

        Args:
            q: The measured configuration, shape (n_q,) [m, rad].
            modelled: Distances in the model at the stamps of the measurements,
                shape (n_u,) [m, rad].
            n_base: Number of base commands.
        """
        if not np.isfinite(q).all():
            return self
        n_pose = len(q) - (len(modelled) - n_base)
        pose, arm = q[:n_pose], q[n_pose:]
        if np.isnan(self.measured).any():
            measured = np.concatenate([np.zeros(n_base), arm])
            drift = np.tile(measured - modelled, (len(self.sent), 1))
            return dc.replace(self, pose=pose, measured=measured, drift=drift)
        base = self.measured[:n_base]
        if n_base:
            base = base + base_way(self.pose, pose, n_base)
        measured = np.concatenate([base, arm])
        drift = self.drift.copy()
        drift[-1] = measured - modelled
        return dc.replace(self, pose=pose, measured=measured, drift=drift)

    def residual(self, now: float) -> np.ndarray:
        """Returns the errors of the model within `WINDOW`, shape (n_u,).

        The error of an axis is the greatest difference between two values of
        `drift` within `WINDOW`.
        """
        recent = self.drift[np.searchsorted(self.sent, now - WINDOW) :]
        return (
            np.ptp(recent, axis=0) if len(recent) else np.zeros(len(self.u[0]))
        )

    def peak(self) -> np.ndarray:
        """Returns the greatest commanded speeds, shape (n_u,) [m/s, rad/s]."""
        return np.abs(self.u).max(axis=0)
