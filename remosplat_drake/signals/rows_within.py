"""`rows_within`: computes the rows of `Clearances` in kernels."""

import numpy as np

from remosplat_drake.base.kernels import helper, overload
from remosplat_drake.base.python_calls import FAILED, call_python, packed_at
from remosplat_drake.signals.compiled_map import (
    ROWS,
    RowArrays,
    clearance_rows,
    is_pythons,
)
from remosplat_drake.signals.side_rows import side_rows


def rows_within(maps, line, robot, state, within, below):
    """Computes the rows of `Clearances` in a robot's state; for kernels only.

    Args:
        maps: The maps, in the form of `DistanceField.compiled_rows`, or a
            `PythonMap`.
        line: Number of the map's `PythonCalls`; used only for a `PythonMap`.
        robot: The `RobotArrays`.
        state: The `StateArrays`.
        within: Rows at or beyond this distance are omitted [m].
        below: Spheres nearer to the map than this distance also get `side_rows`
            [m].

    Returns:
        The `RowArrays`. If the query is invalid, or a map has failed, they have
        a single row of NaN.
    """
    find = _rows_of_python if is_pythons(maps) else _rows_of_kernels
    return find(maps, line, robot, state, within, below)


@overload(rows_within)
def _rows_within(maps, line, robot, state, within, below):
    return _rows_of_python if is_pythons(maps) else _rows_of_kernels


def _rows_of_python(maps, line, robot, state, within, below):
    address = call_python(line, ROWS, (state.p_WS, state.R_WL, within))
    if address == FAILED:
        return _unknown_rows()
    rows = packed_at(maps.rows, address)
    return RowArrays(rows.sphere, rows.distance, rows.direction_W, rows.p_WC)


def _rows_of_kernels(maps, line, robot, state, within, below):
    sphere, distance, direction_W, p_WC, is_defined = clearance_rows(
        maps,
        state.p_WS,
        robot.radius,
        robot.ignore_below,
        robot.index,
        within,
    )
    if not is_defined:
        return _unknown_rows()
    rows = RowArrays(sphere, distance, direction_W, p_WC)
    for i in range(len(distance)):
        if distance[i] < below:
            return RowArrays(
                *side_rows(
                    maps,
                    rows,
                    state.p_WS,
                    robot.radius,
                    robot.ignore_below,
                    robot.index,
                    below,
                )
            )
    return rows


@helper
def _unknown_rows():
    nowhere = np.full((1, 3), np.nan)
    return RowArrays(
        np.zeros(1, np.int64), np.full(1, np.nan), nowhere, nowhere
    )
