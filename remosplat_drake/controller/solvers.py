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
)
from remosplat_drake.controller.decision import Solver
from remosplat_drake.controller.reactive_program import ReactiveProgram

CLARABEL = "clarabel"

DRAKE_SOLVERS = {
    CLARABEL: ClarabelSolver,
    "osqp": OsqpSolver,
    "scs": ScsSolver,
    "mosek": MosekSolver,
    "gurobi": GurobiSolver,
}

ACTIVE_SET = "active_set"

SOLVERS = (ACTIVE_SET, *DRAKE_SOLVERS)
"""All names of solvers; whether some of them work depends on licences."""


class DrakeSolver:
    """One of Drake's solvers, which solves the `MathematicalProgram`.

    Args:
        solver: The solver, which must be available and enabled.
    """

    def __init__(self, solver: SolverInterface):
        self._solver = solver

    def __reduce__(self):
        # Drake's solvers hold nothing, but do not know how to be pickled.
        return _drake_solver, (type(self._solver),)

    def solve(self, program: ReactiveProgram) -> np.ndarray | None:
        """Finds the optimal command u, shape (n_u,); None if there is none.

        Args:
            program: The finished program of a tick.
        """
        result = self._solver.Solve(program.prog, None, None)  # pyright: ignore
        if not result.is_success():
            return None
        return result.GetSolution(program.drake.u)


def _drake_solver(maker: type[SolverInterface]) -> DrakeSolver:
    return DrakeSolver(maker())


class ActiveSetSolver:
    """The library's own dual active-set solver, on the dense program.

    It finds the same optimum ten times as fast, which rollouts need. Clarabel
    takes over where rounding leaves it undecided, and where an ingredient has
    used Drake's program.
    """

    def __init__(self):
        self._other = DrakeSolver(ClarabelSolver())

    def solve(self, program: ReactiveProgram) -> np.ndarray | None:
        """Finds the optimal command u, shape (n_u,); None if there is none.

        Args:
            program: The finished program of a tick.
        """
        if program.is_extended:
            return self._other.solve(program)
        u, ended = program.optimum()
        if ended == OPTIMAL:
            return u
        return None if ended == INFEASIBLE else self._other.solve(program)


def make_solver(name: str, where: str, field: str = "solver") -> Solver:
    """Makes the solver of that name.

    Args:
        name: One of `SOLVERS`.
        where: What errors blame, for example a scenario's file.
        field: The field of `controller` that errors blame.

    Raises:
        FieldError: There is no such solver, or it is not usable here, for
            example without a licence.
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
