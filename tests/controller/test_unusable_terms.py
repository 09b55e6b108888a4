"""An ingredient that adds something unusable is named, and the robot brakes."""

import numpy as np
import pytest

from remosplat_drake.base.kernels import kernel
from remosplat_drake.controller.controller_config import (
    default_ingredients,
    gain_set,
)
from remosplat_drake.controller.program.ingredient import IngredientError
from remosplat_drake.controller.program.kernels.dense import prune
from remosplat_drake.controller.program.reactive_program import ReactiveProgram
from remosplat_drake.controller.program.tick import Tick
from remosplat_drake.controller.tick.kernels.decide import BRAKING, decide
from remosplat_drake.controller.tick.reactive_law import ReactiveLaw
from remosplat_drake.controller.tick.run_tick import run_tick
from remosplat_drake.oracle.signed_distance import SignedDistanceField
from remosplat_drake.robot.braking import (
    braking_command,
    next_on_ramp,
)
from remosplat_drake.scene.primitive_scene import PrimitiveScene
from remosplat_drake.signals import tick_report
from remosplat_drake.signals.tick_report import TickReport

DT = 0.02
N_U = 9
ONES, EYE = np.ones(N_U), np.eye(N_U)


def spoilt(array: np.ndarray, value: float) -> np.ndarray:
    """The array with its last number replaced."""
    array = array.copy()
    array.flat[-1] = value
    return array


class Adds:
    """An ingredient that makes one call on the program."""

    def __init__(self, add):
        self.add = add

    def AddToProgram(self, program: ReactiveProgram, tick: Tick) -> None:
        self.add(program)


def tracked(program, J=EYE[:6], V=ONES[:6], price=1.0, limit=ONES[:6]):
    program.track("mine", J, V, price=price, limit=limit)


NOT_FINITE = {
    "linear cost 'mine': c": lambda p, x: p.add_linear_cost(
        "mine", spoilt(ONES, x)
    ),
    "quadratic cost 'mine': weights": lambda p, x: p.add_quadratic_cost(
        "mine", spoilt(ONES, x)
    ),
    "set of rows 'mine': A": lambda p, x: p.add_rows(
        "mine", spoilt(EYE, x), ONES
    ),
    "set of rows 'mine': b": lambda p, x: p.add_rows(
        "mine", EYE, spoilt(ONES, x)
    ),
    "tracking 'mine': J": lambda p, x: tracked(p, J=spoilt(EYE[:6], x)),
    "tracking 'mine': V": lambda p, x: tracked(p, V=spoilt(ONES[:6], x)),
    "tracking 'mine': price": lambda p, x: tracked(p, price=x),
    "LinearCost": lambda p, x: p.prog.AddLinearCost(spoilt(ONES, x), 0.0, p.u),
    "QuadraticCost": lambda p, x: p.prog.AddQuadraticCost(
        spoilt(EYE, x), ONES, p.u, is_convex=True
    ),
}

UNUSABLE = {
    "linear cost 'mine': c must have the shape (9,)": (
        lambda p: p.add_linear_cost("mine", ONES[:3])
    ),
    "quadratic cost 'mine': weights must have the shape (9,)": (
        lambda p: p.add_quadratic_cost("mine", EYE)
    ),
    "set of rows 'mine': A must have the shape (9, 9)": (
        lambda p: p.add_rows("mine", EYE[:, :4], ONES)
    ),
    "set of rows 'mine': b must have the shape (9,)": (
        lambda p: p.add_rows("mine", EYE, ONES[None])
    ),
    "tracking 'mine': J must have the shape (6, 9)": (
        lambda p: tracked(p, J=EYE[:5])
    ),
    "tracking 'mine': limit must have the shape (6,)": (
        lambda p: tracked(p, limit=np.ones(2))
    ),
    "tracking 'mine': limit is not finite": (
        lambda p: tracked(p, limit=spoilt(ONES[:6], np.nan))
    ),
    "tracking 'mine': limit is negative": (
        lambda p: tracked(p, limit=spoilt(ONES[:6], -1.0))
    ),
    "bounds on u: lower must have the shape (9,)": (
        lambda p: p.narrow(-ONES[:3], ONES)
    ),
    "bounds on u: upper is not finite": (
        lambda p: p.narrow(-ONES, spoilt(ONES, np.nan))
    ),
    "bounds on u: no command lies between": (
        lambda p: p.narrow(ONES, spoilt(ONES, 0.5))
    ),
    "quadratic cost 'mine': weights is negative, so that the cost is concave": (
        lambda p: p.add_quadratic_cost("mine", spoilt(ONES, -1e-6))
    ),
    "tracking 'mine': price is negative": lambda p: tracked(p, price=-1.0),
    "QuadraticCost: the cost is concave": (
        lambda p: p.prog.AddQuadraticCost(-EYE, ONES, p.u, is_convex=True)
    ),
    "prog: Failure": (
        lambda p: p.prog.AddBoundingBoxConstraint(-1.0, np.nan, p.u[:1])
    ),
}


