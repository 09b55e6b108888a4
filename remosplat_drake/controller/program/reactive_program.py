"""`ReactiveProgram`: the program to which a user's Python code adds terms.

The decision variables are the command u and the slack delta of the end
effectors' twists (paper section III-A). All costs and constraints are added by
ingredients, each of which is a small class.
"""

from collections.abc import Container
from functools import cache

import numpy as np
from pydrake.solvers import MathematicalProgram

from remosplat_drake.base.kernels.packed import Packed
from remosplat_drake.controller.program.drake_program import DrakeProgram
from remosplat_drake.controller.program.kernels.outside import (
    slack_form_of_outside,
)
from remosplat_drake.controller.program.kernels.tick_arrays import (
    OutsideArrays,
    OutsideRows,
)
from remosplat_drake.controller.program.program_terms import (
    Label,
    Rows,
    Terms,
    Tracking,
)
from remosplat_drake.controller.program.quadratic_program import (
    QuadraticProgram,
)
from remosplat_drake.controller.program.slack_form import SlackForm
from remosplat_drake.controller.program.term import Term


class ReactiveProgram:
    """The quadratic program to which ingredients in Python add their terms.

    The program minimises the sum of all costs over the command u, shape (n_u,),
    within the bounds and subject to all rows. Each term has a name. Two terms
    of the same kind must have different names.

    `prog` is a `MathematicalProgram` of Drake with the same command, for terms
    that the methods of this class do not support.

    Args:
        velocity_limit: Initial bounds of |u|, shape (n_u,) [rad/s, m/s].
        taken: Names of existing terms.

    Attributes:
        lower: Lower bounds on u, shape (n_u,).
        upper: Upper bounds on u, shape (n_u,).
        terms: The added terms.

    Example:
        >>> import remosplat_drake as rs
        >>> import numpy as np
        >>> program = rs.ReactiveProgram(np.ones(9))
        >>> program.add_quadratic_cost("stand still", np.ones(9))
        >>> program.add_linear_cost("turn left", -np.eye(9)[1])
        >>> u, _ = program.finished().optimum()
        >>> round(float(u[1]), 3)
        1.0
    """

    def __init__(self, velocity_limit: np.ndarray, taken: Container[str] = ()):
        self.lower, self.upper = -velocity_limit, velocity_limit
        self.terms = Terms()
        self._taken = taken
        self._free = self.lower, self.upper
        self._has_acceleration = False
        self._drake: DrakeProgram | None = None

    @staticmethod
    def within(bounds: np.ndarray, taken: Container[str]) -> "ReactiveProgram":
        """Makes a program with given bounds.

        Args:
            bounds: Four rows, shape (4, n_u): lower and upper bounds of u, and
                then both without acceleration bounds.
            taken: Names of existing terms.
        """
        lower, upper, free_lower, free_upper = bounds
        program = ReactiveProgram(upper, taken)
        program.lower, program.upper = lower, upper
        program._free = free_lower, free_upper
        return program

    @property
    def n_u(self) -> int:
        """Number of entries of the command u."""
        return len(self.lower)

    def add_linear_cost(self, name: str, c: np.ndarray) -> None:
        """Adds the cost c'u.

        Args:
            name: Name of the cost, unique among the linear costs.
            c: Vector of the cost, shape (n_u,).

        Raises:
            NameTakenError: A linear cost of this name exists.
            TermError: c has another shape, or is not finite.
        """
        term = self._term("linear cost", name, self.terms.linear)
        self.terms.linear[name] = term.array("c", c, (self.n_u,))

    def add_quadratic_cost(self, name: str, weights: np.ndarray) -> None:
        """Adds the cost u' diag(weights) u / 2.

        Args:
            name: Name of the cost, unique among the quadratic costs.
            weights: Weights of the squared entries of u, shape (n_u,), not
                negative.

        Raises:
            NameTakenError: A quadratic cost of this name exists.
            TermError: The weights have another shape, are not finite, or are
                negative.
        """
        term = self._term("quadratic cost", name, self.terms.quadratic)
        weights = term.weights("weights", weights, (self.n_u,))
        self.terms.quadratic[name] = weights

    def add_rows(
        self,
        name: str,
        A: np.ndarray,
        b: np.ndarray,
        label: Label = "row {}".format,
    ) -> None:
        """Adds the rows A u <= b.

        Args:
            name: Name of the set of rows, unique among the sets of rows.
            A: Coefficients of the rows, shape (m, n_u).
            b: Right-hand sides of the rows, shape (m,).
            label: Function that returns the subject of row i for display: names
                of links or joints, or a text. It is called only for rows that
                are relaxed or active.

        Raises:
            NameTakenError: A set of rows of this name exists.
            TermError: A or b has another shape, or is not finite.
        """
        term = self._term("set of rows", name, self.terms.rows)
        m = np.size(b)
        A = term.array("A", A, (m, self.n_u))
        b = term.array("b", b, (m,))
        self.terms.rows[name] = Rows(A, b, np.ones(m, bool), label)

    def track(
        self,
        name: str,
        J: np.ndarray,
        V: np.ndarray,
        *,
        price: float,
        limit: np.ndarray,
    ) -> None:
        """Tracks an end effector's twist: J u + delta = V with a slack delta.

        The slack adds 0.5 * price * |delta|^2 to the program's cost. J has one
        row for each tracked direction, and at most six rows.

        Args:
            name: Name of this constraint, unique among those that track a
                twist.
            J: Jacobian of the end effector in W, angular before translational,
                shape (6, n_u); or its rows for r directions.
            V: The desired twist V_WE, angular before translational, shape (6,)
                [rad/s, m/s]; or its entries for the same r directions.
            price: Weight of the squared slack in the cost.
            limit: Bounds of |delta|, shape (r,) [rad/s, m/s]; inf for no bound.

        Raises:
            NameTakenError: A constraint of this name tracks a twist already.
            TermError: J, V, the price or the limit has another shape or is not
                finite, or the price or the limit is negative.
        """
        term = self._term("tracking", name, self.terms.trackings)
        r = np.size(V)
        J = term.array("J", J, (r, self.n_u))
        V = term.array("V", V, (r,))
        price = float(term.weights("price", price, ()))
        limit = term.array("limit", limit, (r,), unbounded=True)
        if (limit < 0.0).any():
            raise term.error("limit is negative")
        self.terms.trackings[name] = Tracking(name, J, V, price, limit)

    def narrow(
        self,
        lower: np.ndarray,
        upper: np.ndarray,
        *,
        acceleration: bool = False,
    ) -> None:
        """Bounds u by lower <= u <= upper, in addition to the present bounds.

        Args:
            lower: Further lower bounds, shape (n_u,); -inf for no bound.
            upper: Further upper bounds, shape (n_u,); inf for no bound.
            acceleration: Whether the new bounds are acceleration bounds, which
                may be dropped if no command satisfies all rows.

        Raises:
            TermError: The bounds have another shape, are NaN, or exclude every
                command within the present bounds.
        """
        term = Term("bounds on u")
        lower = term.array("lower", lower, (self.n_u,), unbounded=True)
        upper = term.array("upper", upper, (self.n_u,), unbounded=True)
        if not ((lower <= upper) & (lower < np.inf) & (upper > -np.inf)).all():
            raise term.error("no command lies between lower and upper")
        self.lower = np.maximum(self.lower, lower)
        self.upper = np.minimum(self.upper, upper)
        self._has_acceleration |= acceleration
        if not acceleration:
            least, most = self._free
            self._free = np.maximum(least, lower), np.minimum(most, upper)

    def _term(self, kind: str, name: str, taken: Container[str]) -> Term:
        return Term(kind, name, (name,) if name in self._taken else taken)

    @property
    def prog(self) -> MathematicalProgram:
        """A `MathematicalProgram` of Drake, for other kinds of terms.

        It contains the variables `u`, and the terms that ingredients have added
        to it directly. It does not contain the terms that the methods of this
        class have added.
        """
        return self._extension.prog

    @property
    def u(self) -> np.ndarray:
        """The decision variables of the command in `prog`, shape (n_u,)."""
        return self._extension.u

    @property
    def _extension(self) -> DrakeProgram:
        if self._drake is None:
            self._drake = DrakeProgram(self.n_u)
        return self._drake

    @property
    def extension(self) -> DrakeProgram | None:
        """The `DrakeProgram` of `prog`; None if no ingredient uses `prog`."""
        return self._drake

    def write(
        self, bounds: np.ndarray, costs: np.ndarray, flags: np.ndarray
    ) -> None:
        """Writes bounds and costs into given arrays; see `OutsideArrays`.

        Args:
            bounds: Output: bounds on u, shape (4, n_u).
            costs: Output: sums of the costs, initially zero, shape (2, n_u).
            flags: Output: the flags of `OutsideArrays`, shape (2,), bool.
        """
        bounds[0], bounds[1] = self.lower, self.upper
        bounds[2], bounds[3] = self._free
        for c in self.terms.linear.values():
            costs[0] += c
        for weights in self.terms.quadratic.values():
            costs[1] += weights
        flags[0], flags[1] = self._has_acceleration, self._drake is not None

    @property
    def more(self) -> Packed[OutsideRows]:
        """The rows and tracked twists, packed for kernels."""
        terms, n_u = self.terms, self.n_u
        if not (terms.rows or terms.trackings):
            return _no_rows(n_u)
        rows = [np.column_stack([r.A, r.b]) for r in terms.rows.values()]
        tracked = [
            np.column_stack([t.J, t.V, t.limit, np.full(len(t.V), t.price)])
            for t in terms.trackings.values()
        ]
        none = _no_rows(n_u)
        return Packed(
            OutsideRows(
                np.concatenate([none.rows, *rows]),
                np.concatenate([none.tracked, *tracked]),
            )
        )

    @property
    def arrays(self) -> Packed[OutsideArrays]:
        """All added terms, packed for kernels."""
        bounds, costs = np.empty((4, self.n_u)), np.zeros((2, self.n_u))
        flags = np.zeros(2, bool)
        self.write(bounds, costs, flags)
        return Packed(OutsideArrays(bounds, costs, flags, self.more.values))

    def finished(self) -> QuadraticProgram:
        """Returns a program of these terms alone, as a solver takes it."""
        form = SlackForm(*slack_form_of_outside(self.arrays))
        return QuadraticProgram(form, self._drake)


@cache
def _no_rows(n_u: int) -> Packed[OutsideRows]:
    return Packed(OutsideRows(np.zeros((0, n_u + 1)), np.zeros((0, n_u + 3))))
