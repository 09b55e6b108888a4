"""Drake's solvers, on programs whose optimum is worked out by hand."""

import numpy as np
import pytest
from pydrake.solvers import ClarabelSolver

from remosplat_drake.controller.program.quadratic_program import (
    QuadraticProgram,
)
from remosplat_drake.controller.program.reactive_program import ReactiveProgram
from remosplat_drake.controller.program.solvers import DrakeSolver, make_solver

WANTED = np.array([0.5, -0.2, 0.1])
OPTIMUM = np.array([0.2, -0.2, 0.1])
"""The wanted command behind the wall u_0 <= 0.2."""


def behind_a_wall(*, extended: bool) -> QuadraticProgram:
    """Minimises |u - wanted|^2 / 2 where u_0 is at most 0.2."""
    program = ReactiveProgram(np.ones(3))
    wall = np.array([[1.0, 0.0, 0.0]])
    program.add_rows("wall", wall, np.array([0.2]))
    if extended:
        program.prog.AddQuadraticCost(np.eye(3), -WANTED, program.u)
    else:
        program.add_quadratic_cost("nearness", np.ones(3))
        program.add_linear_cost("nearness", -WANTED)
    return program.finished()


@pytest.mark.parametrize("extended", [False, True])
@pytest.mark.parametrize("name", ["clarabel", "osqp", "active_set"])
def test_solvers_find_the_command_behind_a_wall(name, extended):
    u = make_solver(name, "").solve(behind_a_wall(extended=extended))
    assert u is not None
    np.testing.assert_allclose(u, OPTIMUM, atol=2e-6)


def test_who_fails_in_haste_is_asked_with_care():
    asked = []

    class Hasty(ClarabelSolver):
        def Solve(self, prog, guess, options):
            asked.append(options)
            result = super().Solve(prog, guess, None)
            return result if options is None else Failed()

    class Failed:
        def is_success(self) -> bool:
            return False

    u = DrakeSolver(Hasty()).solve(behind_a_wall(extended=False))
    assert u is not None
    np.testing.assert_allclose(u, OPTIMUM, atol=1e-6)
    assert len(asked) == 2 and asked[0] is not None and asked[1] is None
