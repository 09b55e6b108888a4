"""Converts the movers of a run to arrays for a file, and back."""

from array import array
from collections.abc import Mapping, Sequence

import numpy as np
from pydrake.common.eigen_geometry import Quaternion
from pydrake.math import RotationMatrix

from remosplat_drake.recording.packed_movers import (
    ORIENTATION,
    PackedMovers,
    mover_of,
)
from remosplat_drake.scene.mover import Mover, Movers

PREFIX = "mover_"
"""Prefix of the names of arrays with movers."""

_NUMBERS, _QUATERNION = 21, slice(4, 8)
"""Columns of a row: those of `PackedMovers`, but with the orientation as a
quaternion."""


def to_arrays(ticks: Sequence[Movers]) -> dict[str, np.ndarray]:
    """Converts the movers of T ticks to arrays.

    Args:
        ticks: The movers at each tick.

    Returns:
        The arrays, keyed by name: `mover_tick`, the tick of each of m rows,
        shape (m,); `mover_name`, shape (m,); `mover_state`, shape (m, 21); and
        `mover_stamp`, the time of the movers' state at each tick, shape (T,)
        [s]. There are no arrays if there is no tick.
    """
    if not ticks:
        return {}
    tick, name, state, stamp = [], [], array("d"), array("d")
    for k, movers in enumerate(ticks):
        packed = PackedMovers.of(movers)
        tick += [k] * len(movers)
        name += packed.names
        stamp.append(packed.stamp)
        for row in packed.rows:
            state.extend(_with_quaternion(row))
    return {
        PREFIX + "tick": np.array(tick, int),
        PREFIX + "name": np.array(name, str),
        PREFIX + "state": np.array(state).reshape(-1, _NUMBERS),
        PREFIX + "stamp": np.array(stamp),
    }


def from_arrays(arrays: Mapping[str, np.ndarray]) -> tuple[Movers, ...]:
    """Restores the movers of each tick from the result of `to_arrays`.

    Raises:
        KeyError: An array is missing.
        ValueError: An array has another shape, or a value is unusable.
    """
    if not arrays:
        return ()
    tick, name, state, stamp = (
        arrays[PREFIX + part] for part in ("tick", "name", "state", "stamp")
    )
    if state.shape != (len(tick), _NUMBERS) or name.shape != tick.shape:
        raise ValueError("arrays of movers have inconsistent lengths")
    ticks: list[list[Mover]] = [[] for _ in stamp]
    for k, what, row in zip(tick, name, state, strict=True):
        ticks[int(k)].append(_mover(str(what), row))
    return tuple(
        Movers(float(when), movers)
        for when, movers in zip(stamp, ticks, strict=True)
    )


def _with_quaternion(row: np.ndarray) -> np.ndarray:
    """Converts the row of a mover to the format of a file."""
    R_WM = RotationMatrix(row[ORIENTATION].reshape(3, 3))
    wxyz = R_WM.ToQuaternion().wxyz()
    before, after = row[: ORIENTATION.start], row[ORIENTATION.stop :]
    return np.concatenate([before, wxyz, after])


def _mover(name: str, row: np.ndarray) -> Mover:
    """Makes the mover of a row in a file."""
    wxyz = row[_QUATERNION]
    R_WM = RotationMatrix(Quaternion(wxyz / np.linalg.norm(wxyz)))
    before, after = row[: _QUATERNION.start], row[_QUATERNION.stop :]
    return mover_of(
        name, np.concatenate([before, R_WM.matrix().ravel(), after])
    )
