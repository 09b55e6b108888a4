"""`Ingredient`: a user's cost or constraint of the quadratic program."""

import traceback
from collections.abc import Container, Sequence
from typing import Protocol

import numpy as np

from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.controller.program.compiled_ingredient import (
    CompiledIngredient,
)
from remosplat_drake.controller.program.reactive_program import ReactiveProgram
from remosplat_drake.controller.program.term import NameTakenError, TermError
from remosplat_drake.controller.program.tick import Tick
from remosplat_drake.robot.robot_model import RobotModel


class Ingredient(Protocol):
    """Protocol of a user's cost or constraint that is written in Python.

    Any object with the method `AddToProgram` is an ingredient. The controller
    and its rollouts use the same object, so the method must depend only on its
    arguments. If a separate process computes rollouts, the object must be
    picklable.

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
        """Adds the ingredient's terms to the program of one tick.

        Args:
            program: The program, to which costs, rows and bounds are added,
                each with a unique name.
            tick: The state of the tick: the robot's state, the target, the
                clearances, and the command that is being executed.
        """
        ...


AnyIngredient = CompiledIngredient | Ingredient
"""Type of any ingredient: of the library or a user's, compiled or in Python."""


class IngredientMaker(Protocol):
    """Protocol of settings from which an ingredient is made for a robot.

    Any `Config` with the method `make` is such settings, and a scenario may
    name its class in `controller.extra`.
    """

    def make(self, robot: RobotModel) -> AnyIngredient:
        """Makes the ingredient.

        Args:
            robot: The robot that the controller drives.
        """
        ...


def added(
    ingredients: Sequence[Ingredient],
    bounds: np.ndarray,
    taken: Container[str],
    tick: Tick,
) -> ReactiveProgram:
    """Calls ingredients in Python, and returns the terms that they add.

    Args:
        ingredients: The ingredients.
        bounds: Four rows, shape (4, n_u): present lower and upper bounds of u,
            and then both without acceleration bounds.
        taken: Names of existing terms.
        tick: The state of the tick.

    Returns:
        The added terms.

    Raises:
        TermError: A term is invalid. The error names the term and its
            ingredient.
        NameTakenError: Two terms of one kind have the same name.
        IngredientError: An ingredient raises an exception.
    """
    program = ReactiveProgram.within(bounds, taken)
    for ingredient in ingredients:
        name = type(ingredient).__name__
        try:
            ingredient.AddToProgram(program, tick)
            if program.extension is not None:
                program.extension.check()
        except (TermError, NameTakenError) as error:
            raise type(error)(f"ingredient {name}: {error}") from None
        except SystemExit as error:  # Drake's own checks raise these errors.
            raise TermError(f"ingredient {name}: prog: {error}") from None
        except Exception as error:
            raise IngredientError(ingredient, error) from error
    return program


class IngredientError(RemoSplatError):
    """Raised if an ingredient raises an exception; states the file and line.

    Args:
        ingredient: The ingredient.
        error: The exception.
    """

    def __init__(self, ingredient: Ingredient, error: Exception):
        name = type(ingredient).__name__
        # The first frame is that of the caller, and the next frame that of the
        # ingredient.
        called = traceback.extract_tb(error.__traceback__)[1:]
        own = [
            frame for frame in called if frame.filename == called[0].filename
        ]
        where = f" ({own[-1].filename}:{own[-1].lineno})" if own else ""
        super().__init__(
            f"ingredient {name} raised {type(error).__name__}: {error}{where}"
        )
