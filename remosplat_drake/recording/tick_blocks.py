"""`TickBlocks`: stores the columns of a long run on disk, in blocks."""

import dataclasses as dc
import math
import tempfile
from collections.abc import Iterator, Mapping

import numpy as np


@dc.dataclass(frozen=True, slots=True)
class _Place:
    """Position of an array in the file."""

    offset: int
    shape: tuple[int, ...]
    dtype: np.dtype


class TickBlocks:
    """Appends blocks of arrays to a temporary file without a name.

    The operating system deletes the file when the program ends for any reason.
    It is in the folder that the variable `TMPDIR` names, or else in the
    system's folder for temporary files. Writing does not wait for the disk.
    """

    def __init__(self):
        """Prepares the object; the first block creates the file."""
        self._file = None
        self._size = 0
        self._blocks: list[dict[str, _Place]] = []

    def append(self, arrays: Mapping[str, np.ndarray]) -> str:
        """Appends a block; if that fails, the file is unchanged.

        Args:
            arrays: The arrays of the block, keyed by name.

        Returns:
            The error message of the operating system if the write failed, such
            as "No space left on device"; otherwise an empty string.
        """
        places, offset = {}, self._size
        for name, values in arrays.items():
            places[name] = _Place(offset, values.shape, values.dtype)
            offset += values.nbytes
        try:
            if self._file is None:
                # The file is closed when this object is deleted.
                self._file = tempfile.TemporaryFile(buffering=0)  # noqa: SIM115
            self._file.seek(self._size)
            rest = memoryview(b"".join(v.tobytes() for v in arrays.values()))
            while len(rest):
                rest = rest[self._file.write(rest) :]
        except OSError as error:
            return error.strerror or str(error)
        self._size = offset
        self._blocks.append(places)
        return ""

    def read(self, start: str) -> Iterator[dict[str, np.ndarray]]:
        """Reads the arrays of each block whose names begin with a given text.

        Args:
            start: The text with which the names begin; an empty text selects
                all arrays.

        Raises:
            OSError: The file cannot be read.
        """
        for places in self._blocks:
            yield {
                name: self._read(place)
                for name, place in places.items()
                if name.startswith(start)
            }

    @property
    def names(self) -> set[str]:
        """Names of all arrays of all blocks."""
        return set().union(*self._blocks)

    def _read(self, place: _Place) -> np.ndarray:
        assert self._file is not None
        self._file.seek(place.offset)
        count = math.prod(place.shape)
        return np.fromfile(self._file, place.dtype, count).reshape(place.shape)
