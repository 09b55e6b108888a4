"""`query_map`: computes distances to a map in compiled kernels.

A `DistanceField` is a Python object, so a kernel would have to call Python for
each query. To avoid this, a field may provide its arrays as a packed named
tuple. The type of the tuple selects the kernel that computes the distances.
"""

import math
from collections.abc import Callable, Iterable
from typing import NamedTuple

import numpy as np
from numba import extending, types

from remosplat_drake.base.kernels import (
    helper,
    kernel,
    note_extension,
    overload,
)
from remosplat_drake.base.kernels.packed import Packed, bind_code
from remosplat_drake.base.kernels.returns import TRUTH, reals, several, wholes
from remosplat_drake.base.python_calls import FAILED, call_python


class Misplacement(NamedTuple):
    """Bound on a map's displacement relative to a robot with an uncertain base.

    A distance to the map is reduced by `shift`, and by `turn` times the point's
    distance from the base. The result is divided by 1 + turn, so that it
    remains 1-Lipschitz; see `oracle/uncertain_placement.py`.

    Attributes:
        x: x of the base in W [m].
        y: y of the base in W [m].
        shift: Largest shift of the map [m].
        turn: Largest turn of the map [rad].
    """

    x: float
    y: float
    shift: float
    turn: float


IN_PLACE = Misplacement(0.0, 0.0, 0.0, 0.0)
"""No misplacement: the pose of the map is exact."""


class Maps(NamedTuple):
    """Several maps, which kernels query as one map.

    Attributes:
        parts: One named tuple of arrays for each map.
    """

    parts: tuple


def together(parts: Iterable[Packed]) -> Packed[Maps]:
    """Combines several maps to one packed map, for kernels.

    Kernels also accept a plain tuple of maps, but for a tuple Numba takes
    longer to determine the type.

    Args:
        parts: The maps, in the form of `DistanceField.compiled`.
    """
    return Packed(Maps(tuple(part.values for part in parts)))


class RowArrays(NamedTuple):
    """The m rows of `Clearances`, as arrays for kernels.

    Attributes:
        sphere: `Clearances.sphere`, shape (m,).
        distance: `Clearances.distance`, shape (m,) [m].
        direction_W: `Clearances.direction_W`, shape (m, 3).
        p_WC: `Clearances.p_WC`, shape (m, 3) [m].
    """

    sphere: np.ndarray
    distance: np.ndarray
    direction_W: np.ndarray
    p_WC: np.ndarray


class PythonMap(NamedTuple):
    """A map that kernels query by calls of Python; see `base.python_calls`.

    Attributes:
        is_lipschitz: `DistanceField.is_lipschitz`.
        rows: Packed `RowArrays` without rows, from which Numba infers the type
            of the result.
    """

    is_lipschitz: bool
    rows: RowArrays


_EPSILON = 2.0**-52
"""Relative spacing of double-precision numbers."""

CLEARANCES, ROWS = 0, 1
"""Indices of two functions in a map's `PythonCalls`. The first computes
clearances of spheres, and the second all rows."""


def query_map(compiled, queries, answer) -> None:
    """Computes distances from n points to a map; for kernels only.

    Args:
        compiled: The map, in the form of `DistanceField.compiled`.
        queries: The queries, shape (n, 6). The columns are a point in W (three
            columns), the distance up to which surfaces are searched, the height
            below which the map is ignored [m], and the index of the robot
            sphere with this centre (-1 if there is none).
        answer: Output, shape (n, 8). The columns are a number that is negative
            if there is no surface within the distance, the signed distance [m],
            the closest point in W (three columns) [m], and the direction to
            this point in W (three columns).
    """
    raise NotImplementedError("this is called from compiled code")


def register_query(kind: type, kernel: Callable) -> None:
    """Registers the kernel that `query_map` calls for maps of a given type.

    Numba compiles the code of `kernel` into all kernels that query maps. It
    compiles these kernels again if the file of `kernel` has changed. Changes of
    other files outside this package are not detected.

    Args:
        kind: The named tuple with the map's arrays, a class.
        kernel: The kernel, with the arguments of `query_map`.
    """
    bind_code(kind, kernel)
    note_extension(kernel)

    # The type of the named tuple distinguishes this implementation of
    # `query_map`; see `bind_code`.
    @extending.overload(query_map)
    def _query_kind(compiled, queries, answer):
        if getattr(compiled, "kind", None) is kind:
            return lambda compiled, queries, answer: kernel(
                compiled, queries, answer
            )


