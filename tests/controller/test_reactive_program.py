"""The quadratic program: its optimum, its pruning and its fallbacks."""

import dataclasses as dc

import numpy as np
import pytest
from hypothesis import assume, example, given, settings
from hypothesis import strategies as st
from programs import decided, program_of
from pydrake.solvers import (
    ClarabelSolver,
    OsqpSolver,
    SolverOptions,
)
from scipy.optimize import nnls

from remosplat_drake.controller import ingredients as ing
from remosplat_drake.controller.controller_config import (
    default_ingredients,
    gain_set,
)
from remosplat_drake.controller.program.quadratic_program import (
    QuadraticProgram,
)
from remosplat_drake.controller.program.reactive_program import ReactiveProgram
from remosplat_drake.controller.program.solvers import (
    ActiveSetSolver,
    DrakeSolver,
    Solver,
)
from remosplat_drake.controller.program.tick import Tick
from remosplat_drake.controller.tick.tick_program import TickProgram
from remosplat_drake.generation.scene_generators import (
    PUBLISHED_FAMILIES,
    generate,
)
from remosplat_drake.oracle.signed_distance import SignedDistanceField
from remosplat_drake.signals import tick_report

CLARABEL = DrakeSolver(ClarabelSolver())
FASTEST, LOOSEST = 2.0, 1e3


class Pull:
    """The cost 1/2 |u|^2 - p'u, whose free minimum is p."""

    def __init__(self, p):
        self.p = np.array(p, float)

    def AddToProgram(self, program: ReactiveProgram, tick: Tick) -> None:
        n = len(self.p)
        program.prog.AddQuadraticCost(np.eye(n), -self.p, program.u)


class Wall:
    """The rows A u <= b."""

    def __init__(self, A, b, name="wall"):
        self.A, self.b, self.name = np.array(A, float), np.array(b, float), name

    def AddToProgram(self, program: ReactiveProgram, tick: Tick) -> None:
        program.add_rows(self.name, self.A, self.b, lambda i: f"brick {i}")


class Unsuccessful:
    """A solver that never finds anything."""

    def solve(self, program):
        return None


class NotFinite:
    """A solver that claims success and answers NaN."""

    def solve(self, program):
        return np.full(program.n_u, np.nan)


@pytest.fixture
def tick(three_link, make_tick) -> Tick:
    return make_tick(three_link, [0.3, -0.8, 0.2])


def random_tick(robot, make_tick, seed: int) -> Tick:
    """Frankie somewhere near the clutter of some scene, on the move."""
    rng = np.random.default_rng(seed)
    scene = generate(sorted(PUBLISHED_FAMILIES)[seed % 2], seed)
    q = np.array([*scene.X_WB_start, *robot.home])
    q += rng.uniform(-0.2, 0.2, len(q))
    q[0] += rng.uniform(0, 0.4)
    field = SignedDistanceField(scene, rows="per_primitive")
    return make_tick(
        robot,
        q,
        X_WT=scene.X_WE_target.GetAsMatrix4(),
        clearances=field.clearances(robot.spheres_at(q), 0.5),
        u_previous=rng.uniform(-0.3, 0.3, robot.n_u),
        dt=0.05,
    )


def ingredients_of(robot, gains: str):
    return default_ingredients(robot, gain_set(gains))


def solve(program: TickProgram, solver: Solver) -> np.ndarray | None:
    return None if program.is_hopeless else solver.solve(program)


