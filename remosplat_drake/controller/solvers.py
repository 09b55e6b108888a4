"""Which convex solvers may be named in a scenario."""

from pydrake.solvers import (
    ClarabelSolver,
    GurobiSolver,
    MosekSolver,
    OsqpSolver,
    ScsSolver,
    SolverInterface,
)

from remosplat_drake.errors import FieldError, unknown_name

SOLVERS = {
    "clarabel": ClarabelSolver,
    "osqp": OsqpSolver,
    "scs": ScsSolver,
    "mosek": MosekSolver,
    "gurobi": GurobiSolver,
}


def make_solver(name: str, where: str) -> SolverInterface:
    """The solver of that name.

    Raises:
        FieldError: There is none, or it is not usable here (no licence).
    """
    usable = [
        key
        for key, maker in SOLVERS.items()
        if maker().available() and maker().enabled()
    ]
    if name not in usable:
        raise FieldError(
            where, "controller.solver", unknown_name("solver", name, usable)
        )
    return SOLVERS[name]()
