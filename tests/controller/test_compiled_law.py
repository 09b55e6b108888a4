"""One kernel adds the same terms as the ingredients' reference."""

import dataclasses as dc
import math
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from effort import effort
from hypothesis import given, settings
from hypothesis import strategies as st
from programs import decided
from pydrake.solvers import ClarabelSolver
from random_ticks import some_tick
from reference_program import Decision, ReferenceProgram, decide

from remosplat_drake.controller.controller_config import (
    default_ingredients,
    gain_set,
)
from remosplat_drake.controller.ingredients import (
    VelocityCost,
    VelocityCostConfig,
    VelocityLimits,
)
from remosplat_drake.controller.program.active_set import (
    INFEASIBLE,
    OPTIMAL,
    solve_dense,
)
from remosplat_drake.controller.program.kernels.path_places import (
    nearest_place,
    place_at,
)
from remosplat_drake.controller.program.path import Path
from remosplat_drake.controller.program.quadratic_program import (
    QuadraticProgram,
)
from remosplat_drake.controller.program.reactive_program import ReactiveProgram
from remosplat_drake.controller.program.solvers import CLARABEL, make_solver
from remosplat_drake.controller.program.term import NameTakenError
from remosplat_drake.controller.program.tick import Tick
from remosplat_drake.controller.tick.reactive_law import ReactiveLaw
from remosplat_drake.controller.tick.tick_program import TickProgram
from remosplat_drake.robot.robot_model import RobotModel, load_robot
from remosplat_drake.signals import tick_report
from remosplat_drake.signals.binding import BOUND, Binding
from remosplat_drake.signals.distance_field import Clearances


@pytest.fixture(scope="module")
def robots(frankie, lift_arm, two_arms) -> dict[str, RobotModel]:
    panda = load_robot("panda")
    return {
        "frankie": frankie,
        "panda": panda,
        "lift_arm": lift_arm,
        "two_arms": two_arms,
    }


def assert_equal_programs(one: TickProgram, other: ReferenceProgram):
    close = {"rtol": 1e-9, "atol": 1e-10}
    np.testing.assert_allclose(one.lower, other.lower, **close)
    np.testing.assert_allclose(one.upper, other.upper, **close)
    assert one.has_acceleration_bounds == other.has_acceleration_bounds
    assert one.terms.rows.keys() == other.rows.keys()
    for name, rows in one.terms.rows.items():
        same = other.rows[name]
        np.testing.assert_allclose(rows.A, same.A, **close)
        np.testing.assert_allclose(rows.b, same.b, **close)
        np.testing.assert_array_equal(rows.kept, same.kept)
        for i in range(len(rows.b)):
            assert rows.about(i) == same.about(i)
    for costs, same in (
        (one.terms.linear, other.terms.linear),
        (one.terms.quadratic, other.terms.quadratic),
    ):
        assert costs.keys() == same.keys()
        for name, values in costs.items():
            np.testing.assert_allclose(values, same[name], **close)
    ours, theirs = one.terms.trackings, other.terms.trackings
    assert ours.keys() == theirs.keys()
    for name, tracking in ours.items():
        same = theirs[name]
        assert tracking.name == same.name == name
        assert tracking.price == pytest.approx(same.price)
        for part in ("J", "V", "limit"):
            np.testing.assert_allclose(
                getattr(tracking, part), getattr(same, part), **close
            )
    forms = (one.form, other.form), (one.dense(), other.dense())
    for form, same in forms:
        for array, other_array in zip(form, same, strict=True):
            np.testing.assert_allclose(array, other_array, **close)