@pytest.fixture(scope="module", params=["clarabel", "active_set"])
def report_of(request, frankie):
    """The report of a tick with one more ingredient, from a command u."""
    field = SignedDistanceField(PrimitiveScene().with_floor())
    q = np.array([0, 0, 0, *frankie.home])
    X_WT = frankie.end_effector_pose(q)
    X_WT[0, 3] += 0.2
    clearances = field.clearances(frankie.spheres_at(q), 0.5)
    parts = default_ingredients(frankie, gain_set("tuned"))

    def run(ingredient, u) -> TickReport:
        law = ReactiveLaw(
            frankie, [*parts, ingredient], DT, solver=request.param
        )
        return run_tick(law, 0.0, q, X_WT, clearances, field, u)

    return run


def assert_brakes(report: TickReport, u, robot, reason: str) -> None:
    assert report.status == tick_report.BRAKING
    assert report.reason.startswith(reason)
    ramp = braking_command(u, robot.acceleration_limit, DT)
    np.testing.assert_array_equal(report.command, ramp)


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
@pytest.mark.parametrize("term", NOT_FINITE)
def test_what_is_not_finite_is_named(report_of, frankie, term, value):
    u = 0.1 * ONES
    report = report_of(Adds(lambda p: NOT_FINITE[term](p, value)), u)
    assert_brakes(report, u, frankie, f"ingredient Adds: {term}")
    assert "not finite" in report.reason


@pytest.mark.parametrize("reason", UNUSABLE)
def test_what_is_unusable_is_named(report_of, frankie, reason):
    u = 0.1 * ONES
    report = report_of(Adds(UNUSABLE[reason]), u)
    assert_brakes(report, u, frankie, f"ingredient Adds: {reason}")


def test_bounds_may_be_infinite(report_of):
    def add(program):
        program.narrow(np.full(N_U, -np.inf), np.full(N_U, np.inf))

    assert report_of(Adds(add), 0 * ONES).status == tick_report.OPTIMAL


def test_what_the_solver_cannot_take_is_named(report_of, frankie):
    u = 0.1 * ONES
    report = report_of(Adds(lambda p: p.prog.AddCost(p.u[0] ** 3)), u)
    assert_brakes(report, u, frankie, "prog: ClarabelSolver")
    assert "GenericCost" in report.reason


class DividesByZero:
    """An ingredient with a defect of its own."""

    def AddToProgram(self, program: ReactiveProgram, tick: Tick) -> None:
        self.weight(0)

    def weight(self, n: int) -> float:
        return 1 / n


def test_an_ingredient_that_raises_is_named_with_its_line(report_of):
    line = DividesByZero.weight.__code__.co_firstlineno + 1
    with pytest.raises(IngredientError) as caught:
        report_of(DividesByZero(), 0 * ONES)
    assert str(caught.value) == (
        "ingredient DividesByZero raised ZeroDivisionError: division by zero"
        f" ({__file__}:{line})"
    )


def test_kernels_keep_a_row_that_is_not_a_number(frankie, make_tick):
    """No ingredient of the library adds one; if it did, no command would do."""
    law = ReactiveLaw(frankie, default_ingredients(frankie))
    tick = make_tick(frankie, [0, 0, 0, *frankie.home])
    for field, at in (("A", (0, 0)), ("b", 0)):
        arrays = law.program(tick).arrays
        assert arrays.count[0] > 0
        getattr(arrays, field)[at] = np.nan
        prune(arrays)
        assert arrays.kept[0]
        u = 0.1 * ONES
        command, status = decide_once(arrays, frankie.arrays, u)
        assert status == BRAKING
        ramp = braking_command(u, frankie.acceleration_limit, DT)
        np.testing.assert_array_equal(command, ramp)


@kernel
def decide_once(program, robot, u_previous):
    ramp = next_on_ramp(u_previous, robot.acceleration_limit, DT)
    return decide(program, ramp, False, True, -1)
