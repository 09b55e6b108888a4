"""Velocity tracking: base and joints follow the velocities of an aim."""

import numpy as np

from remosplat_drake.controller.program.reactive_program import ReactiveProgram
from remosplat_drake.controller.program.tick import Tick


class VelocityTracking:
    """A quadratic cost of each axis' deviation from `Aim.u`.

    Use it in laws without `ServoTracking`. The axes (base and joints) then move
    at the requested velocities, within all bounds and rows of the program, and
    subject to verification. If an aim contains no velocities, the requested
    velocities are zero.
    """

    term = "velocity tracking"

    def AddToProgram(self, program: ReactiveProgram, tick: Tick) -> None:
        """Adds the cost sum_i w_i (u_i - u*_i)^2 / 2; see `Ingredient`.

        u* is `Aim.u`. The weights w compensate for the axes' different bounds.
        """
        u = np.zeros(program.n_u) if tick.aim.u is None else tick.aim.u
        weights = 1.0 / tick.robot.velocity_limit**2
        program.add_quadratic_cost(self.term, weights)
        program.add_linear_cost(self.term, -weights * u)
