"""Checks the terms of a program: shapes, finite numbers, and convexity."""

import dataclasses as dc
from collections.abc import Container

import numpy as np
from numpy.typing import ArrayLike

from remosplat_drake.base.errors import RemoSplatError


class TermError(RemoSplatError, ValueError):
    """Raised if a term of the program is invalid; the robot then brakes.

    A term is invalid if its shape is wrong, if a number is not finite, or if a
    cost is concave.
    """


class NameTakenError(RemoSplatError, ValueError):
    """Raised if two terms of the same kind in a law have the same name."""


@dc.dataclass(frozen=True)
class Term:
    """Kind and name of a term, for the texts of errors.

    Attributes:
        kind: Kind of the term, such as "linear cost".
        name: Name of the term; empty if it has none.
        taken: The names of all other terms of this kind.

    Raises:
        NameTakenError: Another term has this name.
    """

    kind: str
    name: str = ""
    taken: Container[str] = ()

    def __post_init__(self):
        if self.name in self.taken:
            raise NameTakenError(
                f"there is a {self.kind} {self.name!r} already; choose another"
                " name"
            )

    def error(self, problem: str) -> TermError:
        """Returns an error that names the term.

        Args:
            problem: Description of the problem.
        """
        name = f" {self.name!r}" if self.name else ""
        return TermError(f"{self.kind}{name}: {problem}")

    def array(
        self,
        what: str,
        value: ArrayLike,
        shape: tuple[int, ...],
        *,
        unbounded: bool = False,
    ) -> np.ndarray:
        """Returns a part of the term as an array, after checks.

        Args:
            what: Name of the part.
            value: The numbers of the part.
            shape: The shape that it must have.
            unbounded: Whether numbers may be infinite.

        Raises:
            TermError: The value has another shape, or a number is not finite.
        """
        array = np.asarray(value, float)
        if array.shape != shape:
            raise self.error(
                f"{what} must have the shape {shape}, not {array.shape}"
            )
        if not np.isfinite(array).all() and (
            not unbounded or np.isnan(array).any()
        ):
            raise self.error(f"{what} is not finite")
        return array

    def weights(
        self, what: str, value: ArrayLike, shape: tuple[int, ...]
    ) -> np.ndarray:
        """Returns the weights of a convex quadratic cost, after checks.

        Args:
            what: Name of the weights.
            value: The weights.
            shape: The shape that they must have.

        Raises:
            TermError: The weights have another shape, or a weight is not finite
                or is negative.
        """
        array = self.array(what, value, shape)
        if (array < 0.0).any():
            raise self.error(f"{what} is negative, so that the cost is concave")
        return array
