"""What one kernel adds is what the ingredients' reference adds."""

import dataclasses as dc
import math
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pydrake.solvers import ClarabelSolver
from random_ticks import some_tick
from reference_ingredients import ReferenceProgram

from remosplat_drake.controller.active_set import (
    INFEASIBLE,
    OPTIMAL,
    solve_dense,
)
from remosplat_drake.controller.binding import find_binding
from remosplat_drake.controller.controller_config import (
    default_ingredients,
    gain_set,
)
from remosplat_drake.controller.decision import YIELD_ORDER
from remosplat_drake.controller.decision import decide as decide_in_python
from remosplat_drake.controller.guidance.guidance import Guidance
from remosplat_drake.controller.ingredients import (
    VelocityCost,
    VelocityCostConfig,
    VelocityLimits,
)
from remosplat_drake.controller.kernels.decide import (
    NOT_DECIDED,
    decide,
)
from remosplat_drake.controller.planning.kernels.path_places import (
    nearest_place,
    place_at,
)
from remosplat_drake.controller.planning.path import Path
from remosplat_drake.controller.reactive_law import ReactiveLaw
from remosplat_drake.controller.reactive_program import ReactiveProgram
from remosplat_drake.controller.solvers import CLARABEL, make_solver
from remosplat_drake.controller.term import NameTakenError
from remosplat_drake.controller.tick import Tick
from remosplat_drake.robot.robot_model import RobotModel, load_robot
from remosplat_drake.signals import tick_report
from remosplat_drake.signals.binding import MOVER
from remosplat_drake.signals.distance_field import Clearances
from remosplat_drake.signals.tick_report import STATUSES


@pytest.fixture(scope="module")
def robots(frankie, lift_arm, two_arms) -> dict[str, RobotModel]:
    panda = load_robot("panda")
    return {
        "frankie": frankie,
        "panda": panda,
        "lift_arm": lift_arm,
        "two_arms": two_arms,
    }


def assert_equal_programs(one: ReactiveProgram, other: ReactiveProgram):
    close = {"rtol": 1e-9, "atol": 1e-10}
    np.testing.assert_allclose(one.lower, other.lower, **close)
    np.testing.assert_allclose(one.upper, other.upper, **close)
    assert one.has_acceleration_bounds == other.has_acceleration_bounds
    assert one.rows.keys() == other.rows.keys()
    for name, rows in one.rows.items():
        same = other.rows[name]
        np.testing.assert_allclose(rows.A, same.A, **close)
        np.testing.assert_allclose(rows.b, same.b, **close)
        np.testing.assert_array_equal(rows.kept, same.kept)
        for i in range(len(rows.b)):
            assert rows.about(i) == same.about(i)
    for costs, same in (
        (one.linear, other.linear),
        (one.quadratic, other.quadratic),
    ):
        assert costs.keys() == same.keys()
        for name, values in costs.items():
            np.testing.assert_allclose(values, same[name], **close)
    assert one.trackings.keys() == other.trackings.keys()
    for name, tracking in one.trackings.items():
        same = other.trackings[name]
        assert tracking.name == same.name == name
        assert tracking.price == pytest.approx(same.price)
        for part in ("J", "V", "limit"):
            np.testing.assert_allclose(
                getattr(tracking, part), getattr(same, part), **close
            )
    for name in one.rows:
        np.testing.assert_array_equal(one.kept(name), other.kept(name))
    for form in ("dense", "slack_form"):
        arrays = zip(getattr(one, form)(), getattr(other, form)(), strict=True)
        for array, same in arrays:
            np.testing.assert_allclose(array, same, **close)


@given(
    st.sampled_from(["frankie", "panda", "lift_arm", "two_arms"]),
    st.sampled_from(["tuned", "paper"]),
    st.booleans(),
    st.integers(0, 10**9),
)
@settings(max_examples=300, deadline=None)
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
        assert make_solver(CLARABEL, "").solve(reference) is None
    if ended == OPTIMAL:
        np.testing.assert_allclose(u, other, rtol=1e-6, atol=1e-7)
        ours, theirs = (find_binding(p, u) for p in (program, reference))
        assert ours.rows == theirs.rows
        np.testing.assert_allclose(ours.push, theirs.push, atol=1e-6)


@pytest.mark.parametrize("outside", [False, True])
@pytest.mark.parametrize("acceleration", [False, True])
@pytest.mark.parametrize("relax", [(), (MOVER,), (*YIELD_ORDER, "elbow")])
def test_less_is_demanded_of_the_same_terms(
    frankie, outside, acceleration, relax
):
    """Those from outside add theirs again, and are told what is left out."""
    parts = [*default_ingredients(frankie), *[SlowElbow(-0.01)] * outside]
    law, yielded = ReactiveLaw(frankie, parts), 0
    for seed in range(40):
        tick = some_tick(frankie, seed)
        whole = law.program(tick)
        less = whole.weakened(use_acceleration=acceleration, relax=relax)
        reference = ReferenceProgram(
            tick, parts, use_acceleration=acceleration, relax=relax
        )
        assert_equal_programs(less, reference)
        assert_equal_programs(whole, ReferenceProgram(tick, parts))
        assert less.yielded == reference.yielded
        yielded += len(less.yielded)
    assert bool(yielded) == bool(relax)


