"""`Ingredient`: a cost or constraint of which programs are built."""

from collections.abc import Container, Sequence
from typing import Protocol

from remosplat_drake.controller.reactive_program import ReactiveProgram
from remosplat_drake.controller.tick import Tick
from remosplat_drake.robot.robot_model import RobotModel


class Ingredient(Protocol):
    """A cost or constraint of the program.

    Any object with this method is one. The controller and its rollouts share
    it, so `AddToProgram` must depend on its arguments alone; and it must be
    possible to pickle it if rollouts run in a process of their own.

    Example:
        >>> import remosplat_drake as rs
        >>> class PreferStill:
        ...     def AddToProgram(self, program, tick):
        ...         program.add_quadratic_cost("still", program.upper * 0 + 0.1)
        >>> robot = rs.load_robot("frankie")
        >>> parts = [*rs.default_ingredients(robot), PreferStill()]
        >>> law = rs.ReactiveLaw(robot, parts)
    """

    def AddToProgram(self, program: ReactiveProgram, tick: Tick) -> None:
        """Adds what the ingredient stands for to the program of one tick.

        Args:
            program: Takes costs, rows and bounds, each by a name of its own.
            tick: What is known at the tick: the robot's state, the target,
                the clearances and the command being executed.
        """
        ...


class IngredientMaker(Protocol):
    """The settings of an ingredient that needs to know the robot.

    Any `Config` with this method is one, and a scenario may name it in
    `controller.extra`.
    """

    def make(self, robot: RobotModel) -> Ingredient:
        """Makes the ingredient.

        Args:
            robot: The robot that the controller drives.
        """
        ...


def build_program(
    tick: Tick,
    ingredients: Sequence[Ingredient],
    *,
    use_acceleration: bool = True,
    relax: Container[str] = (),
) -> ReactiveProgram:
    """Builds the program of one tick afresh.

    Args:
        tick: What is known at the tick: the robot's state, the target, the
            clearances and the command being executed.
        ingredients: Costs and constraints, in any order.
        use_acceleration: Whether ingredients may add acceleration bounds.
        relax: Names of the sets of rows whose negative right-hand sides are
            raised to zero.

    Returns:
        The finished program.

    Raises:
        TermError: Two terms of a kind share a name, or one has the wrong
            shape.
    """
    program = ReactiveProgram(
        tick.robot.velocity_limit,
        use_acceleration=use_acceleration,
        relax=relax,
    )
    complete(program, ingredients, tick)
    return program


def complete(
    program: ReactiveProgram, ingredients: Sequence[Ingredient], tick: Tick
) -> None:
    """Adds ingredients to an unfinished program, and finishes it.

    Args:
        program: The program.
        ingredients: Costs and constraints, in any order.
        tick: What is known at the tick.

    Raises:
        TermError: Two terms of a kind share a name, or one has the wrong
            shape.
    """
    for ingredient in ingredients:
        ingredient.AddToProgram(program, tick)
    program.finish()
