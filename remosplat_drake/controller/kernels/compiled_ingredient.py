"""Ingredients of the program that a kernel adds, too."""

from abc import ABC, abstractmethod

from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.scene.mover import Movers


class CompiledIngredient(ABC):
    """An ingredient of the library: its terms are added by a kernel, too.

    Its `AddToProgram` is the reference, and what runs where a law has two of
    its class: both add the same, under the one name `term`.

    Attributes:
        term: Name of all of its terms.
    """

    term: str

    @abstractmethod
    def settings(self, robot: RobotModel) -> tuple:
        """Makes what the kernel takes, a named tuple.

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
            number: What the kernel gave to `new_row`.
        """
        del robot, movers
        return f"row {number}"
