"""A lock on a folder of compiled kernels, which many processes may share."""

import fcntl
import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path


@contextmanager
def locked(folder: str | Path, how: int = fcntl.LOCK_EX) -> Iterator[None]:
    """Locks a folder for the block; not at all where that is not possible.

    Args:
        folder: The folder.
        how: LOCK_EX, or LOCK_SH where the block only reads.
    """
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
