"""Movers of a run as arrays, so that they can be kept in a file."""

from collections.abc import Mapping, Sequence

import numpy as np
from pydrake.common.eigen_geometry import Quaternion
from pydrake.math import RigidTransform, RotationMatrix

from remosplat_drake.scene.mover import Mover, Movers

PREFIX = "mover_"
"""What the names of all these arrays begin with."""

_COLUMNS = (3, 1, 4, 3, 3, 3, 4)
"""Numbers of a row: half extents, radius, quaternion, position,
velocity, angular velocity, bounds."""


def to_arrays(ticks: Sequence[Movers]) -> dict[str, np.ndarray]:
    """Writes the movers of T ticks as arrays.

    Args:
        ticks: What moved at each tick.

    Returns:
        `mover_tick`, the tick of each of m rows, shape (m,); `mover_name`,
        shape (m,); `mover_state`, shape (m, 21); and `mover_stamp`, when it
        was so at each tick, shape (T,) [s]. Nothing for no tick.
    """
    if not ticks:
        return {}
    found = [(k, m) for k, movers in enumerate(ticks) for m in movers]
    state = [_row(mover) for _, mover in found]
    return {
        PREFIX + "tick": np.array([k for k, _ in found], int),
        PREFIX + "name": np.array([m.name for _, m in found], str),
        PREFIX + "state": np.array(state, float).reshape(-1, sum(_COLUMNS)),
        PREFIX + "stamp": np.array([movers.stamp for movers in ticks]),
    }


def from_arrays(arrays: Mapping[str, np.ndarray]) -> tuple[Movers, ...]:
    """Reads what `to_arrays` wrote.

    Raises:
        KeyError: An array is missing.
        ValueError: An array has another shape, or a value is unusable.
    """
    if not arrays:
        return ()
    tick, name, state, stamp = (
        arrays[PREFIX + part] for part in ("tick", "name", "state", "stamp")
    )
    if state.shape != (len(tick), sum(_COLUMNS)) or name.shape != tick.shape:
        raise ValueError("arrays of movers do not fit each other")
    ticks: list[list[Mover]] = [[] for _ in stamp]
    for k, what, row in zip(tick, name, state, strict=True):
        ticks[int(k)].append(_mover(str(what), row))
    return tuple(
        Movers(float(when), movers)
        for when, movers in zip(stamp, ticks, strict=True)
    )


def _row(mover: Mover) -> np.ndarray:
    return np.concatenate(
        [
            mover.half_extents,
            [mover.radius],
            mover.X_WM.rotation().ToQuaternion().wxyz(),
            mover.X_WM.translation(),
            mover.v_WM,
            mover.w_WM,
            [
                mover.max_speed,
                mover.max_acceleration,
                mover.velocity_error,
                mover.position_error,
            ],
        ]
    )


def _mover(name: str, row: np.ndarray) -> Mover:
    half_extents, radius, wxyz, p_WM, v_WM, w_WM, bounds = np.split(
        row, np.cumsum(_COLUMNS)[:-1]
    )
    R_WM = RotationMatrix(Quaternion(wxyz / np.linalg.norm(wxyz)))
    return Mover(
        name,
        RigidTransform(R_WM, p_WM),
        half_extents,
        float(radius[0]),
        v_WM,
        w_WM,
        *map(float, bounds),
    )
