"""Which convex solvers may be named in a scenario."""

import numpy as np
from pydrake.solvers import (
    ClarabelSolver,
    GurobiSolver,
    MosekSolver,
    OsqpSolver,
    ScsSolver,
    SolverInterface,
)

from remosplat_drake.base.errors import FieldError, unknown_name
from remosplat_drake.controller.active_set import (
    INFEASIBLE,
    OPTIMAL,
    solve_dense,
)
from remosplat_drake.controller.decision import Solver
from remosplat_drake.controller.reactive_program import ReactiveProgram

DRAKE_SOLVERS = {
    "clarabel": ClarabelSolver,
    "osqp": OsqpSolver,
    "scs": ScsSolver,
    "mosek": MosekSolver,
    "gurobi": GurobiSolver,
}

ACTIVE_SET = "active_set"

SOLVERS = (ACTIVE_SET, *DRAKE_SOLVERS)
"""All names; which of them work here is a matter of licences."""


class DrakeSolver:
    """One of Drake's solvers, on the `MathematicalProgram`."""

    def __init__(self, solver: SolverInterface):
        self._solver = solver

    def __reduce__(self):
        # Drake's solvers hold nothing, but do not know how to be pickled.
        return _drake_solver, (type(self._solver),)

    def solve(self, program: ReactiveProgram) -> np.ndarray | None:
        """See `Solver`."""
        result = self._solver.Solve(program.prog, None, None)  # pyright: ignore
        if not result.is_success():
            return None
        return result.GetSolution(program.drake.u)


def _drake_solver(maker: type[SolverInterface]) -> DrakeSolver:
    return DrakeSolver(maker())


class ActiveSetSolver:
    """Ours, on the dense program; Clarabel where that does not decide.

    Same optimum, ten times as fast: what rollouts need.
    """

    def __init__(self):
        self._other = DrakeSolver(ClarabelSolver())

    def solve(self, program: ReactiveProgram) -> np.ndarray | None:
        """See `Solver`."""
        if program.is_extended:
            return self._other.solve(program)
        u, _, ended = solve_dense(*program.dense())
        if ended == OPTIMAL:
            return u
        return None if ended == INFEASIBLE else self._other.solve(program)


def make_solver(name: str, where: str, field: str = "solver") -> Solver:
    """The solver of that name.

    Raises:
        FieldError: There is none, or it is not usable here (no licence).
    """
    if name == ACTIVE_SET:
        return ActiveSetSolver()
    usable = [
        key
        for key, maker in DRAKE_SOLVERS.items()
        if maker().available() and maker().enabled()
    ]
    if name not in usable:
        raise FieldError(
            where,
            f"controller.{field}",
            unknown_name("solver", name, [ACTIVE_SET, *usable]),
        )
    return DrakeSolver(DRAKE_SOLVERS[name]())
