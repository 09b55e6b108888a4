"""`SharedRecord`: numbers in shared memory, protected by a seqlock."""

import struct
from multiprocessing.shared_memory import SharedMemory

_TRIES = 3
_COUNTER = 8


class SharedRecord:
    """A tuple of doubles that one process writes and another reads.

    Neither process waits for the other, since the writer may be stopped or
    killed in the middle of a record. The writer makes a counter odd, writes,
    and makes the counter even. If a reader finds the counter odd, or changed
    after reading, it keeps its previous record. This requires that the
    processor does not reorder stores and loads, as on x86-64.

    A record may be passed to a child process as an argument. Both processes
    must call `close`.
    """

    def __init__(self, size: int, name: str | None = None):
        """Makes a record of zeros, or opens a record of another process.

        Args:
            size: Number of values.
            name: Name of existing shared memory. None makes new memory, which
                this object owns.
        """
        self._size = size
        self._owns = name is None
        self._memory = SharedMemory(
            name, create=self._owns, size=_COUNTER + 8 * size
        )
        assert self._memory.buf is not None
        self._bytes = self._memory.buf
        self._count = self._bytes[:_COUNTER].cast("q")
        self._layout = struct.Struct(f"{size}d")
        self._latest = (0.0,) * size

    def __reduce__(self):
        return SharedRecord, (self._size, self._memory.name)

    def write(self, values: tuple[float, ...]) -> None:
        """Replaces the record; only one process may do so."""
        count = self._count[0]
        self._count[0] = count + 1
        self._layout.pack_into(self._bytes, _COUNTER, *values)
        self._count[0] = count + 2

    def read(self) -> tuple[float, ...]:
        """Returns the latest record that was written completely."""
        for _ in range(_TRIES):
            count = self._count[0]
            values = self._layout.unpack_from(self._bytes, _COUNTER)
            if count % 2 == 0 and self._count[0] == count:
                self._latest = values
                break
        return self._latest

    def close(self) -> None:
        """Closes the memory; its owner also removes it."""
        self._count.release()
        self._memory.close()
        if self._owns:
            self._memory.unlink()
