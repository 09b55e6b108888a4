"""`ActuatedAxes`: simulates dead time and lag of several axes."""

from collections import deque
from collections.abc import Sequence

import numpy as np

from remosplat_drake.robot.actuators import Actuator


class ActuatedAxes:
    """Simulates delays and first-order actuators of axes, in equal steps.

    Attributes:
        v: Velocities of the axes, shape (n,) [m/s, rad/s].
    """

    def __init__(self, actuators: Sequence[Actuator], dt: float):
        """Starts at rest.

        Args:
            actuators: Model of how each axis follows its commands.
            dt: Length of a step [s]; dead times are rounded to it.
        """
        self._dt, self._actuators = dt, actuators
        self.v = np.zeros(len(actuators))
        self._lines = [
            deque([0.0] * round(actuator.delay / self._dt))
            for actuator in actuators
        ]

    def step(self, target: np.ndarray) -> np.ndarray:
        """Advances the axes by one step.

        Args:
            target: Commands of this step, shape (n,) [m/s, rad/s].

        Returns:
            Mean velocities during the step, shape (n,) [m/s, rad/s].
        """
        mean = np.empty(len(self.v))
        for j, (line, axis) in enumerate(
            zip(self._lines, self._actuators, strict=True)
        ):
            line.append(float(target[j]))
            self.v[j], way = axis.step(self.v[j], line.popleft(), self._dt)
            mean[j] = way / self._dt
        return mean
