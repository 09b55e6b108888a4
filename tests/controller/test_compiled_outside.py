"""Ingredients from outside as compiled functions, inside ticks and rollouts."""

import pickle
from collections import Counter
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context

import numpy as np
import pytest
from compiled_ingredients import (
    WRONG,
    Ceiling,
    CeilingInPython,
    Demand,
    Unknown,
    Which,
    Wrong,
)
from programs import decided, program_of
from random_ticks import some_tick

from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.controller.controller_config import default_ingredients
from remosplat_drake.controller.guidance.rollout import (
    Rollout,
    advance_rollout,
)
from remosplat_drake.controller.ingredients import (
    VelocityCost,
    VelocityCostConfig,
)
from remosplat_drake.controller.program.compiled_ingredient import (
    CompiledIngredient,
)
from remosplat_drake.controller.program.guidance import DIRECT
from remosplat_drake.controller.program.term import NameTakenError, TermError
from remosplat_drake.controller.program.tick import Tick
from remosplat_drake.controller.tick.reactive_law import ReactiveLaw
from remosplat_drake.controller.tick.run_tick import run_tick
from remosplat_drake.controller.tick.tick_calls import asks_python
from remosplat_drake.generation.scene_generators import generate
from remosplat_drake.oracle.signed_distance import SignedDistanceField
from remosplat_drake.robot.braking import braking_command
from remosplat_drake.signals.tick_report import (
    BRAKING,
    OPTIMAL,
    RELAXED,
    TickReport,
)

FIELD = SignedDistanceField(generate("table", 3))


def law_with(robot, *more, solver: str = "active_set") -> ReactiveLaw:
    parts = [*default_ingredients(robot), *more]
    return ReactiveLaw(robot, parts, 0.02, solver=solver)


def report_of(law: ReactiveLaw, tick: Tick) -> TickReport:
    return run_tick(
        law,
        tick.time,
        tick.state.q,
        tick.aim,
        tick.clearances,
        FIELD,
        tick.u_previous,
        tick.guidance,
        movers=tick.movers,
    )


def steps(law: ReactiveLaw, tick: Tick) -> Rollout:
    start = Rollout(tick.guidance, tick.state.q, tick.u_previous)
    return advance_rollout(
        law, start, FIELD, tick.aim, lambda error: False, 99.0, 5
    )


def assert_equal_reports(ours: TickReport, theirs: TickReport) -> None:
    np.testing.assert_array_equal(ours.command, theirs.command)
    assert ours.status == theirs.status
    assert ours.reason == theirs.reason
    assert ours.binding.rows == theirs.binding.rows


@pytest.mark.parametrize(
    ("name", "solver"),
    [
        ("frankie", "active_set"),
        ("two_arms", "clarabel"),
        pytest.param("frankie", "clarabel", marks=pytest.mark.slow),
        pytest.param("two_arms", "active_set", marks=pytest.mark.slow),
    ],
)
def test_it_does_what_the_same_does_in_python(request, name, solver):
    """To the last bit, in ticks and in rollouts."""
    robot, seen = request.getfixturevalue(name), Counter()
    compiled = law_with(robot, Ceiling(1.2), solver=solver)
    in_python = law_with(robot, CeilingInPython(1.2), solver=solver)
    without = law_with(robot, solver=solver)
    for seed in range(60):
        tick = some_tick(robot, seed)
        ours, theirs = report_of(compiled, tick), report_of(in_python, tick)
        assert_equal_reports(ours, theirs)
        seen[ours.status] += 1
        seen["binds"] += any(r.name == "ceiling" for r in ours.binding.rows)
        seen["yields"] += "ceiling[sphere" in ours.reason
        other = report_of(without, tick).command
        seen["matters"] += not np.array_equal(ours.command, other)
        if seed % 4 == 0:
            ours, theirs = steps(compiled, tick), steps(in_python, tick)
            np.testing.assert_array_equal(ours.u, theirs.u)
            np.testing.assert_array_equal(ours.q, theirs.q)
    assert {RELAXED, "binds", "yields", "matters"} <= set(+seen)
    assert OPTIMAL in seen or name == "two_arms"


def test_several_go_with_several_in_python(frankie):
    """The order of sums differs, and with it the last bits."""
    mixed = [Ceiling(1.2), CeilingInPython(0.9, "low"), Ceiling(1.5, "high")]
    law = law_with(frankie, *mixed)
    in_python = law_with(
        frankie,
        CeilingInPython(1.2),
        CeilingInPython(1.5, "high"),
        CeilingInPython(0.9, "low"),
    )
    assert len(law.compiled.outside) == 1
    for seed in range(30):
        tick = some_tick(frankie, seed)
        ours, theirs = law.program(tick), in_python.program(tick)
        for name, same in theirs.terms.rows.items():
            if not len(same.b):
                continue
            rows = ours.terms.rows[name]
            np.testing.assert_array_equal(rows.A, same.A)
            np.testing.assert_array_equal(rows.b, same.b)
            for i in range(len(rows.b)):
                assert rows.about(i) == same.about(i)
        for one, other in zip(ours.form, theirs.form, strict=True):
            np.testing.assert_allclose(one, other, atol=1e-12)
        ours, theirs = report_of(law, tick), report_of(in_python, tick)
        assert (ours.status, ours.reason) == (theirs.status, theirs.reason)