@given(
    st.sampled_from(["frankie", "panda", "lift_arm", "two_arms"]),
    st.sampled_from(["tuned", "paper"]),
    st.booleans(),
    st.integers(0, 10**9),
)
@settings(max_examples=effort(60, 300), deadline=None)
def test_the_kernel_adds_what_the_ingredients_add(
    robots, robot, gains, is_slow, seed
):
    robot = robots[robot]
    config = gain_set(gains)
    if is_slow:
        config.velocity_limits.max_reverse = 0.05
        config.velocity_limits.fraction = 0.5
    law = ReactiveLaw(robot, default_ingredients(robot, config))
    tick = some_tick(robot, seed)
    assert not law.compiled.outside
    program = law.program(tick)
    reference = ReferenceProgram(tick, law.ingredients)
    assert_equal_programs(program, reference)
    u, ended = program.optimum()
    other, _, also = solve_dense(*reference.dense())
    assert ended == also
    if program.is_hopeless:
        assert ended == INFEASIBLE
        solver = make_solver(CLARABEL, "")
        assert solver.solve(QuadraticProgram(reference.form)) is None
    if ended == OPTIMAL:
        np.testing.assert_allclose(u, other, rtol=1e-6, atol=1e-7)


@pytest.mark.parametrize(
    ("outside", "strict", "solver"),
    [
        (False, False, "active_set"),
        (False, True, CLARABEL),
        (True, False, CLARABEL),
        (True, True, "active_set"),
        pytest.param(False, False, CLARABEL, marks=pytest.mark.slow),
        pytest.param(False, True, "active_set", marks=pytest.mark.slow),
        pytest.param(True, False, "active_set", marks=pytest.mark.slow),
        pytest.param(True, True, CLARABEL, marks=pytest.mark.slow),
    ],
)
def test_a_tick_decides_as_the_reference_does(frankie, strict, solver, outside):
    config = gain_set("tuned")
    config.velocity_limits.strict = strict
    parts = default_ingredients(frankie, config)
    parts += [SlowElbow(-0.01)] * outside
    statuses = set()
    for seed in range(effort(60, 300)):
        tick = some_tick(frankie, seed)
        clearances = tick.clearances.within(0.5)
        if seed % 3 == 0:  # What demands a retreat can be too much.
            clearances = Clearances(
                clearances.sphere,
                clearances.distance - 0.3 * (seed % 2),
                clearances.direction_W,
                clearances.p_WC,
            )
        tick = dc.replace(tick, clearances=clearances, sphere_tube=None)
        report = decided(tick, parts, solver)
        reference = ReferenceProgram(tick, parts)
        decision = decide(reference, make_solver(solver, ""), strict=strict)
        assert report.status == decision.status
        # An interior point method ends near the optimum; how near depends on
        # the processor.
        atol = 1e-4 if solver == CLARABEL else 2e-5
        np.testing.assert_allclose(
            report.command, decision.u, rtol=1e-6, atol=atol
        )
        if decision.status == tick_report.RELAXED:
            assert report.reason == decision.reason
        if decision.program is not None and solver != CLARABEL:
            assert_equal_bindings(report.binding, decision)
        statuses.add(decision.status)
    assert {tick_report.OPTIMAL, tick_report.RELAXED} <= statuses


def assert_equal_bindings(binding: Binding, decision: Decision):
    rows = [row for row in binding.rows if row.name != BOUND]
    assert [(row.name, row.index) for row in rows] == (
        decision.program.tight_rows(decision.u)
    )
    for row in rows:
        assert row.about == decision.program.rows[row.name].about(row.index)
    if rows:
        push = decision.program.descent(decision.u)
        np.testing.assert_allclose(binding.push, push, atol=1e-6)


class SlowElbow:
    """An ingredient from outside, with a row, a cost and bounds."""

    def __init__(self, speed: float = 0.01):
        self.speed = speed

    def AddToProgram(self, program: ReactiveProgram, tick: Tick) -> None:
        e = np.eye(program.n_u)[-1]
        program.add_rows("elbow", e[None], np.full(1, self.speed))
        program.add_linear_cost("elbow", e)
        program.narrow(np.full(program.n_u, -0.4), np.full(program.n_u, 0.3))


@pytest.mark.parametrize("seed", range(10))
def test_ingredients_from_outside_add_theirs_afterwards(frankie, seed):
    elbow = SlowElbow()
    law = ReactiveLaw(frankie, [elbow, *default_ingredients(frankie)])
    tick = some_tick(frankie, seed)
    assert law.compiled.outside == (elbow,)
    program = law.program(tick)
    reference = ReferenceProgram(tick, [*default_ingredients(frankie), elbow])
    assert_equal_programs(program, reference)
    assert program.terms.rows["elbow"].about(0) == ("row 0",)


