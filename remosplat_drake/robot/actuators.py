"""Models of the axes' response (base and joints) to velocity commands.

A command acts after a pure dead time. The axis then approaches the commanded
velocity with a first-order lag, or on a ramp of bounded acceleration. The same
model simulates a real robot, predicts its configuration, and predicts how it
comes to rest.
"""

import dataclasses as dc
from collections.abc import Iterator, Sequence
from typing import Annotated

import numpy as np
from annotated_types import Interval

from remosplat_drake.base.ranges import Config
from remosplat_drake.robot.actuator_response import respond, step


@dc.dataclass
class Actuator(Config):
    """Model of how one axis follows its velocity command, with error bounds."""

    # Dead time from the command to its first effect [s]. This includes the
    # latency between a motion and the stamp of its measurement, since
    # identification cannot separate the two.
    delay: Annotated[float, Interval(ge=0, le=1)] = 0.0
    # Time constant of the first-order lag after the dead time [s].
    time_constant: Annotated[float, Interval(ge=0, le=1)] = 0.0
    # Bound on the rate of change of the axis' velocity, in place of a lag;
    # absent: none [rad/s^2, m/s^2].
    acceleration: Annotated[float, Interval(gt=0, le=1000)] | None = None
    # Dead band: the least commanded speed that moves the axis [rad/s, m/s].
    dead_band: Annotated[float, Interval(ge=0, le=0.5)] = 0.0
    # Tube: largest error of a predicted position, divided by the greatest speed
    # commanded since the measurement [s].
    tube: Annotated[float, Interval(ge=0, le=1)] = 0.0
    # Largest error of the position while the axis stands still, from sensor
    # noise [rad, m].
    noise: Annotated[float, Interval(ge=0, le=0.1)] = 0.0

    def check(self) -> Iterator[tuple[str, str]]:
        """Yields an error if both time constant and acceleration are given."""
        if self.time_constant and self.acceleration is not None:
            yield "acceleration", "cannot be used with a time_constant"

    @property
    def parameters(self) -> tuple[float, float, float, float]:
        """Dead time, time constant, acceleration and dead band, for kernels."""
        ramp = np.inf if self.acceleration is None else self.acceleration
        return self.delay, self.time_constant, ramp, self.dead_band

    def step(self, v: float, target: float, dt: float) -> tuple[float, float]:
        """Advances the axis by one step after its dead time, exactly.

        Args:
            v: Velocity of the axis [rad/s, m/s].
            target: Command that is in effect during the step [rad/s, m/s].
            dt: Duration of the step [s].

        Returns:
            The velocity at the end, and the distance travelled [rad/s and rad,
            or m/s and m].
        """
        return step(v, target, dt, *self.parameters[1:])


@dc.dataclass(frozen=True, eq=False)
class ActuatorModel:
    """The actuators of all n_u axes as arrays; copying returns the object.

    Attributes:
        parameters: Delay [s], time constant [s], bound on the acceleration
            (infinite for none) and dead band of each axis, shape (n_u, 4).
        tube: Largest errors of predicted positions, divided by the speeds
            commanded since the measurement, shape (n_u,) [s].
        noise: Largest errors of axes that stand still, shape (n_u,) [rad, m].
    """

    parameters: np.ndarray
    tube: np.ndarray
    noise: np.ndarray

    @staticmethod
    def make(actuators: Sequence[Actuator]) -> "ActuatorModel":
        """Makes the model of a robot's axes, in the order of u."""
        return ActuatorModel(
            np.array([actuator.parameters for actuator in actuators]),
            np.array([actuator.tube for actuator in actuators]),
            np.array([actuator.noise for actuator in actuators]),
        )

    def __deepcopy__(self, memo) -> "ActuatorModel":
        return self

    @property
    def delay(self) -> np.ndarray:
        """Dead times, shape (n_u,) [s]."""
        return self.parameters[:, 0]

    @property
    def lag(self) -> np.ndarray:
        """Time constants, shape (n_u,) [s]."""
        return self.parameters[:, 1]

    def response(
        self,
        sent: np.ndarray,
        u: np.ndarray,
        start: np.ndarray,
        v: np.ndarray,
        until: np.ndarray,
    ) -> tuple[np.ndarray, np.ndarray]:
        """Computes the motion of the axes under a sequence of commands.

        Args:
            sent: Times at which the commands were sent, ascending, shape (h,)
                [s]. Each command holds until the next command.
            u: The commands, shape (h, n_u) [rad/s, m/s].
            start: Time at which the motion of each axis starts, shape (n_u,)
                [s].
            v: Velocities at the start, shape (n_u,) [rad/s, m/s].
            until: Times of the returned positions, ascending and not before the
                start, shape (k, n_u) [s].

        Returns:
            The distances since the start, and the velocities, at these times,
            shape (k, n_u) each [rad, m; rad/s, m/s].
        """
        return respond(self.parameters, sent, u, start, v, until)


def default_actuators(n_base: int, n_arm: int) -> list[Actuator]:
    """Returns the assumed models of axes that have not been identified.

    The tubes (error bounds) are wide enough for axes without delay, for a base
    with a delay of 80 ms, and for an arm with a delay of 20 ms.

    Args:
        n_base: Number of base commands, 0, 2 or 3.
        n_arm: Number of the arm's joints.
    """
    base = Actuator(delay=0.03, tube=0.05, noise=0.01)
    arm = Actuator(delay=0.005, tube=0.015, noise=0.003)
    return [base] * n_base + [arm] * n_arm


_STIFFNESS = 600.0, 600.0, 600.0, 600.0, 250.0, 150.0, 50.0
_DAMPING = 50.0, 50.0, 50.0, 20.0, 20.0, 20.0, 10.0


def panda_py_actuators(delay: float = 0.0) -> list[Actuator]:
    """Returns models of a Panda's joints under panda-py's `IntegratedVelocity`.

    Its law, tau = K_p (q_d - q) - K_d q_dot with the integral q_d of the
    commands, damps the absolute velocity. A joint whose inertia is small
    compared with K_d follows with a first-order lag of K_d / K_p: 83 ms for the
    first joints, 200 ms for the last. The gains are the defaults of panda-py's
    integrated_velocity.cpp.

    Args:
        delay: Dead time before a command acts [s].
    """
    return [
        Actuator(delay=delay, time_constant=damping / stiffness)
        for stiffness, damping in zip(_STIFFNESS, _DAMPING, strict=True)
    ]
