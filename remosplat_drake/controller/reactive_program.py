"""The quadratic program of one tick, built by its ingredients.

Decision variables are the command u and the slack delta of the end-effector
twist (paper section III-A); what is minimised and what must hold comes from
the ingredients, one small class each.
"""

import dataclasses as dc
from collections.abc import Container

import numpy as np
from pydrake.solvers import MathematicalProgram

from remosplat_drake.controller.active_set import solve_dense
from remosplat_drake.controller.drake_program import (
    DrakeProgram,
    check_terms,
    fill,
)
from remosplat_drake.controller.program_data import (
    Label,
    ProgramData,
    Rows,
    Tracking,
)
from remosplat_drake.controller.term import Term


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
            NameTakenError: There is a linear cost of that name already.
            TermError: c has another shape, or is not finite.
        """
        term = Term("linear cost", name, self.linear)
        self.linear[name] = term.array("c", c, (self.n_u,))

    def add_quadratic_cost(self, name: str, weights: np.ndarray) -> None:
        """Adds the cost u' diag(weights) u / 2.

        Args:
            name: Name of the cost, unique among the quadratic costs.
            weights: Weights of the squared entries of u, shape (n_u,); none
                may be negative.

        Raises:
            NameTakenError: There is a quadratic cost of that name already.
            TermError: The weights have another shape, are not finite, or are
                negative.
        """
        term = Term("quadratic cost", name, self.quadratic)
        self.quadratic[name] = term.weights("weights", weights, (self.n_u,))

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
            NameTakenError: There are rows of that name already.
            TermError: A or b has another shape, or is not finite.
        """
        term = Term("set of rows", name, self.rows)
        m = np.size(b)
        A = term.array("A", A, (m, self.n_u))
        b = term.array("b", b, (m,))
        rows = Rows(A, b, np.ones(m, bool), label)
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
            limit: Bounds on |delta|, shape (r,) [rad/s, m/s]; inf is none.

        Raises:
            NameTakenError: There is a tracking of that name already.
            TermError: J, V, the price or the limit has another shape, is not
                finite or, of the last two, is negative.
        """
        term = Term("tracking", name, self.trackings)
        r = np.size(V)
        J = term.array("J", J, (r, self.n_u))
        V = term.array("V", V, (r,))
        price = float(term.weights("price", price, ()))
        limit = term.array("limit", limit, (r,), unbounded=True)
        if (limit < 0.0).any():
            raise term.error("limit is negative")
        self.trackings[name] = Tracking(name, J, V, price, limit)

    def narrow(self, lower: np.ndarray, upper: np.ndarray) -> None:
        """Bounds u by lower <= u <= upper, besides the present bounds.

        Args:
            lower: Further lower bounds, shape (n_u,); -inf is none.
            upper: Further upper bounds, shape (n_u,); inf is none.

        Raises:
            TermError: The bounds have another shape, are NaN, or leave nothing
                between them.
        """
        term = Term("bounds on u")
        lower = term.array("lower", lower, (self.n_u,), unbounded=True)
        upper = term.array("upper", upper, (self.n_u,), unbounded=True)
        if not ((lower <= upper) & (lower < np.inf) & (upper > -np.inf)).all():
            raise term.error("no command lies between lower and upper")
        self.lower = np.maximum(self.lower, lower)
        self.upper = np.minimum(self.upper, upper)

    def check_prog(self) -> None:
        """Checks what an ingredient has added to `prog` itself.

        Raises:
            TermError: A term there is not finite, or is a concave cost.
        """
        if self.is_extended and not self._is_finished:
            check_terms(self.prog)

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
