"""Lets processes that compile at the same time share Numba's cache.

Numba keeps the variants of a function in numbered files, and an index of them.
Two processes that save a variant each take the same number, and the index of
the one that is last forgets the other's; who reads in between may get another
variant, or an older one, than the index says. So they take turns.
"""

import fcntl
import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from typing import Any

from numba.core import caching


class LockedCacheFile(caching.IndexDataCacheFile):
    """The index and the files of one function, which one process changes."""

    def save(self, key: Any, data: Any) -> None:
        """Keeps a variant of the function, as Numba does, alone.

        Where it cannot be written, as on a full disk, it is not kept.
        """
        with _locked(self._cache_path, fcntl.LOCK_EX), suppress(OSError):
            super().save(key, data)

    def load(self, key: Any) -> Any:
        """Returns a variant, None if it is not kept, while none is saved."""
        with _locked(self._cache_path, fcntl.LOCK_SH):
            return super().load(key)


@contextmanager
def _locked(folder: str, how: int) -> Iterator[None]:
    """Locks a folder for the block; not at all where that is not possible."""
    try:
        descriptor = os.open(folder, os.O_RDONLY)
    except OSError:
        yield
        return
    try:
        with suppress(OSError):
            fcntl.flock(descriptor, how)
        yield
    finally:
        # A child that was forked meanwhile holds the descriptor, too.
        with suppress(OSError):
            fcntl.flock(descriptor, fcntl.LOCK_UN)
        os.close(descriptor)


def take_turns() -> None:
    """Makes Numba lock its cache from now on in this process."""
    caching.IndexDataCacheFile = LockedCacheFile
