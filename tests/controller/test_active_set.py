"""The active-set method, by hand and against Clarabel."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pydrake.solvers import ClarabelSolver, MathematicalProgram

from remosplat_drake.controller.program.active_set import (
    INFEASIBLE,
    OPTIMAL,
    UNDECIDED,
    solve_dense,
)


def solved(H, c, A, b):
    arrays = (np.array(x, float) for x in (H, c, A, b))
    return solve_dense(*arrays)


def test_the_free_minimum():
    u, multipliers, ended = solved([[2, 0], [0, 4]], [-2, -4], [[1, 0]], [5])
    assert ended == OPTIMAL
    np.testing.assert_allclose(u, [1, 1])
    assert not multipliers.any()


def test_a_corner_by_hand():
    """The nearest point to (3, 2) with x <= 1 and y <= 1 is (1, 1)."""
    u, multipliers, ended = solved(
        np.eye(2), [-3, -2], [[1, 0], [0, 1], [1, 1]], [1, 1, 5]
    )
    assert ended == OPTIMAL
    np.testing.assert_allclose(u, [1, 1])
    np.testing.assert_allclose(multipliers, [2, 1, 0])


def test_a_row_leaves_again():
    """X + y <= 1 enters first and is let go when x <= -1 comes in."""
    u, multipliers, ended = solved(
        np.eye(2), [-2, 0], [[1, 0.1], [1, 0]], [1.9, -1]
    )
    assert ended == OPTIMAL
    np.testing.assert_allclose(u, [-1, 0])
    np.testing.assert_allclose(multipliers, [0, 3])


@pytest.mark.parametrize(
    ("A", "b"),
    [
        ([[1, 0], [-1, 0]], [-1, -1]),
        ([[0, 0]], [-1]),
        ([[1, 1], [1, -1], [-1, 0]], [-1, -1, -1]),
    ],
)
def test_rows_that_exclude_each_other(A, b):
    assert solved(np.eye(2), [0, 0], A, b)[2] == INFEASIBLE


def test_no_strictly_convex_program_no_answer():
    assert solved([[1, 0], [0, 0]], [0, 0], [[1, 0]], [1])[2] == UNDECIDED


def test_the_same_row_twice_changes_nothing():
    u, _, ended = solved(np.eye(2), [-3, 0], [[1, 0]] * 3, [1] * 3)
    assert ended == OPTIMAL
    np.testing.assert_allclose(u, [1, 0])


@given(
    seed=st.integers(0, 100_000),
    m=st.integers(1, 60),
    steepness=st.floats(-1, 3),
)
@settings(max_examples=60)
def test_equals_clarabel(seed, m, steepness):
    """Programs like a tick's: nine variables, boxed, six rows tracked."""
    rng = np.random.default_rng(seed)
    n = 9
    J = rng.normal(size=(6, n))
    H = 10**steepness * J.T @ J + 0.03 * np.eye(n)
    c = rng.normal(size=n) * 10**steepness
    A = np.vstack([rng.normal(size=(m, n)), np.eye(n), -np.eye(n)])
    b = np.concatenate([rng.uniform(-0.1, 1, m), np.ones(2 * n)])
    u, multipliers, ended = solve_dense(H, c, A, b)
    prog = MathematicalProgram()
    x = prog.NewContinuousVariables(n)
    prog.AddQuadraticCost(H, c, x, is_convex=True)
    prog.AddLinearConstraint(A, np.full(len(b), -np.inf), b, x)
    result = ClarabelSolver().Solve(prog, None, None)
    assert result.is_success() == (ended == OPTIMAL)
    if ended != OPTIMAL:
        assert ended == INFEASIBLE
        return
    # Optimal by itself: feasible, stationary, complementary.
    assert (A @ u - b).max() < 1e-8
    assert multipliers.min() >= 0
    gradient = H @ u + c
    scale = max(1.0, np.abs(gradient).max())
    np.testing.assert_allclose(gradient + multipliers @ A, 0, atol=1e-8 * scale)
    assert np.abs(multipliers * (A @ u - b)).max() < 1e-7 * scale
    # And no worse than the other's, which is flat where they differ.
    other = result.GetSolution(x)
    gain = 0.5 * other @ H @ other + c @ other - (0.5 * u @ H @ u + c @ u)
    assert gain > -1e-9 * max(1.0, abs(c @ u))
    np.testing.assert_allclose(u, other, atol=2e-3)
