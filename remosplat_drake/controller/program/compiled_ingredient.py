"""`CompiledIngredient`: a cost or constraint that Numba compiles."""

from abc import ABC, abstractmethod
from collections.abc import Callable
from typing import Any, ClassVar, Self

from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.scene.mover import Movers


class CompiledIngredient(ABC):
    """An ingredient in compiled form: settings, and a function that adds terms.

    An ingredient is a cost or a constraint of the quadratic program. The
    kernels of ticks and rollouts call the function once in each tick. Its
    docstring contains the formula. Its arguments are:

    - `own`: the ingredient's `settings`.
    - `k`: the ingredient's number.
    - `tick`: the inputs of the tick, the `TickArrays`.
    - `program`: the `ProgramArrays`, to which the terms are added.

    In an ingredient of your own, the function is the static method `add`. It
    adds costs to `program.linear[k]` and `program.quadratic[k]`, and rows by
    `new_row`. The library's ingredients have functions `add_...` below their
    classes, which `kernels/assemble.py` lists.

    If a subclass has a method `AddToProgram`, it is an `Ingredient` in Python,
    and only this method adds its terms.

    Attributes:
        term: Name of all terms of the ingredient.

    Example:
        >>> import remosplat_drake as rs
        >>> from typing import NamedTuple
        >>> class Weight(NamedTuple):
        ...     weight: float
        >>> class PreferStill(rs.CompiledIngredient):
        ...     term = "still"
        ...     def settings(self, robot):
        ...         return Weight(0.1)
        ...     @staticmethod
        ...     def add(own, k, tick, program):
        ...         program.quadratic[k] += own.weight
        >>> robot = rs.load_robot("frankie")
        >>> parts = [*rs.default_ingredients(robot), PreferStill()]
        >>> law = rs.ReactiveLaw(robot, parts)
    """

    term: str
    add: ClassVar[Callable[[Any, int, Any, Any], None]]

    @abstractmethod
    def settings(self, robot: RobotModel) -> tuple:
        """Makes `own`, the function's first argument, a named tuple.

        Args:
            robot: The robot that is driven.
        """

    def make(self, robot: RobotModel) -> Self:
        """Returns this ingredient; see `IngredientMaker.make`.

        Args:
            robot: The robot that is driven.
        """
        del robot
        return self

    def most_rows(self, robot: RobotModel) -> int:
        """Returns the largest number of rows that the function adds.

        Args:
            robot: The robot that is driven.
        """
        del robot
        return 0

    def about(
        self, robot: RobotModel, movers: Movers | None, number: int
    ) -> str | tuple[str, ...]:
        """Returns the subject of a row for display, as names or a text.

        Args:
            robot: The robot that is driven.
            movers: The movers; None if none are known.
            number: The number that the function passed to `new_row`.
        """
        del robot, movers
        return f"row {number}"
