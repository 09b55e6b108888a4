"""`TickProgram`: the program of a tick, and the subjects of its terms."""

import dataclasses as dc
from collections.abc import Iterator, Sequence
from functools import cached_property

import numpy as np

from remosplat_drake.controller.program.compiled_ingredient import (
    CompiledIngredient,
)
from remosplat_drake.controller.program.kernels.dense import slack_form
from remosplat_drake.controller.program.kernels.tick_arrays import ProgramArrays
from remosplat_drake.controller.program.program_terms import (
    Rows,
    Terms,
    Tracking,
    names_of,
    tracking_name,
)
from remosplat_drake.controller.program.quadratic_program import (
    QuadraticProgram,
)
from remosplat_drake.controller.program.reactive_program import ReactiveProgram
from remosplat_drake.controller.program.slack_form import SlackForm
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.scene.mover import Movers

RowName = tuple[str, int, tuple[str, ...]]
"""The name of a set of rows, the index of a row in the set, and the subject of
the row."""


@dc.dataclass(frozen=True, eq=False)
class RowNames:
    """Converts the numbers by which kernels identify rows into names.

    Attributes:
        ingredients: The compiled ingredients, in the kernels' order.
        robot: The robot that is driven.
        movers: The movers; None if none are known.
        outside: The terms of ingredients in Python; None if there are none.
    """

    ingredients: Sequence[CompiledIngredient]
    robot: RobotModel
    movers: Movers | None
    outside: ReactiveProgram | None

    def name(self, part: int, index: int, about: int) -> RowName:
        """Returns the name of a row.

        Args:
            part: Number of the row's ingredient.
            index: The row's index among the rows of the ingredient.
            about: `ProgramArrays.about` of the row.
        """
        if part < len(self.ingredients):
            ingredient = self.ingredients[part]
            said = ingredient.about(self.robot, self.movers, about)
            return ingredient.term, index, names_of(said)
        assert self.outside is not None
        for name, rows in self.outside.terms.rows.items():
            if about < len(rows.b):
                return name, about, rows.about(about)
            about -= len(rows.b)
        raise IndexError(about)


class TickProgram(QuadraticProgram):
    """The quadratic program of a tick, with all its terms by name.

    Attributes:
        arrays: The terms, which kernels have assembled.
    """

    def __init__(self, arrays: ProgramArrays, names: RowNames):
        """Stores the terms.

        Args:
            arrays: The terms.
            names: Object that returns the names of rows.
        """
        extension = None if names.outside is None else names.outside.extension
        super().__init__(SlackForm(*slack_form(arrays)), extension)
        self.arrays, self._names = arrays, names

    @property
    def lower(self) -> np.ndarray:
        """Lower bounds on u, shape (n_u,) [rad/s, m/s]."""
        return self.arrays.lower

    @property
    def upper(self) -> np.ndarray:
        """Upper bounds on u, shape (n_u,) [rad/s, m/s]."""
        return self.arrays.upper

    @property
    def has_acceleration_bounds(self) -> bool:
        """Whether some of the bounds are acceleration bounds."""
        return bool(self.arrays.count[2])

    @property
    def is_hopeless(self) -> bool:
        """Whether every command within the bounds violates some row."""
        return bool(self.arrays.count[4])

    @cached_property
    def terms(self) -> Terms:
        """All costs, rows and trackings."""
        arrays, terms = self.arrays, Terms()
        has, spans = arrays.has.tolist(), arrays.rows.tolist()
        for k, part in enumerate(self._names.ingredients):
            is_linear, is_quadratic = has[k]
            if is_linear:
                terms.linear[part.term] = arrays.linear[k]
            if is_quadratic:
                terms.quadratic[part.term] = arrays.quadratic[k]
            if spans[k][0] < spans[k][1]:
                terms.rows[part.term] = self._rows(k, *spans[k])
        tracker = int(arrays.count[1])
        if tracker:
            term = self._names.ingredients[tracker - 1].term
            terms.trackings.update(self._trackings(term))
        if self._names.outside is not None:
            self._add_outside(terms, self._names.outside.terms)
        return terms

    def _rows(self, k: int, first: int, last: int) -> Rows:
        arrays, span = self.arrays, slice(first, last)

        def label(i: int) -> tuple[str, ...]:
            return self._names.name(k, i, int(arrays.about[first + i]))[2]

        return Rows(arrays.A[span], arrays.b[span], arrays.kept[span], label)

    def _trackings(self, term: str) -> Iterator[tuple[str, Tracking]]:
        arrays, first = self.arrays, 0
        for effector, last in enumerate(arrays.tracked.tolist()):
            if last == first:
                continue
            name = tracking_name(term, self._names.robot.effectors[effector])
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

    def _add_outside(self, terms: Terms, outside: Terms) -> None:
        terms.linear.update(outside.linear)
        terms.quadratic.update(outside.quadratic)
        terms.trackings.update(outside.trackings)
        first = int(self.arrays.rows[-1, 0])
        for name, rows in outside.rows.items():
            span = slice(first, first + len(rows.b))
            terms.rows[name] = dc.replace(
                rows, b=self.arrays.b[span], kept=self.arrays.kept[span]
            )
            first = span.stop
