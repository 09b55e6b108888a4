"""`QuadraticProgram`: the program of a tick, as a solver takes it."""

import numpy as np
from pydrake.solvers import MathematicalProgram

from remosplat_drake.controller.program.active_set import (
    DenseProgram,
    solve_dense,
)
from remosplat_drake.controller.program.drake_program import (
    DrakeProgram,
    KeptProgram,
)
from remosplat_drake.controller.program.kernels.dense import dense
from remosplat_drake.controller.program.slack_form import SlackForm


class QuadraticProgram:
    """The complete quadratic program of a tick, as a solver takes it.

    It minimises a quadratic cost of the command u and of the slack delta of the
    end effectors' twists, subject to linear rows and bounds.

    Attributes:
        form: The program.
        extension: Drake's program, to which ingredients may have added terms
            that `form` does not contain; None if there is none.
    """

    def __init__(self, form: SlackForm, extension: DrakeProgram | None = None):
        """Stores the program.

        Args:
            form: The program.
            extension: Drake's program with further terms; None if there is
                none.
        """
        self.form, self.extension = form, extension
        self._filled: KeptProgram | None = None

    @property
    def n_u(self) -> int:
        """Number of entries of the command u."""
        return len(self.form.lower)

    @property
    def is_extended(self) -> bool:
        """Whether Drake's program may have terms that `form` lacks."""
        return self.extension is not None

    def dense(self) -> DenseProgram:
        """Returns the program in u alone; V - J u replaces the slack.

        The result does not include further terms of Drake's program.
        """
        return DenseProgram(*dense(*self.form))

    def optimum(self) -> tuple[np.ndarray, int]:
        """Solves the program `dense` with the library's own solver.

        Returns:
            The command u, shape (n_u,), and the status; see
            `active_set.solve_dense`. The command is optimal only if the status
            is OPTIMAL.
        """
        u, _, ended = solve_dense(*self.dense())
        return u, ended

    @property
    def prog(self) -> MathematicalProgram:
        """The program as Drake's `MathematicalProgram`, with all terms."""
        return self._drake.prog

    @property
    def u(self) -> np.ndarray:
        """The decision variables of the command in `prog`, shape (n_u,)."""
        return self._drake.u

    @property
    def _drake(self) -> KeptProgram:
        if self._filled is None:
            size = self.n_u, len(self.form.V)
            self._filled = KeptProgram(*size, self.extension)
            self._filled.fill(self.form)
        return self._filled
