"""The law as its ingredients: one source of distances, at any period."""

import pickle

import numpy as np
import pytest
from programs import program_of
from pydrake.solvers import ClarabelSolver

from remosplat_drake.base.errors import FieldError, RemoSplatError
from remosplat_drake.controller import ingredients as ing
from remosplat_drake.controller.controller_config import (
    default_ingredients,
    gain_set,
)
from remosplat_drake.controller.program.reactive_program import ReactiveProgram
from remosplat_drake.controller.program.solvers import (
    ActiveSetSolver,
    DrakeSolver,
)
from remosplat_drake.controller.program.tick import Tick
from remosplat_drake.controller.tick.reactive_law import ReactiveLaw
from remosplat_drake.controller.tick.run_tick import run_tick
from remosplat_drake.oracle.signed_distance import SignedDistanceField
from remosplat_drake.scene.primitive_scene import PrimitiveScene


class Drift:
    """A linear cost that pushes every rate up."""

    def AddToProgram(self, program: ReactiveProgram, tick: Tick) -> None:
        program.add_linear_cost("drift", np.full(program.n_u, -0.05))


def without(kinds: tuple[type, ...], robot) -> list:
    return [i for i in default_ingredients(robot) if not isinstance(i, kinds)]


def command(law: ReactiveLaw) -> np.ndarray:
    """What a law does with the arm at rest, a target aside, nothing near."""
    robot = law.robot
    q = np.array([0.3, -0.8, 0.2])
    X_WT = robot.end_effector_pose(q + 0.1)
    field = SignedDistanceField(PrimitiveScene())
    clearances = field.clearances(robot.spheres_at(q))
    u = np.zeros(robot.n_u)
    return run_tick(law, 0.0, q, X_WT, clearances, field, u).command


def test_a_list_and_a_configuration_make_the_same_law(three_link):
    listed = ReactiveLaw(three_link, default_ingredients(three_link))
    made = ReactiveLaw.make(gain_set("fast"), three_link, 0.01)
    np.testing.assert_array_equal(command(listed), command(made))


def test_its_distances_are_those_of_its_dampers(three_link):
    config = gain_set("tuned")
    config.collision.stopping = 0.033
    config.self_collision.stopping = 0.02
    law = ReactiveLaw(three_link, default_ingredients(three_link, config))
    assert law.collision is config.collision
    assert law.self_clearance is not None
    assert law.self_clearance.stopping == 0.02


def test_without_dampers_its_distances_may_be_given(three_link):
    rest = without((ing.CollisionDamper, ing.SelfCollisionDamper), three_link)
    law = ReactiveLaw(three_link, rest)
    assert law.collision == ing.CollisionDamperConfig()
    assert law.self_clearance is not None
    law = ReactiveLaw(
        three_link,
        rest,
        collision=ing.CollisionDamperConfig(stopping=0.04),
        self_collision=ing.SelfCollisionDamperConfig(enabled=False),
    )
    assert law.collision.stopping == 0.04
    assert law.self_clearance is None


@pytest.mark.parametrize(
    ("name", "config"),
    [
        ("collision", ing.CollisionDamperConfig()),
        ("self_collision", ing.SelfCollisionDamperConfig()),
    ],
)
def test_distances_have_one_source(three_link, name, config):
    with pytest.raises(FieldError, match=f"{name}: the ingredient .*Damper"):
        ReactiveLaw(
            three_link, default_ingredients(three_link), **{name: config}
        )


def test_another_step_leaves_no_ingredient_out(three_link):
    law = ReactiveLaw(three_link, [*default_ingredients(three_link), Drift()])
    other = law.with_step(0.1, solver="active_set")
    assert other.ingredients is law.ingredients
    assert other.self_clearance is law.self_clearance
    assert isinstance(other.solver, ActiveSetSolver)
    assert (law.dt, other.dt) == (0.01, 0.1)
    assert law.with_step(0.05).solver is law.solver


@pytest.mark.parametrize("dt", [0.0, 0.2, np.nan])
def test_no_step_is_too_long_to_be_verified(three_link, dt):
    law = ReactiveLaw(three_link, [])
    with pytest.raises(FieldError, match="dt: must lie in"):
        law.with_step(dt)


def test_a_solver_that_is_not_there_is_named(three_link):
    with pytest.raises(FieldError, match="did you mean 'clarabel'"):
        ReactiveLaw(three_link, [], solver="clarable")


def test_a_pickled_law_decides_the_same(three_link):
    law = ReactiveLaw(three_link, [*default_ingredients(three_link), Drift()])
    again = pickle.loads(pickle.dumps(law))
    np.testing.assert_array_equal(command(again), command(law))
    assert (command(law) != command(again.with_step(0.02))).any()


class Twice:
    """Adds one kind of term, always by the same name."""

    def __init__(self, kind: str):
        self.kind = kind

    def AddToProgram(self, program: ReactiveProgram, tick: Tick) -> None:
        n = program.n_u
        if self.kind == "a linear cost":
            program.add_linear_cost("mine", np.ones(n))
        elif self.kind == "a quadratic cost":
            program.add_quadratic_cost("mine", np.ones(n))
        elif self.kind == "a set of rows":
            program.add_rows("mine", np.ones((2, n)), np.ones(2))
        else:
            J = np.ones((6, n))
            program.track("mine", J, np.ones(6), price=1.0, limit=np.ones(6))


@pytest.mark.parametrize(
    "kind", ["a linear cost", "a quadratic cost", "a set of rows", "a tracking"]
)
def test_no_term_silently_takes_the_place_of_another(
    three_link, make_tick, kind
):
    tick = make_tick(three_link, np.zeros(3))
    assert program_of(tick, [Twice(kind)])
    match = f"there is {kind} 'mine' already"
    for error in (ValueError, RemoSplatError):
        with pytest.raises(error, match=match):
            program_of(tick, [Twice(kind), Twice(kind)])


def test_terms_of_different_kinds_may_share_a_name(three_link, make_tick):
    kinds = ["a linear cost", "a quadratic cost", "a set of rows", "a tracking"]
    tick = make_tick(three_link, np.zeros(3))
    program = program_of(tick, [Twice(kind) for kind in kinds])
    terms = program.terms
    assert {*terms.linear, *terms.quadratic, *terms.rows} == {"mine"}


@pytest.mark.parametrize("shape", [(), (2,), (3, 3)])
def test_a_cost_of_another_shape_is_refused(three_link, shape):
    program = ReactiveProgram(three_link.velocity_limit)
    for add in (program.add_linear_cost, program.add_quadratic_cost):
        with pytest.raises(ValueError, match=r"'mine': .* shape \(3,\), not"):
            add("mine", np.ones(shape))
    with pytest.raises(ValueError, match=r"'mine': .* shape \(4, 3\), not"):
        program.add_rows("mine", np.ones(shape), np.ones(4))


def test_a_solver_of_drakes_can_be_pickled(three_link, make_tick):
    tick = make_tick(three_link, [0.3, -0.8, 0.2])
    program = program_of(tick, default_ingredients(three_link))
    solver = DrakeSolver(ClarabelSolver())
    again = pickle.loads(pickle.dumps(solver))
    np.testing.assert_array_equal(again.solve(program), solver.solve(program))
