"""`Motion`: what a robot is about to do by the commands it was sent."""

import dataclasses as dc
from functools import cached_property

import numpy as np

from remosplat_drake.robot.actuators import ActuatorModel


@dc.dataclass(frozen=True, eq=False)
class Motion:
    """A robot between a command and its effect; copying returns the object.

    Commands that were sent are committed: nothing takes them back. A command
    that is sent at `time` acts on the first axis at `start`.

    Attributes:
        model: How the axes follow their commands.
        time: When the next command is sent [s].
        sent: When earlier commands were sent, ascending, shape (h,) [s].
        u: These commands, shape (h, n_u) [m/s, rad/s].
        start: When the next command begins to act [s].
        q_start: Configuration at that time, predicted, shape (n_q,) [m, rad].
        v_start: Velocities at that time, predicted, shape (n_u,)
            [m/s, rad/s].
        q_planned: Configuration that all committed commands lead to, each
            axis being given its own time, shape (n_q,) [m, rad]. By the next
            commands it moves as a robot without any delay would.
        v_measured: Velocities that the model predicts for the time of the
            latest measurement, shape (n_u,) [m/s, rad/s].
        way_measured: Ways of the model from the beginning to that time, shape
            (n_u,) [m, rad].
        residual: Errors of the model's prediction within the window of
            `prediction`, shape (n_u,) [m, rad].
        bound: What they must not exceed, shape (n_u,) [m, rad].
    """

    model: ActuatorModel
    time: float
    sent: np.ndarray
    u: np.ndarray
    start: float
    q_start: np.ndarray
    v_start: np.ndarray
    q_planned: np.ndarray
    v_measured: np.ndarray
    way_measured: np.ndarray
    residual: np.ndarray
    bound: np.ndarray

    def __deepcopy__(self, memo) -> "Motion":
        return self

    @cached_property
    def in_flight(self) -> np.ndarray:
        """Greatest speeds among the commands not done yet, shape (n_u,)."""
        first = np.searchsorted(self.sent, self.start - self.model.delay.max())
        return np.maximum(
            np.abs(self.u[max(first - 1, 0) :]).max(axis=0),
            np.abs(self.v_start),
        )
