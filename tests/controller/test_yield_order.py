"""The order in which rows are relaxed if a program is infeasible."""

from itertools import combinations

import numpy as np
import pytest
from programs import decided, program_of

from remosplat_drake.base.kernels import kernel
from remosplat_drake.controller.ingredients import (
    CollisionDamper,
    JointLimitDamper,
    MoverDamper,
    SelfCollisionDamper,
)
from remosplat_drake.controller.ingredients.kernels.assemble import (
    OUTSIDE,
    PARTS,
    YIELD_ORDER,
)
from remosplat_drake.controller.program.kernels.outside import joined
from remosplat_drake.controller.program.reactive_program import ReactiveProgram
from remosplat_drake.controller.program.tick import Tick
from remosplat_drake.controller.tick.kernels.decide import decide
from remosplat_drake.robot.braking import next_on_ramp
from remosplat_drake.signals.tick_report import OPTIMAL, RELAXED, STATUSES


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


def test_rows_yield_in_the_order_that_is_said():
    kinds = [PARTS[k] for k in YIELD_ORDER]
    assert kinds == [
        MoverDamper,
        JointLimitDamper,
        SelfCollisionDamper,
        CollisionDamper,
    ]


@pytest.mark.parametrize(("first", "last"), list(combinations(YIELD_ORDER, 2)))
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
    program = program_of(tick, [Rest()]).arrays
    rows = {one: ([1.0, 0.0, 0.0], fast), other: ([-1.0, 1.0, 0.0], fast)}
    outside = ReactiveProgram(program.upper)
    outside.add_quadratic_cost("rest", np.ones(3))
    outside.add_rows(
        "demands",
        -np.array([a for a, _ in rows.values()]),
        -np.array([least for _, least in rows.values()]),
    )
    arrays = joined(program, outside.arrays)
    # As if the library's own ingredients had added the two rows.
    arrays.rows[OUTSIDE] = 0
    for i, k in enumerate(rows):
        arrays.rows[k] = i, i + 1
    u, status = decide_once(arrays, three_link.arrays, tick.u_previous, 0.01)
    assert STATUSES[status] == RELAXED
    raised = {k for i, k in enumerate(rows) if arrays.raised[i]}
    assert raised == {first}
    np.testing.assert_allclose(rows[last][0] @ u, fast, atol=1e-6)


@kernel
def decide_once(program, robot, u_previous, dt):
    ramp = next_on_ramp(u_previous, robot.acceleration_limit, dt)
    return decide(program, ramp, False, True, -1)


def test_rows_from_outside_yield_with_those_before_the_scene(
    three_link, make_tick
):
    tick = make_tick(three_link, np.zeros(3))
    both = [
        Demand("up", [1.0, 0.0, 0.0], 0.1),
        Demand("down", [-1.0, 0.0, 0.0], 0.1),
    ]
    report = decided(tick, [Rest(), *both], "active_set")
    assert report.status == RELAXED
    assert report.reason == "infeasible; yielded: up[row 0], down[row 0]"


def test_costs_yield_to_every_row(three_link, make_tick):
    tick = make_tick(three_link, np.zeros(3))
    demand = Demand("demand", [1.0, 0.0, 0.0], 0.1)
    report = decided(tick, [Rest(), demand], "active_set")
    assert report.status == OPTIMAL
    np.testing.assert_allclose(report.command, [0.1, 0.0, 0.0], atol=1e-6)
