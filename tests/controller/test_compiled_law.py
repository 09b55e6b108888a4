"""What one kernel adds is what the ingredients say by `AddToProgram`."""

import dataclasses as dc
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pydrake.math import RigidTransform, RotationMatrix

from remosplat_drake.controller.active_set import (
    INFEASIBLE,
    OPTIMAL,
    solve_dense,
)
from remosplat_drake.controller.binding import find_binding
from remosplat_drake.controller.compiled_program import CompiledProgram
from remosplat_drake.controller.controller_config import (
    default_ingredients,
    gain_set,
)
from remosplat_drake.controller.decision import YIELD_ORDER
from remosplat_drake.controller.decision import decide as decide_in_python
from remosplat_drake.controller.guidance.guidance import Guidance
from remosplat_drake.controller.ingredient import build_program
from remosplat_drake.controller.ingredients import (
    VelocityCost,
    VelocityCostConfig,
    VelocityLimits,
)
from remosplat_drake.controller.kernels.decide import decide
from remosplat_drake.controller.planning.kernels.path_places import (
    nearest_place,
    place_at,
)
from remosplat_drake.controller.planning.path import Path
from remosplat_drake.controller.reactive_law import ReactiveLaw
from remosplat_drake.controller.reactive_program import (
    ReactiveProgram,
    TermError,
)
from remosplat_drake.controller.solvers import CLARABEL, make_solver
from remosplat_drake.controller.tick import Tick
from remosplat_drake.robot.robot_model import RobotModel, load_robot
from remosplat_drake.scene.mover import Mover, Movers
from remosplat_drake.signals import tick_report
from remosplat_drake.signals.aim import Aim
from remosplat_drake.signals.binding import MOVER
from remosplat_drake.signals.distance_field import Clearances
from remosplat_drake.signals.target import Line, Target


@pytest.fixture(scope="module")
def robots(frankie, lift_arm, two_arms) -> dict[str, RobotModel]:
    panda = load_robot("panda")
    return {
        "frankie": frankie,
        "panda": panda,
        "lift_arm": lift_arm,
        "two_arms": two_arms,
    }


