"""`PackedMovers`: the movers (moving objects) at a tick as compact arrays."""

import dataclasses as dc
from collections.abc import Collection, Iterable, Mapping, Sequence

import numpy as np
from pydrake.math import RigidTransform, RotationMatrix

from remosplat_drake.scene.mover import Mover, Movers

_LENGTHS = (3, 1, 9, 3, 3, 3, 4)
"""Number of entries of each quantity in the row of a mover. The quantities are
half extents, radius, orientation R_WM, position, velocity, angular velocity,
and bounds."""

MOVER = "mover_"
"""Prefix of the columns of movers."""

ORIENTATION = slice(4, 13)
"""Indices of the orientation R_WM in the row of a mover."""


@dc.dataclass(frozen=True, eq=False, slots=True)
class PackedMovers:
    """`Movers` as numbers, without the cameras that found them.

    Attributes:
        stamp: Time of their poses [s].
        names: The names of k movers.
        rows: The quantities of the movers, shape (k, 26).
    """

    stamp: float
    names: tuple[str, ...]
    rows: np.ndarray

    @staticmethod
    def of(movers: Movers) -> "PackedMovers":
        """Packs movers, which `unpacked` restores exactly.

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
    """Makes a mover from its numbers.

    Args:
        name: Name of the mover.
        row: Numbers of the mover, shape (26,).

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


def to_columns(ticks: Collection[PackedMovers]) -> dict[str, np.ndarray]:
    """Converts the movers of T ticks to arrays.

    Ticks that share a message about movers refer to one copy of the message.

    Args:
        ticks: The movers of each tick.

    Returns:
        The arrays, keyed by name: `mover_message`, the index of each tick's
        message, shape (T,); `mover_stamp` and `mover_count` of the m messages,
        shape (m,); `mover_name`, shape (k,), and `mover_row`, shape (k, 26), of
        the k movers in all messages. There are no arrays if there is no tick.
    """
    if not ticks:
        return {}
    messages = list({id(packed): packed for packed in ticks}.values())
    number = {id(packed): i for i, packed in enumerate(messages)}
    return {
        "mover_message": np.array([number[id(packed)] for packed in ticks]),
        "mover_stamp": np.array([packed.stamp for packed in messages]),
        "mover_count": np.array([len(packed.names) for packed in messages]),
        "mover_name": np.array(
            [name for packed in messages for name in packed.names], str
        ),
        "mover_row": np.concatenate([packed.rows for packed in messages]),
    }


def from_columns(columns: Mapping[str, np.ndarray]) -> list[PackedMovers]:
    """Restores the movers of each tick from the result of `to_columns`.

    Args:
        columns: The arrays, keyed by name.
    """
    if "mover_message" not in columns:
        return []
    ends = np.cumsum(columns["mover_count"])[:-1]
    messages = [
        PackedMovers(float(stamp), tuple(map(str, names)), rows)
        for stamp, names, rows in zip(
            columns["mover_stamp"],
            np.split(columns["mover_name"], ends),
            np.split(columns["mover_row"], ends),
            strict=True,
        )
    ]
    return [messages[i] for i in columns["mover_message"]]


class PackedTicks(Sequence[Movers]):
    """Sequence of the movers at T ticks; an element is unpacked on access."""

    def __init__(self, ticks: Iterable[PackedMovers]):
        """Stores packed movers.

        Args:
            ticks: The packed movers of each tick; ticks may share an object.
        """
        self._ticks = tuple(ticks)

    def __len__(self) -> int:
        return len(self._ticks)

    def __getitem__(self, index):
        if isinstance(index, slice):
            return PackedTicks(self._ticks[index])
        return self._ticks[index].unpacked()
