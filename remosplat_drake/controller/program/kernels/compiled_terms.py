"""Adds the terms of a user's compiled ingredients."""

from collections.abc import Callable
from functools import cache
from typing import Any, NamedTuple

import numpy as np

from remosplat_drake.base.address_calls import DONE, call_address
from remosplat_drake.base.kernels import helper
from remosplat_drake.controller.program.kernels.tick_arrays import (
    ProgramArrays,
    TickArrays,
)

NO_PART = -1
"""Number that means that there is no ingredient."""


class AddedBy(NamedTuple):
    """The functions of k compiled ingredients of a user.

    Attributes:
        words: `AddressedFunction.words` of each function, shape (k, 2).
        most: Largest number of rows that each function may add, shape (k,).
    """

    words: np.ndarray
    most: np.ndarray


class Turn(NamedTuple):
    """The argument of the function of a user's compiled ingredient.

    Attributes:
        part: Number of the ingredient.
        tick: The state of the tick.
        program: The program, to which the terms are added.
    """

    part: int
    tick: TickArrays
    program: ProgramArrays


@cache
def adder(add: Callable) -> Callable[[Any, Turn], None]:
    """Makes a function that takes a `Turn` from an ingredient's function.

    Args:
        add: The static method `add` of an ingredient.
    """
    add = helper(add)

    def add_in_turn(own, turn):
        add(own, turn.part, turn.tick, turn.program)

    return add_in_turn


@helper
def add_compiled(added_by, first, tick, program):
    """Calls the functions of a user's compiled ingredients, which add terms.

    Args:
        added_by: The `AddedBy`.
        first: Number of the first of these ingredients.
        tick: The `TickArrays`.
        program: The `ProgramArrays`.

    Returns:
        The number of an ingredient with invalid terms, or NO_PART, and the
        result of the call of its function.
    """
    for i in range(len(added_by.most)):
        part = first + i
        ended = call_address(added_by.words[i], Turn(part, tick, program))
        if ended != DONE or not _are_usable(program, part, added_by.most[i]):
            return part, ended
    return NO_PART, DONE


@helper
def _are_usable(program, part, most):
    """Returns whether the terms of an ingredient are valid."""
    n_u = len(program.lower)
    for j in range(n_u):
        c, weight = program.linear[part, j], program.quadratic[part, j]
        if not (np.isfinite(c) and 0.0 <= weight < np.inf):
            return False
        if c != 0.0:
            program.has[part, 0] = True
        if weight != 0.0:
            program.has[part, 1] = True
    first, last = program.rows[part]
    if last - first > most:
        return False
    for i in range(first, last):
        if not np.isfinite(program.b[i]):
            return False
        for j in range(n_u):
            if not np.isfinite(program.A[i, j]):
                return False
    return True