@overload(query_map)
def _query_together(compiled, queries, answer):
    if getattr(compiled, "kind", None) is Maps:
        return lambda compiled, queries, answer: query_map(
            compiled.parts, queries, answer
        )


@overload(query_map)
def _query_all(compiled, queries, answer):
    """Queries several maps and returns the nearest result."""
    if not isinstance(compiled, types.UniTuple | types.Tuple):
        return None
    if len(compiled) == 1:
        return lambda compiled, queries, answer: query_map(
            compiled[0], queries, answer
        )

    def nearest(compiled, queries, answer):
        query_map(compiled[0], queries, answer)
        # The search of the remaining maps is faster if it is limited to points
        # nearer than this one.
        nearer, other = queries.copy(), np.empty_like(answer)
        for i in range(len(answer)):
            if answer[i, 0] >= 0.0:
                nearer[i, 3] = answer[i, 1]
        query_map(compiled[1:], nearer, other)
        for i in range(len(answer)):
            if other[i, 0] >= 0.0:
                for c in range(answer.shape[1]):
                    answer[i, c] = other[i, c]

    return nearest


def query_each(maps, queries, answers) -> None:
    """Queries several maps, one after the other; for kernels only.

    Args:
        maps: The k maps, in the form of `DistanceField.compiled_rows`.
        queries: The queries, as for `query_map`.
        answers: Output: the result of `query_map` for each map, shape (k, n,
            8).
    """
    raise NotImplementedError("this is called from compiled code")


@overload(query_each)
def _query_each_together(maps, queries, answers):
    if getattr(maps, "kind", None) is Maps:
        return lambda maps, queries, answers: query_each(
            maps.parts, queries, answers
        )


@overload(query_each)
def _query_each(maps, queries, answers):
    if not isinstance(maps, types.BaseTuple) or len(maps) == 0:
        return None
    if len(maps) == 1:
        return lambda maps, queries, answers: query_map(
            maps[0], queries, answers[0]
        )

    def one_by_one(maps, queries, answers):
        query_map(maps[0], queries, answers[0])
        query_each(maps[1:], queries, answers[1:])

    return one_by_one


@kernel(returns=several(wholes(1), reals(1), reals(2), reals(2), TRUTH))
def clearance_rows(maps, p_WS, radius, ignore_below, index, within):
    """Computes the rows of `Clearances`, one per map and sphere.

    Args:
        maps: The k maps, in the form of `DistanceField.compiled_rows`.
        p_WS: Centres of the n spheres in W, shape (n, 3) [m].
        radius: Radii of the spheres, shape (n,) [m].
        ignore_below: Heights below which the spheres ignore the map, shape (n,)
            [m].
        index: Indices of the spheres among the robot's spheres, shape (n,); -1
            for other spheres.
        within: Rows at or beyond this distance are omitted [m].

    Returns:
        The arrays `sphere`, `distance`, `direction_W` and `p_WC` of the rows,
        which are sorted by sphere and then by map; and whether the query is
        valid. A query is valid if no centre is infinite and no value is NaN.
    """
    k, n = len(maps.parts), len(radius)
    queries, is_defined = np.empty((n, 6)), True
    for i in range(n):
        for c in range(3):
            queries[i, c] = p_WS[i, c]
            is_defined &= np.isfinite(p_WS[i, c])
        queries[i, 3] = radius[i] + within
        queries[i, 4] = ignore_below[i]
        queries[i, 5] = index[i]
        is_defined &= not np.isnan(queries[i, 3])
        is_defined &= not np.isnan(ignore_below[i])
    answers = np.full((k, n, 8), -1.0)
    if is_defined:
        query_each(maps, queries, answers)
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


def is_pythons(compiled) -> bool:
    """Returns whether a map, or the type of one, is a `PythonMap`."""
    if isinstance(compiled, Packed):
        return isinstance(compiled.values, PythonMap)
    return getattr(compiled, "kind", None) is PythonMap


@helper
def are_known(rows):
    """Returns whether no distance is NaN or minus infinity.

    Args:
        rows: The `RowArrays`.
    """
    for i in range(len(rows.distance)):
        if not rows.distance[i] > -np.inf:
            return False
        for c in range(3):
            if not np.isfinite(rows.direction_W[i, c]):
                return False
    return True


