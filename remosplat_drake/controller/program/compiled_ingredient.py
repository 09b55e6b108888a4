"""Ingredients that are compiled: the library's, and some from outside."""

from abc import ABC, abstractmethod
from collections.abc import Callable
from typing import Any, ClassVar, Self

from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.scene.mover import Movers


class CompiledIngredient(ABC):
    """An ingredient in compiled form: settings, and a function that adds terms.

    The function is compiled, and runs inside the kernels of ticks and rollouts,
    once a tick. Its docstring has the formula. It takes these arguments:

    - `own`: the ingredient's `settings`.
    - `k`: its number among the ingredients.
    - `tick`: what is known at the tick, the `TickArrays`.
    - `program`: the `ProgramArrays`, which take the terms.

    An ingredient from outside the library has it as its static method `add`.
    It adds costs to `program.linear[k]` and `program.quadratic[k]`, and rows by
    `new_row`. Those of the library have functions `add_...` below their
    classes, which `kernels/assemble.py` lists.

    A subclass that has a method `AddToProgram` is an `Ingredient` in Python,
    and adds its terms by that method alone.

    Attributes:
        term: Name of all of its terms.

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
        """Makes `own`, the function's input: a named tuple.

        Args:
            robot: The robot that is driven.
        """

    def make(self, robot: RobotModel) -> Self:
        """Returns the ingredient: one that is a `Config` is its own maker.

        Args:
            robot: The robot that is driven.
        """
        del robot
        return self

    def most_rows(self, robot: RobotModel) -> int:
        """Returns how many rows an ingredient from outside adds at most.

        Args:
            robot: The robot that is driven.
        """
        del robot
        return 0

    def about(
        self, robot: RobotModel, movers: Movers | None, number: int
    ) -> str | tuple[str, ...]:
        """Names the subject of a row, for people: names, or a text.

        Args:
            robot: The robot that is driven.
            movers: The movers; None if none are known.
            number: The number that the function passed to `new_row`.
        """
        del robot, movers
        return f"row {number}"
