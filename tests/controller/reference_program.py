"""A tick's program and what is decided of it, slow and readable, in NumPy.

What runs are kernels; tests hold them against this.
"""

import dataclasses as dc
from collections.abc import Container, Iterator, Sequence

import numpy as np
from reference_ingredients import add_reference

from remosplat_drake.controller.ingredients import (
    JointLimitDamper,
    MoverDamper,
    SelfCollisionDamper,
)
from remosplat_drake.controller.program.active_set import (
    INFEASIBLE,
    OPTIMAL,
    DenseProgram,
    solve_dense,
)
from remosplat_drake.controller.program.ingredient import AnyIngredient
from remosplat_drake.controller.program.program_terms import Rows, row_name
from remosplat_drake.controller.program.quadratic_program import (
    QuadraticProgram,
)
from remosplat_drake.controller.program.reactive_program import ReactiveProgram
from remosplat_drake.controller.program.slack_form import SlackForm
from remosplat_drake.controller.program.solvers import Solver
from remosplat_drake.controller.program.tick import Tick
from remosplat_drake.robot.braking import braking_command
from remosplat_drake.signals import tick_report

YIELD_ORDER = tuple(
    kind.term for kind in (MoverDamper, JointLimitDamper, SelfCollisionDamper)
)
"""Names of the rows that yield first; those before the scene and of
ingredients from outside come last, together."""


class ReferenceProgram:
    """A tick's program, and the same with less demanded."""

    def __init__(
        self,
        tick: Tick,
        ingredients: Sequence[AnyIngredient],
        *,
        use_acceleration: bool = True,
        relax: Container[str] = (),
        task: float = 1.0,
    ):
        self.tick, self.ingredients = tick, ingredients
        added = ReactiveProgram(tick.robot.velocity_limit)
        for part in ingredients:
            add_reference(part, added, tick)
        self.has_acceleration_bounds = added._has_acceleration
        bounds = added.lower, added.upper
        self.lower, self.upper = bounds if use_acceleration else added._free
        self.share = 1.0
        self.terms, self.yielded = added.terms, []
        if relax:
            self._ease(relax)
        for name, tracking in self.terms.trackings.items():
            price = task * tracking.price
            self.terms.trackings[name] = dc.replace(tracking, price=price)
        for name, linear in self.terms.linear.items():
            self.terms.linear[name] = task * linear
        for name, rows in added.terms.rows.items():
            kept = self.can_bind(rows.A, rows.b)
            added.terms.rows[name] = dc.replace(rows, kept=kept)

    def _ease(self, relax: Container[str]) -> None:
        """Lets rows demand 0.9 of the greatest share of their retreats."""
        center, radius = self.lower + self.upper, self.upper - self.lower
        demands = {}
        for name, rows in self.rows.items():
            yields = (rows.b < 0) & (name in relax)
            self.yielded += [
                row_name(name, rows.about(i))
                for i in np.flatnonzero(yields).tolist()
            ]
            alone = 0.5 * (rows.A @ center - np.abs(rows.A) @ radius)
            most = np.maximum(rows.b, 0.5 * np.minimum(alone, 0.0))
            demands[name] = np.where(yields, most, rows.b), yields
        A = np.concatenate([rows.A for rows in self.rows.values()])
        b = np.concatenate([b for b, _ in demands.values()])
        yields = np.concatenate([of for _, of in demands.values()])
        self.share = greatest_share(A, b, yields, self.lower, self.upper)
        for name, (most, of) in demands.items():
            eased = np.where(of, 0.9 * max(self.share, 0.0) * most, most)
            self.rows[name] = dc.replace(self.rows[name], b=eased)

    @property
    def rows(self) -> dict[str, Rows]:
        return self.terms.rows

    @property
    def n_u(self) -> int:
        return len(self.lower)

    def weakened(
        self,
        *,
        use_acceleration: bool = True,
        relax: Container[str] = (),
        task: float = 1.0,
    ) -> "ReferenceProgram":
        return ReferenceProgram(
            self.tick,
            self.ingredients,
            use_acceleration=use_acceleration,
            relax=relax,
            task=task,
        )

    @property
    def weights(self) -> np.ndarray:
        """The diagonal of all quadratic costs together, shape (n_u,)."""
        return sum(self.terms.quadratic.values(), np.zeros(self.n_u))

    @property
    def slope(self) -> np.ndarray:
        """The vector of all linear costs together, shape (n_u,)."""
        return sum(self.terms.linear.values(), np.zeros(self.n_u))

    def dense(self) -> DenseProgram:
        """Returns the program in u alone, its slack replaced by V - J u."""
        H, c = np.diag(self.weights), self.slope
        eye = np.eye(self.n_u)
        A = [eye, -eye, *(rows.A[rows.kept] for rows in self.rows.values())]
        b = [self.upper, -self.lower]
        b += [rows.b[rows.kept] for rows in self.rows.values()]
        bounds: list[tuple[np.ndarray, np.ndarray]] = []
        for tracking in self.terms.trackings.values():
            J, V, limit = tracking.J, tracking.V, tracking.limit
            H += tracking.price * J.T @ J
            c = c - tracking.price * V @ J
            bounds += [(J, limit + V)]
        for tracking in self.terms.trackings.values():
            J, V, limit = tracking.J, tracking.V, tracking.limit
            bounds += [(-J, limit - V)]
        for slack_A, slack_b in bounds:
            kept = self.can_bind(slack_A, slack_b)
            A.append(slack_A[kept])
            b.append(slack_b[kept])
        return DenseProgram(H, c, np.concatenate(A), np.concatenate(b))

    @property
    def form(self) -> SlackForm:
        """The program with its slack, as few terms as it takes."""
        n_u, rows = self.n_u, self.rows.values()
        trackings = self.terms.trackings.values()
        J = np.concatenate([np.zeros((0, n_u)), *(t.J for t in trackings)])
        V = np.concatenate([np.zeros(0), *(t.V for t in trackings)])
        limit = np.concatenate([np.zeros(0), *(t.limit for t in trackings)])
        prices = [np.full(len(t.V), t.price) for t in trackings]
        is_low = self.can_bind(J, limit + V)
        is_high = self.can_bind(-J, limit - V)
        A = [np.zeros((0, n_u)), *(r.A[r.kept] for r in rows)]
        b = [np.zeros(0), *(r.b[r.kept] for r in rows)]
        return SlackForm(
            self.lower,
            self.upper,
            np.where(is_low, -limit, -np.inf),
            np.where(is_high, limit, np.inf),
            np.concatenate(A),
            np.concatenate(b),
            np.hstack([J, np.eye(len(V))]),
            V,
            np.diag(np.concatenate([self.weights, *prices])),
            np.concatenate([self.slope, np.zeros(len(V))]),
        )

    def can_bind(self, A: np.ndarray, b: np.ndarray) -> np.ndarray:
        """Finds the rows A u <= b that the bounds on u do not imply."""
        center = 0.5 * (self.upper + self.lower)
        radius = 0.5 * (self.upper - self.lower)
        return ~(A @ center + np.abs(A) @ radius <= b)

    def tight_rows(self, u: np.ndarray) -> list[tuple[str, int]]:
        """Finds the rows that are kept and hold with equality."""
        return [
            (name, i)
            for name, rows in self.rows.items()
            for i in np.flatnonzero(
                rows.kept & (rows.A @ u >= rows.b - 1e-4)
            ).tolist()
        ]

    def descent(self, u: np.ndarray) -> np.ndarray:
        """Direction in which the cost falls at u, shape (n_u,)."""
        push = -self.weights * u - self.slope
        for tracking in self.terms.trackings.values():
            missed = tracking.V - tracking.J @ u
            push = push + tracking.price * missed @ tracking.J
        return push