def matrices(program: QuadraticProgram):
    """(Q, c, A, b, C, d): min 1/2 x'Qx + c'x, A x <= b, C x = d."""
    prog = program.prog
    n = prog.num_vars()
    Q, c = np.zeros((n, n)), np.zeros(n)
    for cost in prog.quadratic_costs():
        i = prog.FindDecisionVariableIndices(cost.variables())
        Q[np.ix_(i, i)] += cost.evaluator().Q()
        c[i] += cost.evaluator().b()
    for cost in prog.linear_costs():
        i = prog.FindDecisionVariableIndices(cost.variables())
        c[i] += cost.evaluator().a()
    A, b = [], []
    inequalities = [
        *prog.linear_constraints(),
        *prog.bounding_box_constraints(),
    ]
    for binding in inequalities:
        i = prog.FindDecisionVariableIndices(binding.variables())
        rows = np.zeros((binding.evaluator().num_constraints(), n))
        rows[:, i] = binding.evaluator().GetDenseA()
        for sign, bound in (
            (1, binding.evaluator().upper_bound()),
            (-1, binding.evaluator().lower_bound()),
        ):
            finite = np.isfinite(bound)
            A.append(sign * rows[finite])
            b.append(sign * bound[finite])
    C, d = np.zeros((0, n)), np.zeros(0)
    for binding in prog.linear_equality_constraints():
        i = prog.FindDecisionVariableIndices(binding.variables())
        rows = np.zeros((binding.evaluator().num_constraints(), n))
        rows[:, i] = binding.evaluator().GetDenseA()
        C = np.vstack([C, rows])
        d = np.concatenate([d, binding.evaluator().upper_bound()])
    return Q, c, np.vstack(A), np.concatenate(b), C, d


# The optimum


def test_without_limits_it_is_damped_least_squares(three_link, make_tick):
    """The command is (J'J/e + lambda I)^-1 J'v/e."""
    X_WT = three_link.end_effector_pose(np.array([0.32, -0.75, 0.2]))
    tick = make_tick(three_link, [0.3, -0.8, 0.2], X_WT=X_WT)
    u = solve(
        program_of(
            tick,
            [
                ing.ServoTracking(
                    ing.ServoTrackingConfig(2.0, FASTEST, LOOSEST),
                    ing.CollisionDamperConfig(),
                ),
                ing.VelocityCost(ing.VelocityCostConfig(weight=0.02)),
            ],
        ),
        CLARABEL,
    )
    J = np.vstack([tick.state.Jw_WE, tick.state.Jv_WE])
    v = 2.0 * np.concatenate([tick.error.rotation_W, tick.error.p_ET_W])
    e = tick.error.distance_l1
    expected = np.linalg.solve(J.T @ J / e + 0.02 * np.eye(3), J.T @ v / e)
    assert np.abs(expected).max() < 1
    np.testing.assert_allclose(u, expected, atol=1e-7)


def test_a_wall_stops_the_pull(tick):
    # The free minimum (1, 1, -0.5) lies beyond u_0 + u_1 <= 1.
    wall = Wall([[1, 1, 0]], [1])
    u = solve(program_of(tick, [Pull([1, 1, -0.5]), wall]), CLARABEL)
    np.testing.assert_allclose(u, [0.5, 0.5, -0.5], atol=1e-7)


def test_velocity_limits_hold_even_without_their_ingredient(tick):
    u = solve(program_of(tick, [Pull([9, -9, 1])]), CLARABEL)
    np.testing.assert_allclose(u, [2, -2, 1], atol=1e-6)


def test_every_binding_is_described(frankie, make_tick):
    tick = random_tick(frankie, make_tick, 1)
    prog = program_of(tick, ingredients_of(frankie, "tuned")).prog
    bindings = [*prog.GetAllCosts(), *prog.GetAllConstraints()]
    names = [binding.evaluator().get_description() for binding in bindings]
    assert all(names)
    assert len(set(names)) == len(names)


