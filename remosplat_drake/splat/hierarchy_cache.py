"""Keeps large hierarchies in the user's cache.

The name of a file is a key of the inputs from which its boxes were computed. If
a file is truncated, damaged or of another version, it is deleted, and its
hierarchy is computed again.
"""

import contextlib
import os
from pathlib import Path

import numpy as np

from remosplat_drake.base import resources
from remosplat_drake.base.array_file import FileKind, open_arrays, write_arrays
from remosplat_drake.base.errors import FileError, RemoSplatError
from remosplat_drake.splat.bvh import (
    BoundingVolumeHierarchy,
    are_sound,
)

LEAST_BOXES = 200_000
"""A hierarchy is kept only if it has at least this many boxes. Building a
smaller hierarchy takes little time."""

MOST_BYTES = 1 << 30
"""Largest size of the cache [bytes]. If it is exceeded, the least recently used
files are deleted."""

_KIND = FileKind("hierarchy", b"RSDBVH\0\0", 2)
"""Version of the files. It must be increased if the construction or the search
of hierarchies changes."""


def is_kept(n: int) -> bool:
    """Returns whether a hierarchy of n boxes is large enough for the cache."""
    return n >= LEAST_BOXES


def kept_hierarchy(key: str, n: int) -> BoundingVolumeHierarchy | None:
    """Returns a hierarchy of n boxes from the cache; None if there is none.

    The structure of the hierarchy is checked, so that kernels can traverse it
    safely. Its boxes are not checked.

    Args:
        key: Key of all inputs from which the boxes are computed; it consists of
            letters and digits.
        n: Number of boxes.
    """
    path = _path(key)
    try:
        file = open_arrays(path, _KIND, None)
        nodes, order = file.array("nodes"), file.array("order")
    except RemoSplatError:
        nodes, order = np.zeros(0), np.zeros(0)
    if not are_sound(nodes, order, n):
        with contextlib.suppress(OSError):
            path.unlink()
        return None
    with contextlib.suppress(OSError):
        os.utime(path)  # Marks it as recently used.
    return BoundingVolumeHierarchy.of(nodes, order)


def keep_hierarchy(key: str, hierarchy: BoundingVolumeHierarchy) -> None:
    """Keeps a hierarchy in the cache.

    Args:
        key: The key, as for `kept_hierarchy`.
        hierarchy: The hierarchy.
    """
    arrays = {
        "nodes": hierarchy.nodes,
        "order": hierarchy.order,
    }
    # If the cache cannot be written, this is not an error.
    with contextlib.suppress(FileError):
        write_arrays(_path(key), _KIND, {}, arrays)
        _drop_oldest(_path(key))


def cache_folder() -> Path:
    """Returns the folder of the kept hierarchies, which need not exist."""
    return resources.cache_dir() / "hierarchies"


def _path(key: str) -> Path:
    return cache_folder() / f"{key}.bvh"


def _drop_oldest(newest: Path) -> None:
    """Deletes the least recently used files until the cache is small enough."""
    files = []
    for path in newest.parent.glob("*.bvh"):
        with contextlib.suppress(OSError):
            state = path.stat()
            files.append((state.st_mtime_ns, state.st_size, path))
    total = sum(size for _, size, _ in files)
    for _, size, path in sorted(files):
        if total <= MOST_BYTES or path == newest:
            return
        with contextlib.suppress(OSError):
            path.unlink()
        total -= size