@pytest.mark.parametrize("strict", [False, True])
def test_what_kernels_decide_is_what_a_tick_decides(frankie, strict):
    config = gain_set("tuned")
    config.velocity_limits.strict = strict
    law = ReactiveLaw(
        frankie, default_ingredients(frankie, config), solver="active_set"
    )
    statuses = set()
    for seed in range(300):
        tick = some_tick(frankie, seed)
        if seed % 3 == 0:  # What demands a retreat can be too much.
            clearances = tick.clearances
            deep = Clearances(
                clearances.sphere,
                clearances.distance - 0.3 * (seed % 2),
                clearances.direction_W,
                clearances.p_WC,
            )
            tick = dc.replace(tick, clearances=deep)
        reference = ReferenceProgram(tick, law.ingredients)
        decision = decide_in_python(tick, reference, law.solver, strict=strict)
        u, status = decide(
            law.program(tick).arrays,
            frankie.arrays,
            np.array(tick.u_previous),
            tick.dt,
            strict,
        )
        if status != NOT_DECIDED:
            np.testing.assert_allclose(u, decision.u, rtol=1e-6, atol=1e-7)
            assert STATUSES[status] == decision.status
            statuses.add(decision.status)
    assert {tick_report.OPTIMAL, tick_report.RELAXED} < statuses


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
    assert program.rows["elbow"].about(0) == ("row 0",)


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
    with pytest.raises(NameTakenError, match=r"a VelocityCost: .* 'velocity'"):
        ReactiveLaw(frankie, twice)


def test_an_heir_of_an_ingredient_is_from_outside(frankie):
    class Dear(VelocityCost):
        def AddToProgram(self, program: ReactiveProgram, tick: Tick) -> None:
            program.add_quadratic_cost("dear", np.full(program.n_u, 7.0))

    config = VelocityCostConfig()
    law = ReactiveLaw(frankie, [Dear(config)])
    assert set(law.program(some_tick(frankie, 1)).quadratic) == {"dear"}
    law = ReactiveLaw(frankie, [Dear(config), VelocityCost(config)])
    names = {"dear", "velocity"}
    assert set(law.program(some_tick(frankie, 1)).quadratic) == names


def test_an_heir_with_settings_alone_is_the_librarys(frankie):
    class Cheap(VelocityCost):
        def __init__(self):
            super().__init__(VelocityCostConfig(weight=0.5))

    law = ReactiveLaw(frankie, [Cheap()])
    assert not law.compiled.outside
    cost = law.program(some_tick(frankie, 1)).quadratic["velocity"]
    np.testing.assert_array_equal(cost[frankie.n_base :], 0.5)


def test_drake_is_told_the_same(frankie):
    law = ReactiveLaw(frankie, default_ingredients(frankie))
    tick = dc.replace(some_tick(frankie, 4), guidance=Guidance())
    bindings = [
        {b.evaluator().get_description() for b in p.prog.GetAllConstraints()}
        for p in (law.program(tick), ReferenceProgram(tick, law.ingredients))
    ]
    assert bindings[0] == bindings[1] > {"command bounds", "servo tracking"}


def test_a_kept_program_is_solved_as_one_that_is_made_anew(robots):
    """One solver, asked by several threads, of robots in turns.

    Some of these programs are so flat that their optimum says little: what
    commands cost is compared.
    """
    solver, anew, count = make_solver(CLARABEL, ""), ClarabelSolver(), 0

    def costs(seed: int) -> tuple[float, float]:
        robot = list(robots.values())[seed % len(robots)]
        law = ReactiveLaw(robot, default_ingredients(robot))
        program = law.program(some_tick(robot, seed))
        u = None if program.is_hopeless else solver.solve(program)
        result = anew.Solve(program.prog, None, None)
        other = result.GetSolution(program.u) if result.is_success() else None
        return cost_of(program, u), cost_of(program, other)

    with ThreadPoolExecutor(3) as threads:
        for ours, theirs in threads.map(costs, range(400)):
            assert ours == pytest.approx(theirs, rel=2e-5)
            count += math.isfinite(ours)
    assert 20 < count < 380


def cost_of(program: ReactiveProgram, u: np.ndarray | None) -> float:
    """What a command costs, infinitely much where there is none."""
    if u is None:
        return math.inf
    H, c, _, _ = program.dense()
    return float(0.5 * u @ H @ u + c @ u)


@given(st.integers(0, 10**9))
@settings(max_examples=200, deadline=None)
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
    assert math.isfinite(path.left(q))