def test_python_is_not_asked(frankie):
    assert not asks_python(law_with(frankie, Ceiling(1.2)), FIELD)
    assert asks_python(law_with(frankie, CeilingInPython(1.2)), FIELD)


def test_the_compiled_function_is_what_runs(frankie, make_tick):
    """As it was compiled: in Python its cost would not be a number."""
    tick = make_tick(frankie, frankie.q_home)
    law = law_with(frankie, Wrong(0))
    assert report_of(law, tick).status == OPTIMAL
    cost = law.program(tick).terms.quadratic["mine"]
    np.testing.assert_array_equal(cost, [*[0.0] * 8, 0.1])


VALUES = {1: (np.nan, np.inf, -np.inf), 2: (np.nan, np.inf), 3: (-1e-6,)}
CASES = [
    (what, value)
    for what in range(1, len(WRONG))
    for value in VALUES.get(what, (np.nan, np.inf))
]


@pytest.mark.parametrize(("what", "value"), CASES)
def test_what_cannot_be_used_is_named_and_brakes(
    frankie, make_tick, what, value
):
    u = np.full(9, 0.1)
    tick = make_tick(frankie, frankie.q_home, u_previous=u)
    law = law_with(frankie, Ceiling(1.2), Wrong(what, value))
    report = report_of(law, tick)
    assert report.status == BRAKING
    assert report.reason == f"ingredient Wrong: {WRONG[what]}"
    ramp = braking_command(u, frankie.acceleration_limit, law.dt)
    np.testing.assert_array_equal(report.command, ramp)
    one = advance_rollout(
        law,
        Rollout(DIRECT, tick.state.q, u),
        FIELD,
        tick.aim,
        lambda error: False,
        99.0,
    )
    np.testing.assert_array_equal(one.u, ramp)
    with pytest.raises(TermError, match=r"^ingredient Wrong: "):
        law.program(tick)


def test_its_rows_yield_with_the_others(three_link, make_tick):
    tick = make_tick(three_link, np.zeros(3))
    both = [Demand("up", 0.1), Demand("down", -0.1)]
    report = decided(tick, both, "active_set")
    assert report.status == RELAXED
    assert report.reason == "infeasible; yielded: up[row 0], down[row 0]"


def test_a_name_is_given_once(frankie, make_tick):
    for taken in ("mine", "velocity"):
        with pytest.raises(NameTakenError, match=f"the name '{taken}'"):
            law_with(frankie, Ceiling(1.2, taken), Wrong(0))
    tick = make_tick(frankie, frankie.q_home)
    both = [Ceiling(1.2), CeilingInPython(1.2)]
    with pytest.raises(NameTakenError, match="ingredient CeilingInPython: "):
        program_of(tick, both)


def test_what_cannot_be_compiled_is_named(frankie):
    match = (
        r"^ingredient Unknown cannot be compiled: Untyped global name 'vars': "
        r".* File \".*compiled_ingredients\.py\", line \d+: .*"
    )
    with pytest.raises(RemoSplatError, match=match) as caught:
        law_with(frankie, Unknown())
    assert "\n" not in str(caught.value)


def test_one_that_adds_nothing_is_refused(frankie):
    class Idle(CompiledIngredient):
        term = "idle"

        def settings(self, robot):
            return Which("slow", 1.0)

    match = "^ingredient Idle has no function `add`$"
    with pytest.raises(RemoSplatError, match=match):
        law_with(frankie, Idle())


@pytest.mark.parametrize("settings", [3.0, (1.0, 2.0), Which("slow", 1.0)])
def test_settings_that_kernels_cannot_take_are_refused(frankie, settings):
    class Odd(Demand):
        def settings(self, robot):
            return settings

    match = "^ingredient Odd: settings must be a named tuple of numbers and"
    with pytest.raises(RemoSplatError, match=match):
        law_with(frankie, Odd("odd", 1.0))


@pytest.mark.slow
def test_a_law_with_it_goes_to_other_processes(frankie, make_tick):
    law = law_with(frankie, Ceiling(1.2))
    tick = make_tick(frankie, frankie.q_home, u_previous=np.full(9, 0.1))
    expected = steps(law, tick)  # Kernels know addresses of this process now.
    sent = pickle.dumps((law, tick.state.q, tick.u_previous, tick.X_WT))
    with ProcessPoolExecutor(1, get_context("spawn")) as pool:
        u = pool.submit(_steps_there, sent).result()
    np.testing.assert_array_equal(u, expected.u)


def _steps_there(sent: bytes) -> np.ndarray:
    law, q, u, X_WT = pickle.loads(sent)
    start = Rollout(DIRECT, q, u)
    return advance_rollout(
        law, start, FIELD, X_WT, lambda error: False, 99.0, 5
    ).u


def test_an_heir_of_the_librarys_may_have_a_function(frankie, make_tick):
    class Dear(VelocityCost):
        term = "dear"
        add = staticmethod(Ceiling.add)
        settings = Ceiling.settings
        height = 99.0

    config = VelocityCostConfig()
    law = ReactiveLaw(frankie, [Dear(config), VelocityCost(config)])
    tick = make_tick(frankie, frankie.q_home, u_previous=np.ones(9))
    assert set(law.program(tick).terms.quadratic) == {"dear", "velocity"}