@pytest.mark.parametrize("seed", range(5))
def test_a_law_may_have_few_of_them(frankie, seed):
    config = gain_set("tuned")
    law = ReactiveLaw(frankie, [VelocityLimits(config.velocity_limits)])
    tick = some_tick(frankie, seed)
    assert_equal_programs(
        law.program(tick), ReferenceProgram(tick, law.ingredients)
    )


def test_a_law_has_one_ingredient_of_a_kind(frankie):
    twice = [VelocityCost(VelocityCostConfig(weight=w)) for w in (1.0, 2.0)]
    with pytest.raises(
        NameTakenError, match=r"of the class VelocityCost: .* 'velocity'"
    ):
        ReactiveLaw(frankie, twice)


def test_an_heir_of_an_ingredient_is_from_outside(frankie):
    class Dear(VelocityCost):
        def AddToProgram(self, program: ReactiveProgram, tick: Tick) -> None:
            program.add_quadratic_cost("dear", np.full(program.n_u, 7.0))

    config = VelocityCostConfig()
    law = ReactiveLaw(frankie, [Dear(config)])
    assert set(law.program(some_tick(frankie, 1)).terms.quadratic) == {"dear"}
    law = ReactiveLaw(frankie, [Dear(config), VelocityCost(config)])
    names = {"dear", "velocity"}
    assert set(law.program(some_tick(frankie, 1)).terms.quadratic) == names


def test_an_heir_with_settings_alone_is_the_librarys(frankie):
    class Cheap(VelocityCost):
        def __init__(self):
            super().__init__(VelocityCostConfig(weight=0.5))

    law = ReactiveLaw(frankie, [Cheap()])
    assert not law.compiled.outside
    cost = law.program(some_tick(frankie, 1)).terms.quadratic["velocity"]
    np.testing.assert_array_equal(cost[frankie.n_base :], 0.5)


def test_a_kept_program_is_solved_as_one_that_is_made_anew(robots):
    """One solver, asked by several threads, of robots in turns.

    Some of these programs are so flat that their optimum says little: what
    commands cost is compared.
    """
    solver, anew, count = make_solver(CLARABEL, ""), ClarabelSolver(), 0
    tries = effort(100, 400)

    def costs(seed: int) -> tuple[float, float]:
        robot = list(robots.values())[seed % len(robots)]
        law = ReactiveLaw(robot, default_ingredients(robot))
        program = law.program(some_tick(robot, seed))
        u = None if program.is_hopeless else solver.solve(program)
        result = anew.Solve(program.prog, None, None)
        other = result.GetSolution(program.u) if result.is_success() else None
        return cost_of(program, u), cost_of(program, other)

    with ThreadPoolExecutor(3) as threads:
        for ours, theirs in threads.map(costs, range(tries)):
            assert ours == pytest.approx(theirs, rel=2e-5)
            count += math.isfinite(ours)
    assert 0.05 < count / tries < 0.95


def cost_of(program: TickProgram, u: np.ndarray | None) -> float:
    """What a command costs, infinitely much where there is none."""
    if u is None:
        return math.inf
    H, c, _, _ = program.dense()
    return float(0.5 * u @ H @ u + c @ u)


@given(st.integers(0, 10**9))
@settings(max_examples=effort(100, 200), deadline=None)
def test_places_on_paths_are_those_of_paths(seed):
    rng = np.random.default_rng(seed)
    path = Path.through(rng.normal(size=(rng.integers(1, 6), 4)))
    q = rng.normal(size=4)
    for s in (rng.uniform(-0.5, path.length + 0.5), rng.choice(path.s)):
        np.testing.assert_allclose(
            place_at(path.q, path.s, s), path.at(s), atol=1e-12
        )
    np.testing.assert_allclose(
        nearest_place(path.q, path.s, q), path.nearest(q), atol=1e-12
    )
