"""Checks the terms of a program: shapes, finite numbers, and convexity."""

import dataclasses as dc
from collections.abc import Container

import numpy as np
from numpy.typing import ArrayLike

from remosplat_drake.base.errors import RemoSplatError


class TermError(RemoSplatError, ValueError):
    """A term of the program cannot be used, and the robot brakes.

    The shape is wrong, a number is not finite, or a cost is concave.
    """


class NameTakenError(RemoSplatError, ValueError):
    """The law is defined wrongly: two terms of one kind have the same name."""


@dc.dataclass(frozen=True)
class Term:
    """The kind and name of a term, for errors.

    Attributes:
        kind: Kind of the term, such as "linear cost".
        name: Its name; empty without one.
        taken: The names of other terms of its kind.

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
        """Makes an error that names the term.

        Args:
            problem: Faults of the term.
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
            value: Its numbers.
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
