"""`Motion`: a robot's predicted motion from the commands already sent."""

import dataclasses as dc
from functools import cache, cached_property
from typing import NamedTuple

import numpy as np

from remosplat_drake.base.kernels.packed import Packed
from remosplat_drake.robot.actuators import ActuatorModel


class MotionArrays(NamedTuple):
    """A `Motion`, as arrays for kernels.

    Attributes:
        is_late: Whether the robot has a delay; if not, it executes commands at
            once, and the other fields are unused.
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
    """Makes the motion of a robot that executes commands at once.

    Args:
        n_u: Number of entries of its command.
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
    """Predicted motion of a robot with delay; copies are the object itself.

    Commands that have been sent are committed: the robot will execute them. The
    axes have different delays; a command that is sent at `time` acts on the
    fastest axis at `start`.

    Attributes:
        model: Model of how the axes (base and joints) follow their commands.
        time: When the next command is sent [s].
        sent: When earlier commands were sent, ascending, shape (h,) [s].
        u: These commands, shape (h, n_u) [m/s, rad/s].
        start: When the next command begins to act [s].
        q_start: Configuration at that time, predicted, shape (n_q,) [m, rad].
        v_start: Velocities at that time, predicted, shape (n_u,)
            [m/s, rad/s].
        tube: Bound on the model's position errors as a time, shape (n_u,) [s].
            Multiplied by the speed of an axis, it bounds the error of that
            axis.
        q_planned: Configuration after all committed commands have acted on all
            axes, shape (n_q,) [m, rad]. Later commands move it like a robot
            without delay.
        v_measured: Velocities that the model predicts for the time of the
            latest measurement, shape (n_u,) [m/s, rad/s].
        way_measured: Distances that the axes of the model have travelled from
            the start of the run to the latest measurement, shape (n_u,) [m,
            rad].
        residual: Errors of the model's predicted positions within a short
            window, shape (n_u,) [m, rad].
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
        """The motion, as arrays for kernels."""
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
