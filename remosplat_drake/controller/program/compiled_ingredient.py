"""Ingredients of the library, whose terms a kernel adds to the program."""

from abc import ABC, abstractmethod

from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.scene.mover import Movers


class CompiledIngredient(ABC):
    """An ingredient of the library: settings, and a function that adds terms.

    The function, `add_...`, stands below the class. Its docstring has the
    formula. It is compiled, and `kernels/assemble.py` calls it once a tick,
    with these arguments:

    - `own`: the ingredient's `settings`.
    - `k`: its number, the place of its kind in `assemble.PARTS`.
    - `tick`: what is known at the tick, the `TickArrays`.
    - `program`: the `ProgramArrays`, which take the terms.

    A subclass that has a method `AddToProgram` is an `Ingredient` from outside,
    and adds its terms by that method alone.

    Attributes:
        term: Name of all of its terms.
    """

    term: str

    @abstractmethod
    def settings(self, robot: RobotModel) -> tuple:
        """Makes `own`, what the function takes: a named tuple.

        Args:
            robot: The robot that is driven.
        """

    def about(
        self, robot: RobotModel, movers: Movers | None, number: int
    ) -> str | tuple[str, ...]:
        """Says what a row is about, for people: names, or a text.

        Args:
            robot: The robot that is driven.
            movers: What moves; None if nothing is known to.
            number: What the function gave to `new_row`.
        """
        del robot, movers
        return f"row {number}"
