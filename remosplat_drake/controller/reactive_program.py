"""The quadratic program of one tick, built by its ingredients.

Decision variables are the command u and the slack delta of the end-effector
twist (paper section III-A); what is minimised and what must hold comes from
the ingredients, one small class each.
"""

import dataclasses as dc
from collections.abc import Container

import numpy as np
from pydrake.solvers import MathematicalProgram

from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.controller.active_set import solve_dense
from remosplat_drake.controller.drake_program import DrakeProgram, fill
from remosplat_drake.controller.program_data import (
    Label,
    ProgramData,
    Rows,
    Tracking,
)


class TermError(RemoSplatError, ValueError):
    """A term of the program has a name that is taken, or the wrong shape."""


class ReactiveProgram(ProgramData):
    """What the ingredients of one tick add to.

    The program minimises the sum of all costs over the command u, shape
    (n_u,), within the bounds and subject to all rows. A term's name may be
    used once for each kind of term.

    `prog` is the same program as Drake's `MathematicalProgram`, `dense` as
    matrices in u alone. An ingredient may add to `prog` itself what the
    methods here do not express; `dense` then leaves that out.

    Args:
        velocity_limit: Bounds on |u| to begin with, shape (n_u,) [rad/s, m/s].
        use_acceleration: Whether ingredients may add acceleration bounds.
        relax: Names of the sets of rows whose negative right-hand sides are
            raised to zero. Where these are all, u = 0 is feasible.

    Attributes:
        use_acceleration: Whether ingredients may add acceleration bounds.
        has_acceleration_bounds: Whether an ingredient has added acceleration
            bounds.
        relax: Names of the sets of rows whose negative right-hand sides are
            raised to zero.
        yielded: Names of the rows whose right-hand sides were raised.

    Example:
        >>> import remosplat_drake as rs
        >>> import numpy as np
        >>> program = rs.ReactiveProgram(np.ones(9))
        >>> program.add_quadratic_cost("stand still", np.ones(9))
        >>> program.add_linear_cost("turn left", -np.eye(9)[1])
    """

    def __init__(
        self,
        velocity_limit: np.ndarray,
        *,
        use_acceleration: bool = True,
        relax: Container[str] = (),
    ):
        super().__init__(velocity_limit)
        self.use_acceleration = use_acceleration
        self.has_acceleration_bounds = False
        self.relax = relax
        self.yielded: list[str] = []
        self._drake: DrakeProgram | None = None
        self._is_finished = False

    def add_linear_cost(self, name: str, c: np.ndarray) -> None:
        """Adds the cost c'u.

        Args:
            name: Name of the cost, unique among the linear costs.
            c: Vector of the cost, shape (n_u,).

        Raises:
            TermError: There is a linear cost of that name already, or c has
                another shape.
        """
        self._check("a linear cost", name, name in self.linear, c, (self.n_u,))
        self.linear[name] = c

    def add_quadratic_cost(self, name: str, weights: np.ndarray) -> None:
        """Adds the cost u' diag(weights) u / 2.

        Args:
            name: Name of the cost, unique among the quadratic costs.
            weights: Weights of the squared entries of u, shape (n_u,); none
                may be negative.

        Raises:
            TermError: There is a quadratic cost of that name already, or the
                weights have another shape.
        """
        taken = name in self.quadratic
        self._check("a quadratic cost", name, taken, weights, (self.n_u,))
        self.quadratic[name] = weights

    def add_rows(
        self,
        name: str,
        A: np.ndarray,
        b: np.ndarray,
        label: Label = "row {}".format,
    ) -> None:
        """Adds the rows A u <= b.

        Args:
            name: Name of the set of rows, unique among these.
            A: Coefficients of the rows, shape (m, n_u).
            b: Right-hand sides of the rows, shape (m,).
            label: Says what row i is about, for people: names of links or
                joints, or a text. It is asked only where the row must yield
                or holds the command back.

        Raises:
            TermError: There are rows of that name already, or A has another
                shape.
        """
        self._check(
            "a set of rows", name, name in self.rows, A, (len(b), self.n_u)
        )
        rows = Rows(A, b, np.ones(len(b), bool), label)
        if name in self.relax:
            self.yielded += rows.yielding(name)
            rows = dc.replace(rows, b=np.maximum(b, 0.0))
        self.rows[name] = rows

    def track(
        self,
        name: str,
        J: np.ndarray,
        V: np.ndarray,
        *,
        price: float,
        limit: np.ndarray,
    ) -> None:
        """Tracks the end effector's twist: J u + delta = V with a slack delta.

        The slack costs price |delta|^2 / 2. A twist is tracked in as many
        directions as there are rows: all six, or fewer.

        Args:
            name: Name of this tracking, unique among the trackings.
            J: Jacobian of the end effector in W, angular above
                translational, shape (6, n_u); or r directions of it.
            V: The wanted twist V_WE, angular above translational, shape (6,)
                [rad/s, m/s]; or the same directions of it, shape (r,).
            price: Weight of the squared slack in the cost.
            limit: Bounds on |delta|, shape (r,) [rad/s, m/s].

        Raises:
            TermError: There is a tracking of that name already, or J has
                another shape.
        """
        taken = name in self.trackings
        self._check("tracking", name, taken, J, (len(V), self.n_u))
        self.trackings[name] = Tracking(name, J, V, price, limit)

    def _check(
        self,
        kind: str,
        name: str,
        taken: bool,
        array: np.ndarray,
        shape: tuple[int, ...],
    ) -> None:
        if taken:
            raise TermError(f"there is {kind} {name!r} already")
        if np.shape(array) != shape:
            raise TermError(
                f"{name!r}: expected the shape {shape}, got {np.shape(array)}"
            )

    def finish(self):
        """Marks the rows that cannot bind, once all terms have been added.

        A row whose largest value within the bounds of u does not exceed b_i
        is redundant: leaving it out changes nothing but the solver's time.
        """
        for name, rows in self.rows.items():
            kept = self.can_bind(rows.A, rows.b)
            self.rows[name] = dc.replace(rows, kept=kept)
        self._is_finished = True
        if self._drake is not None:
            fill(self._drake, self)

    @property
    def is_hopeless(self) -> bool:
        """Whether it is known that no command satisfies all rows.

        Then no solver need be asked.
        """
        return False

    def optimum(self) -> tuple[np.ndarray, int]:
        """Solves `dense` by the library's own method.

        Returns:
            The optimal command u, shape (n_u,), which means something only
            where it ended so, and how it ended; see `active_set.solve_dense`.
        """
        u, _, ended = solve_dense(*self.dense())
        return u, ended

    @property
    def prog(self) -> MathematicalProgram:
        """The program as Drake's `MathematicalProgram`."""
        return self.drake.prog

    @property
    def drake(self) -> "DrakeProgram":
        """Drake's program and its variables, made when first asked for."""
        if self._drake is None:
            self._drake = DrakeProgram(self.n_u, extended=not self._is_finished)
            if self._is_finished:
                fill(self._drake, self)
        return self._drake

    @property
    def u(self) -> np.ndarray:
        """Drake's decision variables of the command, shape (n_u,)."""
        return self.drake.u

    @property
    def is_extended(self) -> bool:
        """Whether an ingredient has asked for `prog` and may have used it.

        What it has added, only Drake's program knows; `dense` does not.
        """
        return self._drake is not None and self._drake.extended
