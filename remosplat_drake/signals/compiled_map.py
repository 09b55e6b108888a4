"""`ask`: distances to a map, for who asks from within a compiled kernel.

A `DistanceField` answers in Python: a whole kernel would come back to it for
every look. So a field may hand out its arrays, as a packed named tuple, and the
kernel that answers by them is found by the tuple's type.
"""

from collections.abc import Callable, Iterable
from typing import NamedTuple

import numpy as np
from numba import types
from numba.extending import overload

from remosplat_drake.base.kernels import kernel
from remosplat_drake.base.packed import Packed, bind_code


class Misplacement(NamedTuple):
    """How far off a map may lie, as seen from a robot whose base is uncertain.

    A distance of the map is then less by `shift` and by `turn` times how far
    the point is from the base, and divided by 1 + turn, so that it stays
    1-Lipschitz; see `oracle/uncertain_placement.py`.

    Attributes:
        x: The base in W [m].
        y: The base in W [m].
        shift: Greatest distance by which the map may be off [m].
        turn: Greatest angle by which it may be off [rad].
    """

    x: float
    y: float
    shift: float
    turn: float


IN_PLACE = Misplacement(0.0, 0.0, 0.0, 0.0)
"""The misplacement of a map that lies where it says."""


class Maps(NamedTuple):
    """Several maps, as one that kernels take.

    Attributes:
        parts: The named tuples of their arrays.
    """

    parts: tuple


def together(parts: Iterable[Packed]) -> Packed[Maps]:
    """Packs several maps as one.

    Kernels take a tuple of them as well, but numba is slow to tell its type.

    Args:
        parts: The maps, as `DistanceField.compiled`.
    """
    return Packed(Maps(tuple(part.values for part in parts)))


def ask(compiled, question, answer) -> None:
    """Finds how far a map is from each of n points; for kernels only.

    Args:
        compiled: The map, as `DistanceField.compiled`.
        question: Points in W, the distances that an answer must undercut, and
            the heights below which nothing is seen, shape (n, 5) [m].
        answer: Filled in, shape (n, 8): less than 0 in the first column where
            nothing is that near; else the signed distance [m], the closest
            point in W, shape (3,) [m], and the direction to it in W, shape
            (3,).
    """
    raise NotImplementedError("this is called from compiled code")


def answers(kind: type, kernel: Callable) -> None:
    """Makes `ask` call a kernel for a kind of map.

    All kernels that ask maps contain it. They are compiled again when its file
    has changed; helpers of other files outside of this package are not seen.

    Args:
        kind: The named tuple of the map's arrays.
        kernel: The kernel, with the arguments of `ask`.
    """
    bind_code(kind, kernel)

    @overload(ask)
    def _ask_kind(compiled, question, answer):
        if getattr(compiled, "kind", None) is kind:
            return lambda compiled, question, answer: kernel(
                compiled, question, answer
            )


@overload(ask)
def _ask_together(compiled, question, answer):
    if getattr(compiled, "kind", None) is Maps:
        return lambda compiled, question, answer: ask(
            compiled.parts, question, answer
        )


@overload(ask)
def _ask_all(compiled, question, answer):
    """Several maps in one: the nearest of their answers."""
    if not isinstance(compiled, types.UniTuple | types.Tuple):
        return None
    if len(compiled) == 1:
        return lambda compiled, question, answer: ask(
            compiled[0], question, answer
        )

    def nearest(compiled, question, answer):
        ask(compiled[0], question, answer)
        other = np.empty_like(answer)
        ask(compiled[1:], question, other)
        for i in range(len(answer)):
            nearer = answer[i, 0] < 0.0 or other[i, 1] < answer[i, 1]
            if other[i, 0] >= 0.0 and nearer:
                for c in range(answer.shape[1]):
                    answer[i, c] = other[i, c]

    return nearest


def ask_each(maps, question, answers) -> None:
    """Asks several maps, one after the other; for kernels only.

    Args:
        maps: The k maps, as `DistanceField.compiled_rows`.
        question: What `ask` takes.
        answers: Filled in with the answer of each, shape (k, n, 8).
    """
    raise NotImplementedError("this is called from compiled code")


@overload(ask_each)
def _ask_each_together(maps, question, answers):
    if getattr(maps, "kind", None) is Maps:
        return lambda maps, question, answers: ask_each(
            maps.parts, question, answers
        )


@overload(ask_each)
def _ask_each(maps, question, answers):
    if not isinstance(maps, types.BaseTuple) or len(maps) == 0:
        return None
    if len(maps) == 1:
        return lambda maps, question, answers: ask(
            maps[0], question, answers[0]
        )

    def one_by_one(maps, question, answers):
        ask(maps[0], question, answers[0])
        ask_each(maps[1:], question, answers[1:])

    return one_by_one


@kernel
def clearance_rows(maps, p_WS, radius, ignore_below, within):
    """Finds the rows of `Clearances`: the answer of each map to each sphere.

    Args:
        maps: The k maps, as `DistanceField.compiled_rows`.
        p_WS: Centres of the n spheres in W, shape (n, 3) [m].
        radius: Their radii, shape (n,) [m].
        ignore_below: Heights below which they see nothing, shape (n,) [m].
        within: Rows at or beyond this distance are left out [m].

    Returns:
        The attributes `sphere`, `distance`, `direction_W` and `p_WC` of the
        rows, sphere by sphere, and each in the order of the maps; and whether
        what was asked is defined: no centre is infinite, and nothing is NaN.
    """
    k, n = len(maps.parts), len(radius)
    question, is_defined = np.empty((n, 5)), True
    for i in range(n):
        for c in range(3):
            question[i, c] = p_WS[i, c]
            is_defined &= np.isfinite(p_WS[i, c])
        question[i, 3] = radius[i] + within
        question[i, 4] = ignore_below[i]
        is_defined &= not np.isnan(question[i, 3])
        is_defined &= not np.isnan(ignore_below[i])
    answers = np.full((k, n, 8), -1.0)
    if is_defined:
        ask_each(maps, question, answers)
    sphere, distance = np.empty(k * n, np.int64), np.empty(k * n)
    direction_W, p_WC = np.empty((k * n, 3)), np.empty((k * n, 3))
    m = 0
    for i in range(n):
        for part in range(k):
            answer = answers[part, i]
            found = answer[1] - radius[i]
            if answer[0] < 0.0 or found >= within:
                continue
            sphere[m], distance[m] = i, found
            for c in range(3):
                p_WC[m, c], direction_W[m, c] = answer[2 + c], answer[5 + c]
            m += 1
    return sphere[:m], distance[:m], direction_W[:m], p_WC[:m], is_defined
