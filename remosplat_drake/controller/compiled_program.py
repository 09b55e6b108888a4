"""`CompiledProgram`: the program of a tick as kernels have put it together."""

import dataclasses as dc
from collections.abc import Container, Iterator, Sequence
from functools import cached_property

import numpy as np

from remosplat_drake.controller.active_set import DenseProgram
from remosplat_drake.controller.kernels.binding_arrays import (
    BOUND_PART,
    binding_arrays,
)
from remosplat_drake.controller.kernels.compiled_ingredient import (
    CompiledIngredient,
)
from remosplat_drake.controller.kernels.dense import (
    HOPELESS,
    dense,
    slack_form,
    solve_program,
)
from remosplat_drake.controller.kernels.tick_arrays import ProgramArrays
from remosplat_drake.controller.law_program import LawProgram
from remosplat_drake.controller.program_data import (
    Rows,
    Terms,
    Tracking,
    names_of,
    tracking_name,
)
from remosplat_drake.controller.slack_form import SlackForm
from remosplat_drake.controller.tick import Tick
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.scene.mover import Movers
from remosplat_drake.signals.binding import (
    BOUND,
    NONE_BINDS,
    Binding,
    BoundRow,
)


class CompiledProgram(LawProgram):
    """The finished program whose terms kernels have added.

    It answers as a `ReactiveProgram` with the same terms, and solvers and
    reports can use the arrays directly.

    Attributes:
        arrays: The terms.
    """

    def __init__(
        self,
        arrays: ProgramArrays,
        ingredients: Sequence[CompiledIngredient],
        tick: Tick,
    ):
        """Takes the terms over.

        Args:
            arrays: The terms.
            ingredients: The ingredients, in the kernels' order; their terms
                have different names.
            tick: What is known at the tick.
        """
        super().__init__(tick.robot.velocity_limit)
        self.arrays = arrays
        self._ingredients, self._tick = ingredients, tick
        self.lower, self.upper = arrays.lower, arrays.upper
        self.has_acceleration_bounds = bool(arrays.count[2])
        self._is_finished = True

    @cached_property
    def terms(self) -> Terms:
        """Costs, rows and trackings, named when they are first asked for."""
        arrays, terms = self.arrays, Terms()
        has, spans = arrays.has.tolist(), arrays.rows.tolist()
        for k, part in enumerate(self._ingredients):
            is_linear, is_quadratic = has[k]
            if is_linear:
                terms.linear[part.term] = arrays.linear[k]
            if is_quadratic:
                terms.quadratic[part.term] = arrays.quadratic[k]
            first, last = spans[k]
            if first < last:
                span = slice(first, last)
                terms.rows[part.term] = Rows(
                    arrays.A[span],
                    arrays.b[span],
                    arrays.kept[span],
                    _Labels(part, self._tick, arrays.about[span]),
                )
        tracker = int(arrays.count[1])
        if tracker:
            term = self._ingredients[tracker - 1].term
            terms.trackings.update(self._trackings(term))
        return terms

    def _trackings(self, term: str) -> Iterator[tuple[str, Tracking]]:
        arrays, first = self.arrays, 0
        for effector, last in enumerate(arrays.tracked.tolist()):
            if last == first:
                continue
            name = tracking_name(term, self._tick.robot.effectors[effector])
            span = slice(first, last)
            yield (
                name,
                Tracking(
                    name,
                    arrays.J[span],
                    arrays.V[span],
                    float(arrays.price[first]),
                    arrays.limit[span],
                ),
            )
            first = last

    def weakened(
        self, *, use_acceleration: bool = True, relax: Container[str] = ()
    ) -> "CompiledProgram":
        """Returns the program with less demanded; see `LawProgram`."""
        arrays = self.arrays
        b, count = arrays.b.copy(), arrays.count.copy()
        if not use_acceleration:
            count[2] = 0
            free = {"lower": arrays.free_lower, "upper": arrays.free_upper}
            arrays = arrays._replace(**free)
        yielded = []
        for name, rows in self.rows.items():
            if name in relax:
                yielded += rows.yielding(name)
        for part, (first, last) in zip(
            self._ingredients, arrays.rows.tolist(), strict=True
        ):
            if part.term in relax:
                b[first:last] = np.maximum(b[first:last], 0.0)
        arrays = arrays._replace(b=b, count=count, kept=arrays.kept.copy())
        program = CompiledProgram(arrays, self._ingredients, self._tick)
        program.use_acceleration, program.relax = use_acceleration, relax
        program.yielded = yielded
        A, b = arrays.A[: count[0]], b[: count[0]]
        arrays.kept[: count[0]] = program.can_bind(A, b)
        arrays.count[4] = not program.excess(A, b) <= HOPELESS
        return program

    @property
    def is_hopeless(self) -> bool:
        """Whether a row cannot hold within the bounds, as kernels have seen."""
        return bool(self.arrays.count[4])

    def dense(self) -> DenseProgram:
        """Returns the program in u alone, its slack replaced by V - J u."""
        return DenseProgram(*dense(self.arrays))

    def slack_form(self) -> SlackForm:
        """Returns the program with its slack, as few terms as it takes."""
        return SlackForm(*slack_form(self.arrays))

    def kept(self, name: str) -> np.ndarray:
        """Returns which of a set's rows are in the program, shape (m,), bool.

        Args:
            name: Name of the set, which has no rows where there is none.
        """
        for part, (first, last) in zip(
            self._ingredients, self.arrays.rows.tolist(), strict=True
        ):
            if part.term == name and first < last:
                return self.arrays.kept[first:last]
        return np.zeros(0, bool)

    def optimum(self) -> tuple[np.ndarray, int]:
        """Solves `dense` by the library's own method.

        Returns:
            The optimal command u, shape (n_u,), which means something only
            where it ended so, and how it ended; see `active_set.solve_dense`.
        """
        return solve_program(self.arrays)

    def binding(self, u: np.ndarray, tolerance: float) -> Binding:
        """Finds the rows that hold with equality; see `find_binding`.

        Args:
            u: The optimum, shape (n_u,).
            tolerance: By how much less than b a row may be [m/s, rad/s].
        """
        found = binding_arrays(self.arrays, u, tolerance)
        robot, movers = self._tick.robot, self._tick.movers
        return named_binding(self._ingredients, robot, movers, *found)


