"""`StationRamp`: the braking ramp of a station that receives no new command."""

import dataclasses as dc
from collections.abc import Iterator
from itertools import count

import numpy as np

from remosplat_drake.robot.braking import HELD, executed_command


@dc.dataclass(frozen=True, eq=False)
class StationRamp:
    """The ramp along which a station brakes if no new command arrives.

    The module `braking` defines the steps.

    Attributes:
        acceleration: Bounds on |du/dt|, shape (n_u,) [m/s^2, rad/s^2].
        period: Control period [s].
    """

    acceleration: np.ndarray
    period: float

    def steps(
        self, u: np.ndarray, time: float
    ) -> Iterator[tuple[float, np.ndarray]]:
        """Yields for each step the age of the command [s] and the velocities.

        Args:
            u: The command, shape (n_u,) [m/s, rad/s].
            time: Time until the next command, which ends the ramp [s].
        """
        command = u
        for k in count():
            age = (HELD + k) * self.period
            if age >= time or not command.any():
                return
            command = executed_command(
                u, self.acceleration, self.period, age + 0.5 * self.period
            )
            yield age, command
