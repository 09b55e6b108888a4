"""The solvers that `remosplat bench solvers` times all find the optimum."""

import numpy as np
import pytest

from remosplat_drake.controller.program.active_set import OPTIMAL, solve_dense
from remosplat_drake.timing.optional_packages import is_there
from remosplat_drake.timing.solver_cases import (
    SOLVERS,
    Problem,
    recorded_problems,
    solver_cases,
)

TOLERANCE = {"OSQP, Drake's": 0.05}
"""Largest distance of a command from the optimum [rad/s, m/s]: by default OSQP
stops early. All others are as exact as Clarabel is."""


@pytest.fixture(scope="module")
def problems() -> list[Problem]:
    return recorded_problems()


@pytest.mark.parametrize("name", SOLVERS)
def test_all_solvers_find_the_same_optimum(problems, name):
    solver = SOLVERS[name]
    if solver.package and not is_there(solver.package):
        pytest.skip(f"needs the package {solver.package}")
    solve, binding = solver.make(), 0
    for problem in problems:
        u, multipliers, ended = solve_dense(*problem.dense)
        assert ended == OPTIMAL
        binding += multipliers.any()
        np.testing.assert_allclose(
            solve(problem), u, rtol=0.0, atol=TOLERANCE.get(name, 3e-4)
        )
    assert binding > 10  # Else any solver of linear equations would do.


def test_what_is_not_installed_has_no_case():
    names = {case.name for case in solver_cases()}
    assert names == {
        f"solvers: {name}"
        for name, solver in SOLVERS.items()
        if not solver.package or is_there(solver.package)
    }