def named_binding(
    ingredients: Sequence[CompiledIngredient],
    robot: RobotModel,
    movers: Movers | None,
    tight: np.ndarray,
    A: np.ndarray,
    push: np.ndarray,
) -> Binding:
    """Names the rows that a kernel has found to hold with equality.

    Args:
        ingredients: The ingredients, in the kernels' order.
        robot: The robot that is driven.
        movers: What moves; None if nothing is known to.
        tight: The rows, as `binding_arrays` returns them.
        A: Their coefficients, shape (k, n_u).
        push: Direction in which the cost falls, shape (n_u,).
    """
    if not len(tight):
        return NONE_BINDS
    rows = []
    for number, index, about in tight.tolist():
        if number == BOUND_PART:
            rows.append(BoundRow(BOUND, index, ()))
            continue
        part = ingredients[number]
        names = names_of(part.about(robot, movers, about))
        rows.append(BoundRow(part.term, index, names))
    return Binding(tuple(rows), A, push)


@dc.dataclass(frozen=True, eq=False)
class _Labels:
    """Says what rows that a kernel has added are about.

    Attributes:
        part: The ingredient that they are of.
        tick: What is known at the tick.
        number: What the kernel has noted of each row, shape (m,).
    """

    part: CompiledIngredient
    tick: Tick
    number: np.ndarray

    def __call__(self, i: int) -> str | tuple[str, ...]:
        """Says what row i is about."""
        robot, movers = self.tick.robot, self.tick.movers
        return self.part.about(robot, movers, int(self.number[i]))
