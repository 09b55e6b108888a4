"""Benchmarks of QP solvers on the quadratic programs of a run.

No solver starts from a previous solution. Some solvers take dense matrices in u
alone, and others a complete Drake program.
"""

from collections.abc import Callable
from functools import partial
from typing import NamedTuple

import numpy as np
from pydrake.solvers import SolverOptions

from remosplat_drake.app.scenario import load_scenario
from remosplat_drake.app.world import load_world
from remosplat_drake.controller.program.active_set import (
    DenseProgram,
    solve_dense,
)
from remosplat_drake.controller.program.quadratic_program import (
    QuadraticProgram,
)
from remosplat_drake.controller.program.solvers import DRAKE_SOLVERS
from remosplat_drake.controller.tick.reactive_law import ReactiveLaw
from remosplat_drake.timing.measuring import Case, in_turn
from remosplat_drake.timing.optional_packages import is_there
from remosplat_drake.timing.tick_cases import recorded_ticks

PACKAGES = ("proxsuite", "daqp")
"""Optional packages whose solvers are timed if they are installed."""

_OSQP = 1e-6
"""Tolerance with which OSQP with polishing is as exact as the other solvers."""

_PROXQP = 1e-8
"""Tolerance, also of the duality gap, with which ProxQP is as exact as the
other solvers."""


class Problem(NamedTuple):
    """The quadratic program of a tick, in the two forms that solvers take.

    Attributes:
        dense: The program as matrices in u alone.
        drake: The program as a complete Drake `prog`.
    """

    dense: DenseProgram
    drake: QuadraticProgram


Solve = Callable[[Problem], np.ndarray]
"""Function that finds the optimal command u, shape (n_u,)."""


class Solver(NamedTuple):
    """A solver whose duration is measured.

    Attributes:
        make: Function that returns the function to measure.
        package: The package that must be installed; empty if none is needed.
    """

    make: Callable[[], Solve]
    package: str = ""


def solver_cases(scenario_name: str | None = None) -> list[Case]:
    """Makes a benchmark for each installed solver.

    Args:
        scenario_name: Name or file of the scenario with these programs; None
            for the default scenario.
    """
    problems = recorded_problems(scenario_name)
    return [
        _case(name, solver.make(), problems)
        for name, solver in SOLVERS.items()
        if not solver.package or is_there(solver.package)
    ]


def _case(name: str, solve: Solve, problems: list[Problem]) -> Case:
    return Case(f"solvers: {name}", in_turn(problems, solve))


def recorded_problems(scenario_name: str | None = None) -> list[Problem]:
    """Returns the programs of some ticks of a headless run.

    Args:
        scenario_name: Name or file of the scenario; None for the default
            scenario.
    """
    scenario = load_scenario(scenario_name)
    world = load_world(scenario)
    law = ReactiveLaw.make(
        scenario.controller, world.robot, scenario.control_period
    )
    programs = map(law.program, recorded_ticks(scenario, world))
    return [_problem(program) for program in programs]


def _problem(program: QuadraticProgram) -> Problem:
    assert program.prog is not None  # The first access completes it.
    return Problem(program.dense(), program)


def _active_set() -> Solve:
    return lambda problem: solve_dense(*problem.dense)[0]


def _drakes(name: str, **options: float) -> Solve:
    solver, given = DRAKE_SOLVERS[name](), SolverOptions()
    for option, value in options.items():
        given.SetOption(solver.solver_id(), option, value)

    def solve(problem: Problem) -> np.ndarray:
        result = solver.Solve(problem.drake.prog, None, given)
        return result.GetSolution(problem.drake.u)

    return solve


def _proxqp() -> Solve:
    from proxsuite import proxqp

    # Without a check of the duality gap, ProxQP accepts points that satisfy all
    # rows, but whose multipliers have the wrong sign.
    options = {
        "eps_abs": _PROXQP,
        "eps_rel": 0.0,
        "check_duality_gap": True,
        "eps_duality_gap_abs": _PROXQP,
        "eps_duality_gap_rel": 0.0,
    }

    def solve(problem: Problem) -> np.ndarray:
        H, c, A, b = problem.dense
        none = None
        return proxqp.dense.solve(H, c, none, none, A, none, b, **options).x

    return solve


def _daqp() -> Solve:
    import daqp

    return lambda problem: daqp.solve(*problem.dense)[0]


SOLVERS = {
    "active set": Solver(_active_set),
    "DAQP": Solver(_daqp, "daqp"),
    "ProxQP, dense": Solver(_proxqp, "proxsuite"),
    "Clarabel, Drake's": Solver(partial(_drakes, "clarabel")),
    "OSQP, Drake's": Solver(partial(_drakes, "osqp")),
    f"OSQP, Drake's, to {_OSQP:g}": Solver(
        partial(_drakes, "osqp", eps_abs=_OSQP, eps_rel=_OSQP)
    ),
}
"""All solvers, keyed by their names in tables. The first is that of this
package."""
