"""Prepares maps for queries by kernels: compiled, or by calls of Python."""

import numpy as np

from remosplat_drake.base.kernels.packed import Packed
from remosplat_drake.base.python_calls import Arguments, PythonCalls
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.signals.compiled_map import (
    IN_PLACE,
    Maps,
    Misplacement,
    PythonMap,
    RowArrays,
)
from remosplat_drake.signals.distance_field import DistanceField
from remosplat_drake.signals.row_arrays import row_arrays


def map_for_kernels(field: DistanceField) -> tuple[Packed, Misplacement]:
    """Returns a map for kernels that verify: compiled, or a `PythonMap`.

    Args:
        field: The map.
    """
    placed = field.placed if field.is_lipschitz else None
    return (
        (_PYTHONS[field.is_lipschitz], IN_PLACE) if placed is None else placed
    )


def rows_for_kernels(field: DistanceField) -> Packed[Maps] | Packed[PythonMap]:
    """Returns a map for kernels that simulate; see `map_for_kernels`.

    Args:
        field: The map.
    """
    rows = field.compiled_rows
    return _PYTHONS[field.is_lipschitz] if rows is None else rows


def is_pythons(field: DistanceField) -> bool:
    """Returns whether kernels query a map by calls of Python, which is slower.

    Args:
        field: The map.
    """
    maps = map_for_kernels(field)[0], rows_for_kernels(field)
    return any(part in _PYTHONS.values() for part in maps)


def _python_map(is_lipschitz: bool) -> Packed[PythonMap]:
    none = np.zeros((0, 3))
    rows = RowArrays(np.zeros(0, np.int64), np.zeros(0), none, none)
    return Packed(PythonMap(is_lipschitz, rows))


_PYTHONS = {known: _python_map(known) for known in (False, True)}


class MapCalls:
    """A context manager; within it, kernels can query a map by calls of Python.

    The `with` statement returns the number of the calls, which kernels take as
    an argument:

        with MapCalls(robot, field) as line:
            kernel(..., line)
    """

    def __init__(self, robot: RobotModel, field: DistanceField):
        """Prepares the functions.

        Args:
            robot: The robot, whose spheres are queried.
            field: The map.
        """
        self._robot, self._field = robot, field
        self._calls = PythonCalls(*self._answers())

    def __enter__(self) -> int:
        """Registers the functions; returns the number for kernels."""
        return self._calls.__enter__().number

    def __exit__(self, kind: object, *error: object) -> None:
        """Ends the calls.

        Raises:
            Exception: A query raised this exception.
        """
        self._calls.__exit__()
        if kind is None:
            self._check()

    def _check(self) -> None:
        if self._calls.error is not None:
            raise self._calls.error

    def _answers(self) -> tuple:
        """Returns the functions, in the order of the kernels' indices."""
        return self._clearances, self._rows

    def _clearances(self, arguments: Arguments) -> int:
        """Measures clearances of spheres; see `sphere_clearances`."""
        sphere, p_WS, R_WL, reach, found = (arguments[i] for i in range(5))
        spheres = self._robot.placed(sphere, p_WS, R_WL)
        # The limit is slightly more than the distance, since rows at the limit
        # are omitted.
        rows = self._field.clearances(spheres, np.nextafter(reach, np.inf))
        found[:] = np.minimum(rows.per_sphere(len(sphere)), reach)
        return 0

    def _rows(self, arguments: Arguments) -> int:
        """Finds all rows in a state; see `rows_within`."""
        p_WS, R_WL, within = (arguments[i] for i in range(3))
        every = np.arange(len(p_WS))
        spheres = self._robot.placed(every, p_WS, R_WL)
        rows = self._field.clearances(spheres, within)
        return self._calls.handed(Packed(row_arrays(rows)))
