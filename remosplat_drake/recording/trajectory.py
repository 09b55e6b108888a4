"""`Trajectory`: the robot's motion at each tick, and its .npz file."""

import dataclasses as dc
import math
import struct
import zlib
from collections.abc import Sequence
from pathlib import Path
from tokenize import TokenError
from typing import IO
from zipfile import BadZipFile, ZipFile

import numpy as np

from remosplat_drake.base.atomic_file import atomic_write
from remosplat_drake.base.errors import FileError, RemoSplatError
from remosplat_drake.base.reading import reads_file
from remosplat_drake.recording.mover_log import (
    PREFIX,
    from_arrays,
    to_arrays,
)
from remosplat_drake.scene.mover import Movers

_DAMAGES = (
    ValueError,
    EOFError,
    BadZipFile,
    KeyError,
    MemoryError,
    NotImplementedError,  # An unknown compression.
    RuntimeError,  # An encrypted file.
    SyntaxError,
    TokenError,  # NumPy's, for a damaged header of an array.
    TypeError,
    struct.error,
    zlib.error,
)
"""Exceptions that NumPy and zipfile raise for a damaged archive."""

_ALWAYS_ALLOWED = 2**24
"""The declared size of an array is checked only if it exceeds this size
[bytes]."""

_MAX_RATIO = 1000
"""Greatest compression ratio of deflate."""


@dc.dataclass(frozen=True, eq=False)
class Trajectory:
    """T control ticks and the final configuration.

    Attributes:
        time: Time of each tick, shape (T,) [s].
        q: Configurations at the ticks and at the end, shape (T + 1, n_q).
        u: Commands, each constant until the next tick, shape (T, n_u).
        status: Names from `tick_report.STATUSES`, shape (T,).
        scale: Factors by which verification scaled the commands, 0 to 1,
            shape (T,).
        clearance: Smallest clearance by the distance oracle at each tick, shape
            (T,) [m]; inf beyond the influence distance.
        timings: Wall-clock times of each phase of the ticks, keyed by phase,
            each of shape (T,) [s].
        movers: The movers at each of T ticks; empty if there are no movers.
    """

    time: np.ndarray
    q: np.ndarray
    u: np.ndarray
    status: np.ndarray
    scale: np.ndarray
    clearance: np.ndarray
    timings: dict[str, np.ndarray]
    movers: Sequence[Movers] = ()

    def __len__(self) -> int:
        return len(self.time)


def save_trajectory(trajectory: Trajectory, path: Path) -> None:
    """Writes a trajectory as a NumPy .npz archive, atomically.

    The arrays have the names of the attributes. The arrays of timings have the
    prefix `timing_`, and those of movers the prefix `mover_`.

    Raises:
        FileError: The file cannot be written.
    """
    arrays = {
        field.name: getattr(trajectory, field.name)
        for field in dc.fields(trajectory)
        if field.name not in ("timings", "movers")
    }
    arrays |= to_arrays(trajectory.movers)
    timings = {f"timing_{k}": v for k, v in trajectory.timings.items()}
    with atomic_write(path, "wb") as file:
        np.savez_compressed(file, **arrays, **timings)  # pyright: ignore


@reads_file
def load_trajectory(path: Path) -> Trajectory:
    """Reads a trajectory that `save_trajectory` wrote.

    Raises:
        FileError: The file cannot be read, or is not a trajectory.
    """
    try:
        with open(path, "rb") as file:
            _check_sizes(path, file)
            with np.load(file) as archive:
                arrays = dict(archive)
    except OSError as error:
        raise FileError(path, error.strerror or str(error)) from error
    # A damaged archive may raise many kinds of exceptions, and may declare huge
    # arrays.
    except _DAMAGES as error:
        raise FileError(path, "is not a recorded trajectory") from error
    timings = {
        key.removeprefix("timing_"): arrays.pop(key)
        for key in list(arrays)
        if key.startswith("timing_")
    }
    moving = {
        key: arrays.pop(key) for key in list(arrays) if key.startswith(PREFIX)
    }
    try:
        movers = from_arrays(moving)
        trajectory = Trajectory(**arrays, timings=timings, movers=movers)
    except (*_DAMAGES, IndexError, RemoSplatError) as error:
        raise FileError(path, "is not a recorded trajectory") from error
    if not _is_consistent(trajectory):
        raise FileError(path, "is not a recorded trajectory")
    return trajectory


def _check_sizes(path: Path, file: IO[bytes]) -> None:
    """Raises an error if an array's declared size exceeds the stored size.

    The header of an array declares its size in memory, and the zip archive the
    stored size.
    """
    with ZipFile(file) as archive:
        for member in archive.infolist():
            most = max(_ALWAYS_ALLOWED, _MAX_RATIO * member.compress_size)
            if member.file_size > most:
                raise FileError(
                    path, f"{member.filename} is damaged: it is too large"
                )
            with archive.open(member) as stream:
                version = np.lib.format.read_magic(stream)
                read = (
                    np.lib.format.read_array_header_1_0
                    if version == (1, 0)
                    else np.lib.format.read_array_header_2_0
                )
                shape, _, dtype = read(stream)
            if math.prod(shape) * dtype.itemsize > member.file_size:
                raise FileError(path, f"{member.filename} is truncated")
    file.seek(0)


def _is_consistent(trajectory: Trajectory) -> bool:
    """Whether all arrays have the same number of ticks and the right types."""
    t = trajectory
    one = [t.time, t.status, t.scale, t.clearance, *t.timings.values()]
    if any(array.shape != t.time.shape for array in one) or t.time.ndim != 1:
        return False
    if t.movers and len(t.movers) != len(t):
        return False
    tables = t.q.ndim == t.u.ndim == 2
    numbers = [a for a in (*one, t.q, t.u) if a is not t.status]
    return (
        tables
        and (len(t.q), len(t.u)) == (len(t) + 1, len(t))
        and t.status.dtype.kind == "U"
        and all(array.dtype.kind in "fiu" for array in numbers)
    )
