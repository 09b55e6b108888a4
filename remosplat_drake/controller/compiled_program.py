"""`CompiledProgram`: the program of a tick as kernels have put it together."""

import dataclasses as dc
from collections.abc import Container, Sequence

import numpy as np

from remosplat_drake.controller.active_set import DenseProgram
from remosplat_drake.controller.kernels.compiled_ingredient import (
    CompiledIngredient,
)
from remosplat_drake.controller.kernels.dense import (
    HOPELESS,
    dense,
    solve_program,
    tight_rows,
)
from remosplat_drake.controller.kernels.tick_arrays import ProgramArrays
from remosplat_drake.controller.program_data import (
    Rows,
    Tracking,
    tracking_name,
)
from remosplat_drake.controller.reactive_program import ReactiveProgram
from remosplat_drake.controller.tick import Tick


class CompiledProgram(ReactiveProgram):
    """The finished program whose terms kernels have added.

    It answers as a `ReactiveProgram` that `build_program` has built of the
    same ingredients, and solvers and reports can use the arrays directly.

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
        self._take_costs_and_rows()
        _, tracker, accelerates, *_ = arrays.count.tolist()
        if tracker:
            self._take_trackings(ingredients[tracker - 1].term)
        self.has_acceleration_bounds = bool(accelerates)
        self._is_finished = True

    def _take_costs_and_rows(self) -> None:
        arrays = self.arrays
        has, spans = arrays.has.tolist(), arrays.rows.tolist()
        for k, part in enumerate(self._ingredients):
            is_linear, is_quadratic = has[k]
            if is_linear:
                self.add_linear_cost(part.term, arrays.linear[k])
            if is_quadratic:
                self.add_quadratic_cost(part.term, arrays.quadratic[k])
            first, last = spans[k]
            if first < last:
                span = slice(first, last)
                self.rows[part.term] = Rows(
                    arrays.A[span],
                    arrays.b[span],
                    arrays.kept[span],
                    _Labels(part, self._tick, arrays.about[span]),
                )

    def _take_trackings(self, term: str) -> None:
        arrays, first = self.arrays, 0
        for effector, last in enumerate(arrays.tracked.tolist()):
            if last == first:
                continue
            name = tracking_name(term, self._tick.robot.effectors[effector])
            span = slice(first, last)
            self.trackings[name] = Tracking(
                name,
                arrays.J[span],
                arrays.V[span],
                float(arrays.price[first]),
                arrays.limit[span],
            )
            first = last

    def weakened(
        self, *, use_acceleration: bool = True, relax: Container[str] = ()
    ) -> "CompiledProgram":
        """Returns the program with less demanded, as `build_program` builds it.

        Args:
            use_acceleration: Whether acceleration bounds stay.
            relax: Names of the sets of rows whose negative right-hand sides
                are raised to zero.
        """
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
        arrays.count[4] = program.excess(A, b) > HOPELESS
        return program

    def opened(self) -> ReactiveProgram:
        """Returns an unfinished program of the same terms, to add more to."""
        program = ReactiveProgram(self._tick.robot.velocity_limit)
        program.lower, program.upper = self.lower, self.upper
        program.rows, program.trackings = self.rows, self.trackings
        program.linear, program.quadratic = self.linear, self.quadratic
        program.has_acceleration_bounds = self.has_acceleration_bounds
        return program

    @property
    def is_hopeless(self) -> bool:
        """Whether a row cannot hold within the bounds, as kernels have seen."""
        return bool(self.arrays.count[4])

    def dense(self) -> DenseProgram:
        """Returns the program in u alone, its slack replaced by V - J u."""
        return DenseProgram(*dense(self.arrays))

    def optimum(self) -> tuple[np.ndarray, int]:
        """Solves `dense` by the library's own method.

        Returns:
            The optimal command u, shape (n_u,), which means something only
            where it ended so, and how it ended; see `active_set.solve_dense`.
        """
        return solve_program(self.arrays)

    def tight_rows(
        self, u: np.ndarray, tolerance: float
    ) -> list[tuple[str, int]]:
        """Finds the rows that are kept and hold with equality.

        Args:
            u: A command, shape (n_u,).
            tolerance: By how much less than b a row may be [m/s, rad/s].

        Returns:
            The name of each one's set, and its number in that.
        """
        numbers = tight_rows(self.arrays, u, tolerance).tolist()
        if not numbers:
            return []
        spans = zip(self._ingredients, self.arrays.rows.tolist(), strict=True)
        return [
            (part.term, i - first)
            for part, (first, last) in spans
            for i in numbers
            if first <= i < last
        ]


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
        return self.part.about(self.tick, int(self.number[i]))