@given(seed=st.integers(0, 10_000), gains=st.sampled_from(["paper", "tuned"]))
@settings(max_examples=25)
def test_the_solution_satisfies_the_optimality_conditions(
    frankie, make_tick, seed, gains
):
    """Karush-Kuhn-Tucker, with multipliers found by an independent method."""
    tick = random_tick(frankie, make_tick, seed)
    program = program_of(tick, ingredients_of(frankie, gains))
    u = solve(program, CLARABEL)
    assume(u is not None)
    Q, c, A, b, C, d = matrices(program)
    # The slack follows from the command: delta = v_E - J u.
    n_u = frankie.n_u
    x = np.concatenate([u, d - C[:, :n_u] @ u])
    assert (A @ x - b).max() < 1e-6
    active = A[A @ x > b - 1e-5]
    # -(Qx + c) must be a combination of the active rows' normals with
    # factors >= 0, and of the equalities' normals with any factors.
    normals = np.vstack([active, C, -C]).T
    gradient = Q @ x + c
    _, residual = nnls(normals, -gradient, maxiter=2000)
    assert residual < 1e-3 * max(1.0, float(np.linalg.norm(gradient)))


@pytest.mark.parametrize("seed", range(1, 5))
def test_another_solver_finds_the_same_command(frankie, make_tick, seed):
    tick = random_tick(frankie, make_tick, seed)
    program = program_of(tick, without_acceleration(frankie))
    options = SolverOptions()
    for name in ("eps_abs", "eps_rel"):
        options.SetOption(OsqpSolver.id(), name, 1e-9)
    options.SetOption(OsqpSolver.id(), "max_iter", 100_000)
    result = OsqpSolver().Solve(program.prog, None, options)
    assert result.is_success()
    np.testing.assert_allclose(
        solve(program, CLARABEL), result.GetSolution(program.u), atol=1e-4
    )


@given(seed=st.integers(0, 10_000), gains=st.sampled_from(["paper", "tuned"]))
@settings(max_examples=25)
@example(seed=1106, gains="paper")  # Multipliers of 4e6.
def test_the_active_set_finds_the_same_command(frankie, make_tick, seed, gains):
    tick = random_tick(frankie, make_tick, seed)
    ingredients = ingredients_of(frankie, gains)
    slow = decided(tick, ingredients, CLARABEL)
    fast = decided(tick, ingredients, ActiveSetSolver())
    assert fast.status == slow.status
    np.testing.assert_allclose(fast.command, slow.command, atol=2e-4)


class Push:
    """The linear cost -p'u."""

    def __init__(self, p):
        self.p = np.array(p, float)

    def AddToProgram(self, program: ReactiveProgram, tick: Tick) -> None:
        program.add_linear_cost("push", -self.p)


@pytest.mark.parametrize("slack_limit", [0.1, LOOSEST])
def test_the_active_set_knows_the_limits_of_the_slack(
    three_link, make_tick, slack_limit
):
    """A push away from the target stops where the slack is used up."""
    tick = make_tick(three_link, [0.3, -0.8, 0.2])
    servo = ing.ServoTracking(
        ing.ServoTrackingConfig(0.5, FASTEST, slack_limit),
        ing.CollisionDamperConfig(),
    )
    damping = ing.VelocityCost(ing.VelocityCostConfig(weight=0.02))
    program = program_of(tick, [servo, damping, Push([5e3, 0, 0])])
    u = solve(program, ActiveSetSolver())
    np.testing.assert_allclose(u, solve(program, CLARABEL), atol=1e-5)
    (tracking,) = program.terms.trackings.values()
    slack = np.abs(tracking.V - tracking.J @ u).max()
    assert slack == pytest.approx(0.1) if slack_limit == 0.1 else slack > 1


def test_what_only_drake_knows_is_solved_by_drake(tick):
    program = program_of(tick, [Pull([1, 1, -0.5]), Wall([[1, 1, 0]], [1])])
    assert program.is_extended
    np.testing.assert_allclose(
        solve(program, ActiveSetSolver()), [0.5, 0.5, -0.5], atol=1e-6
    )


# Row pruning


def without_acceleration(robot):
    config = gain_set("tuned")
    config.velocity_limits.acceleration = False
    return default_ingredients(robot, config)