def is_lipschitz(compiled) -> bool:
    """Returns whether a map is 1-Lipschitz; for kernels only.

    Args:
        compiled: The map, in the form of `DistanceField.placed`, or a
            `PythonMap`.
    """
    return not is_pythons(compiled) or compiled.is_lipschitz


@overload(is_lipschitz)
def _is_lipschitz(compiled):
    if is_pythons(compiled):
        return lambda compiled: compiled.is_lipschitz
    return lambda compiled: True


def is_compiled(compiled) -> bool:
    """Returns whether kernels compute a map's distances; for kernels only.

    Args:
        compiled: The map, in the form of `DistanceField.placed`, or a
            `PythonMap`.
    """
    return not is_pythons(compiled)


@overload(is_compiled)
def _is_compiled(compiled):
    known = not is_pythons(compiled)
    return lambda compiled: known


def sphere_clearances(placed, robot, sphere, p_WS, R_WL, reach, found) -> None:
    """Computes clearances of spheres, each up to a largest value.

    A clearance below the sphere's `reach` is exact; for a larger clearance, the
    result is `reach`. Unknown clearances are NaN. For kernels only.

    Args:
        placed: A tuple of the map, its `Misplacement`, and the number of the
            `PythonCalls`. The map is `DistanceField.compiled` if that is
            1-Lipschitz, or else a `PythonMap`.
        robot: The `RobotArrays`. For a compiled map, it may also be other
            arrays with radii, `ignore_below` and `index`.
        sphere: Indices of the spheres, shape (n,).
        p_WS: Centres of the spheres in W, shape (n, 3) [m].
        R_WL: Orientations of the spheres' links, shape (n, 3, 3).
        reach: Largest clearance to report [m]: one number for all spheres, or
            one for each sphere, shape (n,).
        found: Output: the clearances, shape (n,) [m].
    """
    of_python = is_pythons(placed[0])
    find = _clearances_of_python if of_python else _clearances_of_kernels
    find(placed, robot, sphere, p_WS, R_WL, reach, found)


@overload(sphere_clearances)
def _sphere_clearances(placed, robot, sphere, p_WS, R_WL, reach, found):
    of_python = is_pythons(placed[0])
    return _clearances_of_python if of_python else _clearances_of_kernels


def _clearances_of_python(placed, robot, sphere, p_WS, R_WL, reach, found):
    arguments = sphere, p_WS, R_WL, _longest(reach), found
    if call_python(placed[2], CLEARANCES, arguments) == FAILED:
        for i in range(len(found)):
            found[i] = np.nan
    for i in range(len(found)):
        if found[i] > _reach_of(reach, i):
            found[i] = _reach_of(reach, i)


def _clearances_of_kernels(placed, robot, sphere, p_WS, R_WL, reach, found):
    compiled, off, _ = placed
    scale = 1.0 + off.turn
    queries = np.empty((len(sphere), 6))
    answer = np.full((len(sphere), 8), -1.0)
    for row in range(len(sphere)):
        i, far = sphere[row], _reach_of(reach, row)
        for c in range(3):
            queries[row, c] = p_WS[row, c]
        # The bound is slightly larger than the distance, since the query finds
        # only points that are nearer than its bound.
        far += abs(far) * _EPSILON
        least = scale * far + _margin(off, p_WS[row])
        queries[row, 3] = robot.radius[i] + least
        queries[row, 4] = robot.ignore_below[i]
        queries[row, 5] = robot.index[i]
    query_map(compiled, queries, answer)
    for row in range(len(sphere)):
        far = _reach_of(reach, row)
        found[row] = far
        if answer[row, 0] >= 0.0:
            clearance = answer[row, 1] - robot.radius[sphere[row]]
            clearance = (clearance - _margin(off, p_WS[row])) / scale
            found[row] = min(clearance, far)


def _reach_of(reach, row):
    return reach[row] if isinstance(reach, np.ndarray) else reach


@overload(_reach_of)
def _reach_of_row(reach, row):
    if isinstance(reach, types.Array):
        return lambda reach, row: reach[row]
    return lambda reach, row: reach


def _longest(reach):
    return np.max(reach)


@overload(_longest)
def _longest_reach(reach):
    if isinstance(reach, types.Array):
        return lambda reach: np.max(reach)
    return lambda reach: reach


@helper
def _margin(off, p_WS):
    """Returns the bound of a map's displacement at a point [m]."""
    x, y = p_WS[0] - off.x, p_WS[1] - off.y
    return off.shift + off.turn * math.sqrt(x * x + y * y)