def some_tick(robot: RobotModel, seed: int) -> Tick:
    """A tick of which everything is drawn at random, some of it extreme."""
    rng = np.random.default_rng(seed)
    lower = np.maximum(robot.position_lower, -4.0)
    upper = np.minimum(robot.position_upper, 4.0)
    q = rng.uniform(lower, upper)
    if rng.random() < 0.3:
        q = np.where(rng.random(len(q)) < 0.5, lower, q)  # At the limits.
    state = robot.state(q)
    m = rng.integers(0, 90)
    directions = rng.normal(size=(m, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    sphere = np.sort(rng.integers(0, len(robot.spheres), m))
    clearances = Clearances(
        sphere, rng.uniform(-0.02, 0.5, m), directions, np.zeros((m, 3))
    )
    X_WT = np.eye(4)
    X_WT[:3, :3] = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    X_WT[:3, :3] *= np.linalg.det(X_WT[:3, :3])
    if rng.random() < 0.2:
        X_WT[:3, :3] = state.X_WE[:3, :3]
    X_WT[:3, 3] = state.X_WE[:3, 3] + rng.normal(size=3) * rng.choice(
        [0, 1e-4, 1]
    )
    targets = [some_target(X_WE, X_WT, rng) for X_WE in state.X_WEs]
    aim = some_aim(targets, rng)
    tube = rng.uniform(0, 0.01, len(robot.spheres))
    movers = some_movers(rng, state.spheres.p_WS)
    return Tick(
        robot,
        state,
        aim,
        clearances,
        rng.normal(size=robot.n_u) * rng.choice([0.0, 0.1, 5.0]),
        0.01,
        some_guidance(robot, q, rng),
        tube if rng.random() < 0.5 else None,
        movers if rng.random() < 0.5 else None,
        rng.uniform(0.0, 0.2),
    )


def some_movers(rng, p_WS) -> Movers:
    """Up to three rounded boxes around the robot, which move and turn."""
    movers = []
    for name in ("Ada", "Bob", "door")[: rng.integers(4)]:
        about = p_WS[rng.integers(len(p_WS))] + rng.uniform(-0.8, 0.8, 3)
        turned = RotationMatrix(np.linalg.qr(rng.normal(size=(3, 3)))[0])
        movers.append(
            Mover(
                name,
                RigidTransform(turned, about),
                rng.uniform(0, 0.2, 3) * rng.integers(0, 2, 3),
                rng.uniform(0.01, 0.1),
                rng.uniform(-1, 1, 3),
                rng.uniform(-1, 1, 3) * rng.integers(0, 2),
            )
        )
    return Movers(0.0, movers)


def some_aim(targets: list[Target], rng) -> Aim:
    """One target or more, of whichever end effectors."""
    kept = rng.integers(0, len(targets))
    return Aim(
        tuple(
            target if k == kept or rng.random() < 0.7 else None
            for k, target in enumerate(targets)
        )
    )


def some_target(X_WE, X_WT, rng) -> Target:
    """A plain target half the time; else with a line, weights or a way on."""
    target = Target(X_WT)
    if rng.random() < 0.5:
        return target
    if rng.random() < 0.5:
        weights = rng.choice([0.0, 0.2, 1.0, 5.0], 6)
        if np.count_nonzero(weights[:3]) == 1:
            weights[:3] = 0.0
        if weights.any():
            target = dc.replace(target, weights=weights)
    if rng.random() < 0.5:
        X_WA = X_WE.copy()
        X_WA[:3, 3] += rng.normal(size=3) * rng.choice([0, 0.01, 1])
        target = dc.replace(target, line=Line(X_WA, 0.1))
    if rng.random() < 0.5:
        target = dc.replace(target, passed_within=0.05, onward=0.7)
    return target


def some_guidance(robot, q, rng) -> Guidance:
    path = None
    if rng.random() < 0.5:
        steps = rng.normal(size=(rng.integers(1, 5), robot.n_q)) * 0.1
        if robot.n_base:  # Now the base only turns, now it drives.
            steps[rng.random(len(steps)) < 0.5, :2] = 0.0
        path = Path.through(q + np.cumsum(steps, axis=0) - steps[0])

    def maybe(value):
        return value if rng.random() < 0.5 else None

    return Guidance(
        "some",
        float(rng.choice([-1.0, 0.0, 1.0])),
        float(rng.normal()),
        float(rng.choice([0.0, 0.5, 1.0])),
        maybe(0.013),
        path,
        maybe(3.0),
        maybe(0.004),
    )


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
    for array, same in zip(one.dense(), other.dense(), strict=True):
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
    reference = build_program(tick, law.ingredients)
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


@pytest.mark.parametrize("acceleration", [False, True])
@pytest.mark.parametrize("relax", [(), (MOVER,), YIELD_ORDER])
def test_less_is_demanded_without_building_anew(frankie, acceleration, relax):
    law, yielded = ReactiveLaw(frankie, default_ingredients(frankie)), 0
    for seed in range(40):
        tick = some_tick(frankie, seed)
        less = law.program(tick).weakened(
            use_acceleration=acceleration, relax=relax
        )
        reference = build_program(
            tick, law.ingredients, use_acceleration=acceleration, relax=relax
        )
        assert_equal_programs(less, reference)
        assert less.yielded == reference.yielded
        yielded += len(less.yielded)
    assert bool(yielded) == bool(relax)


def test_what_has_more_than_kernels_know_is_built_anew(frankie):
    tick = some_tick(frankie, 0)
    law = ReactiveLaw(frankie, [*default_ingredients(frankie), SlowElbow()])
    assert not isinstance(law.program(tick), CompiledProgram)


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
        decision = decide_in_python(
            tick, law.ingredients, law.solver, strict=strict
        )
        u, is_decided = decide(
            law.program(tick).arrays,
            frankie.arrays,
            np.array(tick.u_previous),
            tick.dt,
            strict,
        )
        if is_decided:
            np.testing.assert_allclose(u, decision.u, rtol=1e-6, atol=1e-7)
            statuses.add(decision.status)
    assert {tick_report.OPTIMAL, tick_report.RELAXED} < statuses


class SlowElbow:
    """An ingredient from outside, with a row, a cost and bounds."""

    def AddToProgram(self, program: ReactiveProgram, tick: Tick) -> None:
        e = np.eye(program.n_u)[-1]
        program.add_rows("elbow", e[None], np.full(1, 0.01))
        program.add_linear_cost("elbow", e)
        program.narrow(np.full(program.n_u, -0.4), np.full(program.n_u, 0.3))


@pytest.mark.parametrize("seed", range(10))
def test_ingredients_from_outside_add_theirs_afterwards(frankie, seed):
    elbow = SlowElbow()
    law = ReactiveLaw(frankie, [elbow, *default_ingredients(frankie)])
    tick = some_tick(frankie, seed)
    assert law.compiled.outside == (elbow,)
    program = law.program(tick)
    reference = build_program(tick, [*default_ingredients(frankie), elbow])
    assert_equal_programs(program, reference)
    assert program.rows["elbow"].about(0) == ("row 0",)


@pytest.mark.parametrize("seed", range(5))
def test_a_law_may_have_few_of_them(frankie, seed):
    config = gain_set("tuned")
    law = ReactiveLaw(frankie, [VelocityLimits(config.velocity_limits)])
    tick = some_tick(frankie, seed)
    assert_equal_programs(
        law.program(tick), build_program(tick, law.ingredients)
    )


def test_a_name_is_taken_by_one_ingredient(frankie):
    twice = [VelocityCost(VelocityCostConfig(weight=w)) for w in (1.0, 2.0)]
    law = ReactiveLaw(frankie, twice)
    assert law.compiled.outside == (twice[1],)
    with pytest.raises(TermError, match="quadratic cost 'velocity'"):
        law.program(some_tick(frankie, 0))


def test_an_heir_of_an_ingredient_is_from_outside(frankie):
    class Dear(VelocityCost):
        def AddToProgram(self, program: ReactiveProgram, tick: Tick) -> None:
            program.add_quadratic_cost("dear", np.full(program.n_u, 7.0))

    law = ReactiveLaw(frankie, [Dear(VelocityCostConfig())])
    assert set(law.program(some_tick(frankie, 1)).quadratic) == {"dear"}


def test_drake_is_told_the_same(frankie):
    law = ReactiveLaw(frankie, default_ingredients(frankie))
    tick = dc.replace(some_tick(frankie, 4), guidance=Guidance())
    bindings = [
        {b.evaluator().get_description() for b in p.prog.GetAllConstraints()}
        for p in (law.program(tick), build_program(tick, law.ingredients))
    ]
    assert bindings[0] == bindings[1] > {"command bounds", "servo tracking"}


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
