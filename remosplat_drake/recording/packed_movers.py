"""`PackedMovers`: the movers at a tick, as compact arrays."""

import dataclasses as dc
from collections.abc import Iterable, Sequence

import numpy as np
from pydrake.math import RigidTransform, RotationMatrix

from remosplat_drake.scene.mover import Mover, Movers

_LENGTHS = (3, 1, 9, 3, 3, 3, 4)
"""Numbers of a mover: half extents, radius, orientation R_WM, position,
velocity, angular velocity, bounds."""

ORIENTATION = slice(4, 13)
"""Where the orientation is among them."""


@dc.dataclass(frozen=True, eq=False, slots=True)
class PackedMovers:
    """`Movers` as numbers, without the cameras that found them.

    Attributes:
        stamp: Time of their poses [s].
        names: The names of k movers.
        rows: Their numbers, shape (k, 26).
    """

    stamp: float
    names: tuple[str, ...]
    rows: np.ndarray

    @staticmethod
    def of(movers: Movers) -> "PackedMovers":
        """Packs movers; `unpacked` returns them with the same digits.

        Args:
            movers: The movers.
        """
        *columns, _ = movers.arrays.values
        return PackedMovers(
            movers.stamp,
            tuple(mover.name for mover in movers),
            np.column_stack(
                [
                    column.reshape(len(movers), length)
                    for column, length in zip(columns, _LENGTHS, strict=True)
                ]
            ),
        )

    def unpacked(self) -> Movers:
        """Returns the movers."""
        return Movers(self.stamp, list(map(mover_of, self.names, self.rows)))


def mover_of(name: str, row: np.ndarray) -> Mover:
    """Makes a mover.

    Args:
        name: Its name.
        row: Its numbers, shape (26,).

    Raises:
        FieldError: A number is invalid.
    """
    half_extents, radius, R_WM, p_WM, v_WM, w_WM, bounds = np.split(
        row, np.cumsum(_LENGTHS)[:-1]
    )
    return Mover(
        name,
        RigidTransform(RotationMatrix(R_WM.reshape(3, 3)), p_WM),
        half_extents,
        float(radius[0]),
        v_WM,
        w_WM,
        *map(float, bounds),
    )


class PackedTicks(Sequence[Movers]):
    """The movers at each of T ticks; an element is unpacked on access."""

    def __init__(self, ticks: Iterable[PackedMovers]):
        """Takes the movers of the ticks, packed.

        Args:
            ticks: Those of each tick; several may share one.
        """
        self._ticks = tuple(ticks)

    def __len__(self) -> int:
        return len(self._ticks)

    def __getitem__(self, index):
        if isinstance(index, slice):
            return PackedTicks(self._ticks[index])
        return self._ticks[index].unpacked()