def with_all_rows(program: TickProgram) -> TickProgram:
    """Puts the pruned rows back."""
    program.arrays.kept[: program.arrays.count[0]] = True
    return TickProgram(program.arrays, program._names)


@given(seed=st.integers(0, 10_000), use_acceleration=st.booleans())
@settings(max_examples=25)
def test_pruning_changes_no_command(frankie, make_tick, seed, use_acceleration):
    tick = random_tick(frankie, make_tick, seed)
    parts = ingredients_of(frankie, "tuned")
    if not use_acceleration:
        parts = without_acceleration(frankie)
    u = []
    for restore in (lambda program: program, with_all_rows):
        u.append(solve(restore(program_of(tick, parts)), CLARABEL))
    if u[0] is None:
        assert u[1] is None
    else:
        # The solver's tolerance, along directions that cost little.
        np.testing.assert_allclose(u[0], u[1], atol=5e-4)


@given(
    rows=st.lists(
        st.tuples(*[st.floats(-1, 1)] * 3, st.floats(-1, 3)), min_size=1
    ),
    data=st.data(),
)
@settings(max_examples=50)
def test_no_command_within_bounds_breaks_a_pruned_row(
    three_link, make_tick, rows, data
):
    table = np.array(rows)
    tick = make_tick(three_link, np.zeros(3), u_previous=[0.5, -0.5, 0])
    program = program_of(
        tick,
        [
            ing.VelocityLimits(ing.VelocityLimitsConfig()),
            Wall(table[:, :3], table[:, 3]),
        ],
    )
    pruned = ~program.terms.rows["wall"].kept
    corner = data.draw(st.tuples(*[st.booleans()] * 3))
    u = np.where(corner, program.upper, program.lower)
    assert (table[pruned, :3] @ u <= table[pruned, 3] + 1e-12).all()


def test_tighter_bounds_prune_more_rows(frankie, make_tick):
    tick = random_tick(frankie, make_tick, 2)
    kept = [
        program_of(tick, parts).terms.rows["collision"].kept.sum()
        for parts in (
            ingredients_of(frankie, "tuned"),
            without_acceleration(frankie),
        )
    ]
    assert 0 < kept[0] < kept[1] < len(tick.clearances)


def test_a_row_is_pruned_exactly_when_the_bounds_imply_it(tick):
    # Within +-2 rad/s the row's left side reaches 3 at most.
    for b, kept in (
        (2.999_999, True),
        (3.0, False),
        (3.1, False),
        (-4.0, True),
    ):
        program = program_of(tick, [Wall([[1, -0.5, 0]], [b])])
        assert program.terms.rows["wall"].kept.tolist() == [kept]


def test_names_of_rows_are_unique(tick):
    with pytest.raises(ValueError, match="'wall' already"):
        program_of(tick, [Wall([[1, 0, 0]], [1])] * 2)


# Fallbacks


def test_acceleration_bounds_give_way_first(tick):
    # From 1 rad/s the shoulder may slow to 0.9 rad/s; the wall wants 0.2.
    tick = dc.replace(tick, u_previous=np.array([1.0, 0, 0]))
    limits = ing.VelocityLimits(ing.VelocityLimitsConfig())
    decision = decided(
        tick, [Pull([1, 0, 0]), Wall([[1, 0, 0]], [0.2]), limits], CLARABEL
    )
    assert decision.status == tick_report.ACCELERATION_DROPPED
    assert decision.reason
    np.testing.assert_allclose(decision.command, [0.2, 0, 0], atol=1e-6)


def test_a_strict_law_brakes_where_no_command_is_within_its_bounds(tick):
    # The same conflict: braking by 0.1 rad/s is what the bounds allow.
    tick = dc.replace(tick, u_previous=np.array([1.0, 0, 0]))
    limits = ing.VelocityLimits(ing.VelocityLimitsConfig(strict=True))
    parts = [Pull([1, 0, 0]), Wall([[1, 0, 0]], [0.2]), limits]
    decision = decided(tick, parts, CLARABEL)
    assert decision.status == tick_report.BRAKING
    np.testing.assert_allclose(decision.command, [0.9, 0, 0])