@dc.dataclass(frozen=True, eq=False)
class Decision:
    """A command, how it came about, and the program behind it."""

    u: np.ndarray
    status: str
    reason: str
    program: ReferenceProgram | None = None


def greatest_share(
    A: np.ndarray,
    b: np.ndarray,
    yields: np.ndarray,
    lower: np.ndarray,
    upper: np.ndarray,
) -> float:
    """Finds what `kernels.greatest_share` does; -1 where nothing is left.

    `test_share.py` holds that against a linear program, whose tolerances are
    too coarse for commands.
    """
    n, eye = len(lower), np.eye(len(lower) + 1)
    price = np.append(np.full(n, 1e-8), 1.0)
    rows = np.column_stack([A, np.where(yields, -b, 0.0)])
    share, _, ended = solve_dense(
        np.diag(price),
        -eye[n],
        np.concatenate([eye, -eye, rows]),
        np.concatenate([upper, [1.0], -lower, [0.0], np.where(yields, 0.0, b)]),
    )
    if ended == INFEASIBLE:
        return -1.0
    return float(np.clip(share[n], 0.0, 1.0)) if ended == OPTIMAL else 0.0


def decide(
    program: ReferenceProgram, solver: Solver, *, strict: bool = False
) -> Decision:
    """Decides as `kernels.decide` does."""
    u = solver.solve(QuadraticProgram(program.form))
    if u is not None:
        return Decision(u, tick_report.OPTIMAL, "", program)
    if program.has_acceleration_bounds:
        for names in _yielding(program, YIELD_ORDER[1:]):
            less = program.weakened(relax=names, task=1e-3)
            eased = _eased(less, solver)
            if eased:
                return eased
        less = program.weakened(use_acceleration=False)
        u = None if strict else solver.solve(QuadraticProgram(less.form))
        if u is not None:
            return Decision(u, tick_report.ACCELERATION_DROPPED, "", less)
    for names in _yielding(program, YIELD_ORDER):
        less = program.weakened(use_acceleration=strict, relax=names)
        eased = _eased(less, solver)
        if eased:
            return eased
    tick = program.tick
    limit = tick.robot.acceleration_limit
    ramp = braking_command(tick.u_previous, limit, tick.dt)
    return Decision(ramp, tick_report.BRAKING, "")


def _eased(less: ReferenceProgram, solver: Solver) -> Decision | None:
    u = None
    if less.share >= 0:
        u = solver.solve(QuadraticProgram(less.form))
    if u is None:
        return None
    reason = f"infeasible; yielded: {', '.join(less.yielded)}"
    return Decision(u, tick_report.RELAXED, reason, less)


def _yielding(
    program: ReferenceProgram, order: Sequence[str]
) -> Iterator[frozenset[str]]:
    """Yields the sets of rows that may yield together, fewest first."""
    retreats = {
        name for name, rows in program.rows.items() if (rows.b < 0.0).any()
    }
    last = retreats.difference(YIELD_ORDER)
    names: set[str] = set()
    for more in (*({name} for name in order), last):
        if more & retreats:
            names |= more
            yield frozenset(names)
