"""Keeps expensive hierarchies in the user's cache.

A file is named by the inputs of its boxes. A truncated or damaged file, or one
of another version, is deleted and computed again.
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
"""Least number of boxes of a kept hierarchy; smaller ones are built quickly."""

MOST_BYTES = 1 << 30
"""Largest size of the cache; beyond it, the least recently used files are
deleted."""

_KIND = FileKind("hierarchy", b"RSDBVH\0\0", 2)
"""Increase the version when the construction or search of hierarchies
changes."""


def is_kept(n: int) -> bool:
    """Returns whether a hierarchy of n boxes is worth a file."""
    return n >= LEAST_BOXES


def kept_hierarchy(key: str, n: int) -> BoundingVolumeHierarchy | None:
    """Returns the hierarchy of n boxes from the cache; None if there is none.

    Kernels can safely traverse it; whether it contains the boxes is not
    checked.

    Args:
        key: Name for all inputs of the boxes, of letters and digits.
        n: Number of the boxes.
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
        key: As for `kept_hierarchy`.
        hierarchy: The hierarchy.
    """
    arrays = {
        "nodes": hierarchy.nodes,
        "order": hierarchy.order,
    }
    # A cache that cannot be written is not an error.
    with contextlib.suppress(FileError):
        write_arrays(_path(key), _KIND, {}, arrays)
        _drop_oldest(_path(key))


def cache_folder() -> Path:
    """Returns the folder of the kept hierarchies; it may not exist."""
    return resources.cache_dir() / "hierarchies"


def _path(key: str) -> Path:
    return cache_folder() / f"{key}.bvh"


def _drop_oldest(newest: Path) -> None:
    """Deletes the least recently used files until the rest is small enough."""
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