def test_in_a_strict_law_rows_yield_within_the_bounds(tick):
    # A retreat of 0.5 rad/s is asked for; from rest, 0.1 is possible, of which
    # it gets half, and of that the share that is taken.
    limits = ing.VelocityLimits(ing.VelocityLimitsConfig(strict=True))
    decision = decided(
        tick,
        [Pull([1, 1, 0]), Wall([[1, 0, 0]], [-0.5]), limits],
        CLARABEL,
    )
    assert decision.status == tick_report.RELAXED
    np.testing.assert_allclose(decision.command, [-0.045, 0.1, 0], atol=1e-6)


def test_conflicting_retreats_are_relaxed_and_named(tick):
    # u_0 <= -0.1 and -u_0 <= -0.1 exclude each other; u_1 <= 0.5 stays.
    decision = decided(
        tick,
        [
            Pull([1, 1, 1]),
            Wall([[1, 0, 0], [0, 1, 0], [-1, 0, 0]], [-0.1, 0.5, -0.1]),
            Wall([[0, 0, 1]], [-0.3], "fence"),
        ],
        CLARABEL,
    )
    assert decision.status == tick_report.RELAXED
    for name in ("wall[brick 0]", "wall[brick 2]", "fence[brick 0]"):
        assert name in decision.reason
    assert "brick 1" not in decision.reason
    np.testing.assert_allclose(decision.command, [0, 0.5, 0], atol=1e-6)


def test_a_relaxed_program_names_sphere_and_link(frankie, make_tick):
    q = np.array([0, 0, 0, *frankie.home])
    tick = make_tick(frankie, q)
    spheres = tick.state.spheres
    # Penetrated from all sides: no way out within the limits.
    count = 2 * len(spheres)
    axis = np.array([[0, 0, 1.0], [0, 0, -1.0]])
    clearances = dc.replace(
        tick.clearances,
        sphere=np.repeat(np.arange(len(spheres)), 2),
        distance=np.full(count, -0.2),
        direction_W=np.tile(axis, (len(spheres), 1)),
        p_WC=np.zeros((count, 3)),
    )
    decision = decided(
        make_tick(frankie, q, clearances=clearances),
        ingredients_of(frankie, "tuned"),
        CLARABEL,
    )
    assert decision.status == tick_report.RELAXED
    sphere = frankie.spheres.links.index("panda_hand")
    assert f"sphere {sphere} on panda_hand" in decision.reason
    # What no command moves need not recede.
    assert "on base_link" not in decision.reason


@pytest.mark.parametrize("solver", [Unsuccessful(), NotFinite()])
def test_without_an_answer_it_brakes(tick, solver):
    tick = dc.replace(tick, u_previous=np.array([1.0, -0.5, 0]))
    decision = decided(tick, [Pull([1, 1, 1])], solver)
    assert decision.status == tick_report.BRAKING
    assert decision.reason
    # The fastest joint may lose 10 rad/s^2 * 0.01 s of its 1 rad/s.
    np.testing.assert_allclose(decision.command, [0.9, -0.45, 0])


def test_where_all_rows_yield_standing_still_is_allowed(frankie, make_tick):
    for seed in range(20):
        program = program_of(
            random_tick(frankie, make_tick, seed), without_acceleration(frankie)
        )
        b = program.arrays.b[: program.arrays.count[0]]
        b[:] = np.maximum(b, 0.0)
        relaxed = TickProgram(program.arrays, program._names)
        _, _, A, b, C, d = matrices(relaxed)
        still = np.concatenate([np.zeros(frankie.n_u), d])
        assert (A @ still <= b).all()
        np.testing.assert_allclose(C @ still, d)
