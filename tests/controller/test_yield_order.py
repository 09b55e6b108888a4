"""Which rows yield to which, where a program cannot keep all of them."""

from itertools import combinations

import numpy as np
import pytest
from programs import program_of

from remosplat_drake.controller.decision import YIELD_ORDER, decide
from remosplat_drake.controller.kernels.assemble import PARTS, YIELDING
from remosplat_drake.controller.reactive_program import ReactiveProgram
from remosplat_drake.controller.solvers import make_solver
from remosplat_drake.controller.tick import Tick
from remosplat_drake.signals.binding import COLLISION
from remosplat_drake.signals.tick_report import OPTIMAL, RELAXED

ALL = (*YIELD_ORDER, COLLISION)


class Demand:
    """One row that wants a' u to be at least so much."""

    def __init__(self, name: str, a: list[float], least: float):
        self.name, self.a, self.least = name, np.array(a), least

    def AddToProgram(self, program: ReactiveProgram, tick: Tick) -> None:
        program.add_rows(self.name, -self.a[None], np.full(1, -self.least))


class Rest:
    """To move costs something."""

    def AddToProgram(self, program: ReactiveProgram, tick: Tick) -> None:
        program.add_quadratic_cost("rest", np.ones(program.n_u))


@pytest.mark.parametrize(("first", "last"), list(combinations(ALL, 2)))
@pytest.mark.parametrize("swapped", [False, True])
def test_of_two_that_contradict_each_other_one_yields(
    three_link, make_tick, first, last, swapped
):
    """The first axis shall be fast, and the second so much faster still.

    It cannot, but if either demand becomes "not the other way" it can.
    """
    tick = make_tick(three_link, np.zeros(3))
    fast = 0.6 * three_link.velocity_limit[:2].min()
    one, other = (last, first) if swapped else (first, last)
    demands = [
        Demand(one, [1.0, 0.0, 0.0], fast),
        Demand(other, [-1.0, 1.0, 0.0], fast),
    ]
    solver = make_solver("active_set", "")
    decision = decide(tick, program_of(tick, [Rest(), *demands]), solver)
    assert decision.status == RELAXED
    assert decision.reason == f"infeasible; yielded: {first}[row 0]"


def test_costs_yield_to_every_row(three_link, make_tick):
    tick = make_tick(three_link, np.zeros(3))
    demand = Demand(ALL[0], [1.0, 0.0, 0.0], 0.1)
    solver = make_solver("active_set", "")
    decision = decide(tick, program_of(tick, [Rest(), demand]), solver)
    assert decision.status == OPTIMAL
    np.testing.assert_allclose(decision.u, [0.1, 0.0, 0.0], atol=1e-6)


def test_kernels_know_the_same_order():
    assert tuple(PARTS[k].term for k in YIELDING) == ALL
