"""`Motion`: the motion that commands already sent will cause."""

import dataclasses as dc
from functools import cache, cached_property
from typing import NamedTuple

import numpy as np

from remosplat_drake.base.kernels.packed import Packed
from remosplat_drake.robot.actuators import ActuatorModel


class MotionArrays(NamedTuple):
    """A `Motion` as arrays for kernels.

    Attributes:
        is_late: Whether the robot has a delay. If not, it executes commands at
            once, and all other fields are unused.
        parameters: `ActuatorModel.parameters`, shape (n_u, 4).
        tube: `Motion.tube`, shape (n_u,) [s].
        sent: `Motion.sent`, shape (h,) [s].
        u: `Motion.u`, shape (h, n_u).
        time: `Motion.time` [s].
        start: `Motion.start` [s].
        v_start: `Motion.v_start`, shape (n_u,).
        q_start: `Motion.q_start`, shape (n_q,).
    """

    is_late: bool
    parameters: np.ndarray
    tube: np.ndarray
    sent: np.ndarray
    u: np.ndarray
    time: float
    start: float
    v_start: np.ndarray
    q_start: np.ndarray


@cache
def prompt_motion(n_u: int) -> Packed[MotionArrays]:
    """Makes the arrays for a robot that executes commands at once.

    Args:
        n_u: Number of entries of the robot's command.
    """
    none = np.zeros(n_u)
    return Packed(
        MotionArrays(
            False,
            np.zeros((n_u, 4)),
            none,
            np.zeros(0),
            np.zeros((0, n_u)),
            0.0,
            0.0,
            none,
            np.zeros(0),
        )
    )


@dc.dataclass(frozen=True, eq=False)
class Motion:
    """Predicted motion of a robot with delay; a copy is the object itself.

    The robot will execute all commands that have been sent. The axes (base and
    joints) have different delays. A command that is sent at `time` acts on the
    fastest axis from `start` on.

    Attributes:
        model: Dynamic model by which the axes follow their commands.
        time: Time at which the next command is sent [s].
        sent: Times at which earlier commands were sent, ascending, shape (h,)
            [s].
        u: The earlier commands, shape (h, n_u) [m/s, rad/s].
        start: Time at which the next command begins to act [s].
        q_start: Predicted configuration at `start`, shape (n_q,) [m, rad].
        v_start: Predicted velocities at `start`, shape (n_u,) [m/s, rad/s].
        tube: Bound of the model's position errors, as a time, shape (n_u,) [s].
            The time multiplied by the speed of an axis bounds the position
            error of this axis.
        q_planned: Configuration after all commands that have been sent have
            acted on all axes, shape (n_q,) [m, rad]. From this configuration,
            later commands move the robot like one without delay.
        v_measured: Velocities that the model predicts for the time of the
            latest measurement, shape (n_u,) [m/s, rad/s].
        way_measured: Distances that the axes have moved in the model, from the
            start of the run to the latest measurement, shape (n_u,) [m, rad].
        residual: Errors of the positions that the model predicts within a short
            time window, shape (n_u,) [m, rad].
        bound: Bounds on these errors, shape (n_u,) [m, rad].
    """

    model: ActuatorModel
    time: float
    sent: np.ndarray
    u: np.ndarray
    start: float
    q_start: np.ndarray
    v_start: np.ndarray
    tube: np.ndarray
    q_planned: np.ndarray
    v_measured: np.ndarray
    way_measured: np.ndarray
    residual: np.ndarray
    bound: np.ndarray

    def __deepcopy__(self, memo) -> "Motion":
        return self

    @cached_property
    def arrays(self) -> Packed[MotionArrays]:
        """The motion as arrays for kernels."""
        return Packed(
            MotionArrays(
                True,
                self.model.parameters,
                self.tube,
                self.sent,
                self.u,
                float(self.time),
                float(self.start),
                self.v_start,
                self.q_start,
            )
        )
