"""The convex solvers that a scenario may use."""

from threading import local
from typing import Protocol

import numpy as np
from pydrake.solvers import (
    ClarabelSolver,
    GurobiSolver,
    MathematicalProgram,
    MosekSolver,
    OsqpSolver,
    ScsSolver,
    SolverInterface,
    SolverOptions,
)

from remosplat_drake.base.errors import FieldError, unknown_name
from remosplat_drake.controller.program.active_set import INFEASIBLE, OPTIMAL
from remosplat_drake.controller.program.drake_program import KeptProgram
from remosplat_drake.controller.program.quadratic_program import (
    QuadraticProgram,
)
from remosplat_drake.controller.program.slack_form import SlackForm
from remosplat_drake.controller.program.term import TermError

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
"""Names of all solvers; some solvers require a licence."""


class Solver(Protocol):
    """Protocol of a solver of the convex quadratic program of a tick."""

    def solve(self, program: QuadraticProgram) -> np.ndarray | None:
        """Returns the optimal command u, shape (n_u,); None if infeasible.

        Args:
            program: The complete program of a tick.
        """
        ...


class DrakeSolver:
    """One of Drake's solvers, which solves a `MathematicalProgram`.

    It keeps one `MathematicalProgram` for each thread, and sets its values at
    each tick. If an ingredient has added terms to Drake's program directly, it
    solves that program instead.

    Args:
        solver: The solver, which must be available and enabled.
    """

    def __init__(self, solver: SolverInterface):
        self._solver = solver
        self._kept = _KeptPrograms()
        self._attempts = _attempts(solver)

    def __reduce__(self):
        # Drake's solvers have no state, but do not support pickling.
        return _drake_solver, (type(self._solver),)

    def solve(self, program: QuadraticProgram) -> np.ndarray | None:
        """Returns the optimal command u, shape (n_u,); None if infeasible.

        Args:
            program: The complete program of a tick.

        Raises:
            TermError: An ingredient has added a term to `prog` that the solver
                does not support.
        """
        if program.is_extended:
            prog, variables = program.prog, program.u
            if not self._solver.AreProgramAttributesSatisfied(prog):
                why = self._solver.ExplainUnsatisfiedProgramAttributes(prog)
                raise TermError(f"prog: {why}")
        else:
            kept = self._kept.filled(program.form)
            prog, variables = kept.prog, kept.u
        for options in self._attempts:
            u = self._optimum(prog, variables, options)
            if u is not None:
                return u
        return None

    def _optimum(
        self,
        prog: MathematicalProgram,
        u: np.ndarray,
        options: SolverOptions | None,
    ) -> np.ndarray | None:
        result = self._solver.Solve(prog, None, options)  # pyright: ignore
        return result.GetSolution(u) if result.is_success() else None


class _KeptPrograms(local):
    """The `KeptProgram` of each thread."""

    program: KeptProgram | None = None

    def filled(self, form: SlackForm) -> KeptProgram:
        """Returns the thread's `KeptProgram` with the values of a tick."""
        n_u, r = len(form.lower), len(form.V)
        if self.program is None or not self.program.has_size(n_u, r):
            self.program = KeptProgram(n_u, r)
        self.program.fill(form)
        return self.program


def _attempts(solver: SolverInterface) -> tuple[SolverOptions | None, ...]:
    """Returns options of a solver, which are tried until the solver succeeds.

    For these small and well scaled programs, Clarabel is as exact without
    equilibration, presolve and refinement, and takes two thirds of the time. If
    it fails, it runs again with all three. OSQP's default tolerances cause
    errors of centimetres per second, so they are used only if OSQP fails with
    tighter tolerances.
    """
    options = SolverOptions()
    if isinstance(solver, ClarabelSolver):
        for name in (
            "equilibrate_enable",
            "presolve_enable",
            "iterative_refinement_enable",
        ):
            options.SetOption(solver.solver_id(), name, 0)
        return options, None
    if isinstance(solver, OsqpSolver):
        for name in ("eps_abs", "eps_rel"):
            options.SetOption(solver.solver_id(), name, 1e-6)
        return options, None
    return (None,)


def _drake_solver(maker: type[SolverInterface]) -> DrakeSolver:
    return DrakeSolver(maker())


class ActiveSetSolver:
    """The library's own dual active-set solver, for the dense program.

    It finds the same optimum as Clarabel in a tenth of the time. If its result
    is undecided because of rounding errors, or if an ingredient has used
    Drake's program, it calls Clarabel.
    """

    def __init__(self):
        self._other = DrakeSolver(ClarabelSolver())

    def solve(self, program: QuadraticProgram) -> np.ndarray | None:
        """Returns the optimal command u, shape (n_u,); None if infeasible.

        Args:
            program: The complete program of a tick.
        """
        if program.is_extended:
            return self._other.solve(program)
        u, ended = program.optimum()
        if ended == OPTIMAL:
            return u
        return None if ended == INFEASIBLE else self._other.solve(program)


def make_solver(name: str, where: str, field: str = "solver") -> Solver:
    """Makes the solver of a given name.

    Args:
        name: One of `SOLVERS`.
        where: Source of the name, such as a scenario's file; errors name this
            source.
        field: The field of `controller` that contains the name; errors name
            this field.

    Raises:
        FieldError: There is no such solver, or the solver cannot be used, for
            example because there is no licence.
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
