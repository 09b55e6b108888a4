"""`CompiledOutside`: a user's compiled ingredients of a law."""

import re
from collections.abc import Sequence

import numpy as np
from numba.core.errors import NumbaError

from remosplat_drake.base.address_calls import (
    DONE,
    RAISED,
    AddressedFunction,
)
from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.base.kernels.packed import Packed
from remosplat_drake.base.ranges import shown
from remosplat_drake.controller.ingredients.kernels.assemble import (
    OUTSIDE,
    Assembled,
)
from remosplat_drake.controller.program.compiled_ingredient import (
    CompiledIngredient,
)
from remosplat_drake.controller.program.guidance import DIRECT
from remosplat_drake.controller.program.kernels.compiled_terms import (
    NO_PART,
    AddedBy,
    Turn,
    adder,
)
from remosplat_drake.controller.program.kernels.tick_arrays import (
    NearArrays,
    TickArrays,
    make_program,
)
from remosplat_drake.controller.program.reactive_program import ReactiveProgram
from remosplat_drake.controller.program.term import Term, TermError
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.scene.kernels.mover_reach import NearMoverArrays
from remosplat_drake.signals.aim import Aim


class CompiledOutside:
    """A user's compiled ingredients, for one robot.

    Attributes:
        ingredients: The ingredients.
        added_by: The functions of the ingredients, in the form that kernels
            call.
    """

    def __init__(
        self, robot: RobotModel, ingredients: Sequence[CompiledIngredient]
    ):
        """Compiles the functions of the ingredients.

        Args:
            robot: The robot that is driven.
            ingredients: The ingredients.

        Raises:
            RemoSplatError: A function cannot be compiled. The error names the
                ingredient.
        """
        self.ingredients = tuple(ingredients)
        # Kernels have only the addresses of the functions, so a reference to
        # each function must be kept.
        self._functions = [_compiled(i, robot) for i in ingredients]
        words = [function.words for function in self._functions]
        most = [ingredient.most_rows(robot) for ingredient in ingredients]
        self.added_by = AddedBy(
            np.array(words, np.int64).reshape(-1, 2), np.array(most, np.int64)
        )

    def check(self, found: Assembled) -> None:
        """Checks that all terms are valid.

        Args:
            found: The program that kernels have assembled.

        Raises:
            TermError: A term is invalid. The error names the term and its
                ingredient.
        """
        if found.refused == NO_PART:
            return
        i = found.refused - OUTSIDE
        ingredient, most = self.ingredients[i], int(self.added_by.most[i])
        try:
            _check_terms(ingredient.term, most, found)
        except TermError as error:
            name = type(ingredient).__name__
            raise TermError(f"ingredient {name}: {error}") from None


def _compiled(
    ingredient: CompiledIngredient, robot: RobotModel
) -> AddressedFunction:
    name, settings = type(ingredient).__name__, ingredient.settings(robot)
    if not hasattr(ingredient, "add"):
        raise RemoSplatError(f"ingredient {name} has no function `add`")
    try:
        packed = Packed(settings)
    except (AttributeError, TypeError, ValueError) as error:
        raise RemoSplatError(
            f"ingredient {name}: settings must be a named tuple of numbers and"
            f" arrays, got {shown(settings)}"
        ) from error
    try:
        return AddressedFunction(adder(ingredient.add), packed, _turn(robot))
    except NumbaError as error:
        raise RemoSplatError(
            f"ingredient {name} cannot be compiled: {_cause(error)}"
        ) from error


def _cause(error: NumbaError) -> str:
    """Returns the innermost of Numba's nested messages, in one line."""
    text = re.sub(r"\x1b\[\d+m", "", str(error))
    cause = text.rpartition("(step: nopython frontend)")[2]
    return " ".join(cause.partition("During: ")[0].split())


def _turn(robot: RobotModel) -> Packed[Turn]:
    """Returns an example of a `Turn`; only its type is used."""
    index, values, vectors = np.zeros(0, int), np.zeros(0), np.zeros((0, 3))
    movers = NearMoverArrays(index, index, values, vectors, values)
    tick = TickArrays(
        robot=robot.arrays.values,
        state=robot.state(robot.q_home).arrays,
        aim=Aim.of(np.eye(4)).arrays.values,
        p_ET_W=vectors,
        rotation_W=vectors,
        error_scales=values,
        error_scale=0.0,
        sphere=index,
        distance=values,
        direction_W=vectors,
        rates=vectors,
        moving=movers,
        soon=movers,
        near=NearArrays(index, index, index, values, *[vectors] * 3),
        u_previous=values,
        dt=0.0,
        tube=values,
        guidance=DIRECT.arrays.values,
    )
    return Packed(Turn(0, tick, make_program(values, 0, 0, 0)))


def _check_terms(term: str, most: int, found: Assembled) -> None:
    """Checks the terms in the same way as those of ingredients in Python."""
    if found.ended != DONE:
        does = "raises" if found.ended == RAISED else "fits no kernel"
        raise TermError(f"its function {does}")
    program, part = found.program, found.refused
    first, last = program.rows[part].tolist()
    if last - first > most:
        raise Term("set of rows", term).error(
            f"has {last - first} rows, but most_rows allows {most}"
        )
    checked = ReactiveProgram(program.upper)
    checked.add_linear_cost(term, program.linear[part])
    checked.add_quadratic_cost(term, program.quadratic[part])
    checked.add_rows(term, program.A[first:last], program.b[first:last])
