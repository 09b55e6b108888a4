"""Compiled ingredients from outside, and what says the same in Python."""

from typing import NamedTuple

import numpy as np
from numba.extending import overload

from remosplat_drake.controller.program.compiled_ingredient import (
    CompiledIngredient,
)
from remosplat_drake.controller.program.kernels.tick_arrays import new_row
from remosplat_drake.robot.robot_arrays import add_rate

UP_W = 0.0, 0.0, 1.0


class Limits(NamedTuple):
    """Settings of both forms."""

    height: float
    slope: np.ndarray


class Ceiling(CompiledIngredient):
    """Keeps spheres below a height, at a price on motion."""

    def __init__(self, height: float, term: str = "ceiling"):
        self.height, self.term = height, term

    def settings(self, robot) -> Limits:
        return Limits(self.height, np.linspace(-0.1, 0.1, robot.n_u))

    def most_rows(self, robot) -> int:
        return len(robot.spheres)

    def about(self, robot, movers, number: int) -> str:
        return f"sphere {number}"

    @staticmethod
    def add(own, k, tick, program):
        for j in range(len(own.slope)):
            program.linear[k, j] = own.slope[j] * tick.error_scale
            program.quadratic[k, j] = abs(tick.u_previous[j])
        for s in range(len(tick.robot.radius)):
            room = own.height - tick.state.p_WS[s, 2] - tick.robot.radius[s]
            if room < 0.5:
                row = new_row(program, k, room, s)
                body, p_WS = tick.robot.body_S[s], tick.state.p_WS[s]
                A = program.A[row]
                add_rate(tick.robot, tick.state, body, p_WS, UP_W, 1.0, A)


class CeilingInPython:
    """The same in Python."""

    def __init__(self, height: float, term: str = "ceiling"):
        self.height, self.term = height, term

    def AddToProgram(self, program, tick) -> None:
        slope = np.linspace(-0.1, 0.1, program.n_u)
        program.add_linear_cost(self.term, slope * tick.error_scale)
        program.add_quadratic_cost(self.term, np.abs(tick.u_previous))
        spheres = tick.state.spheres
        room = self.height - spheres.p_WS[:, 2] - spheres.radius
        near = np.flatnonzero(room < 0.5)
        program.add_rows(
            self.term,
            tick.state.Jv_WS[near, 2],
            room[near],
            lambda i: f"sphere {near[i]}",
        )


def is_compiled() -> bool:
    return False


@overload(is_compiled)
def _is_compiled():
    return lambda: True


class Which(NamedTuple):
    """What is done, and with which value."""

    what: int
    value: float


WRONG = (
    "nothing",
    "linear cost 'mine': c is not finite",
    "quadratic cost 'mine': weights is not finite",
    "quadratic cost 'mine': weights is negative, so that the cost is concave",
    "set of rows 'mine': A is not finite",
    "set of rows 'mine': b is not finite",
    "set of rows 'mine': has 3 rows, but most_rows allows 2",
    "set of rows 'mine': has 5000 rows, but most_rows allows 2",
    "its function raises",
)
"""What is wrong with the terms of a `Wrong` ingredient, by number."""


class Wrong(CompiledIngredient):
    """An ingredient whose terms cannot be used, but for number 0."""

    term = "mine"

    def __init__(self, what: int, value: float = 0.0):
        self.what, self.value = what, value

    def settings(self, robot) -> Which:
        return Which(self.what, self.value)

    def most_rows(self, robot) -> int:
        return 2

    @staticmethod
    def add(own, k, tick, program):
        what, last = own.what, len(tick.u_previous) - 1
        program.quadratic[k, last] = 0.1 if is_compiled() else np.nan
        if what == 1:
            program.linear[k, last] = own.value
        if what == 2 or what == 3:
            program.quadratic[k, last] = own.value
        n = 3 if what == 6 else 5000 if what == 7 else 2
        for i in range(n):
            b = own.value if what == 5 and i == 1 else 10.0
            row = new_row(program, k, b, i)
            program.A[row, last] = own.value if what == 4 else 1.0
        if what == 8:
            raise ValueError("no such thing")


class Demand(CompiledIngredient):
    """Wants the first axis to turn, at least as fast as it is told."""

    def __init__(self, term: str, speed: float):
        self.term, self.speed = term, speed

    def settings(self, robot) -> Which:
        return Which(0, self.speed)

    def most_rows(self, robot) -> int:
        return 1

    @staticmethod
    def add(own, k, tick, program):
        row = new_row(program, k, -abs(own.value), 0)
        program.A[row, 0] = -np.sign(own.value)


class Unknown(CompiledIngredient):
    """An ingredient that does what Numba does not know."""

    term = "unknown"

    def settings(self, robot) -> Which:
        return Which(0, 0.0)

    @staticmethod
    def add(own, k, tick, program):
        program.linear[k, 0] = len(vars(own))
