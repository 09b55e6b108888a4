"""Move as an aim says axis by axis, where it names no poses but velocities."""

import numpy as np

from remosplat_drake.controller.program.reactive_program import ReactiveProgram
from remosplat_drake.controller.program.tick import Tick


class VelocityTracking:
    """The cost of being slower or faster than `Aim.u`, of any axis.

    It is for laws without `ServoTracking`: the axes then move as requested,
    within all bounds and rows, and after verification. An aim without
    velocities means rest.
    """

    term = "velocity tracking"

    def AddToProgram(self, program: ReactiveProgram, tick: Tick) -> None:
        """Adds the cost sum_i w_i (u_i - u*_i)^2 / 2; see `Ingredient`.

        The weights w make axes equal that have different bounds.
        """
        u = np.zeros(program.n_u) if tick.aim.u is None else tick.aim.u
        weights = 1.0 / tick.robot.velocity_limit**2
        program.add_quadratic_cost(self.term, weights)
        program.add_linear_cost(self.term, -weights * u)
