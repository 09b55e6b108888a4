"""Hierarchies that took long to build, kept in the user's cache.

A file is named by the digest of the boxes that it is of, so that it can never
be of other ones. One that is cut off, damaged, or of another version is deleted
and made again.
"""

import contextlib
import hashlib
import os
from pathlib import Path

import numpy as np

from remosplat_drake.base import resources
from remosplat_drake.base.array_file import FileKind, open_arrays, write_arrays
from remosplat_drake.base.errors import FileError, RemoSplatError
from remosplat_drake.splat.bvh import (
    BoundingVolumeHierarchy,
    are_sound,
    hierarchy_of,
)

LEAST_BOXES = 200_000
"""Number of boxes from which on a hierarchy is kept: fewer take no time."""

MOST_BYTES = 1 << 30
"""Size up to which the cache grows; then what was not used longest goes."""

_KIND = FileKind("hierarchy", b"RSDBVH\0\0", 1)
"""The version rises when hierarchies are built or searched in another way."""


def kept_hierarchy(boxes: np.ndarray) -> BoundingVolumeHierarchy:
    """Returns the hierarchy of boxes, from the cache or to it.

    Args:
        boxes: What `hierarchy_of` takes; the rows' order is not kept.
    """
    if len(boxes) < LEAST_BOXES:
        return hierarchy_of(boxes)
    digest = hashlib.sha256(np.ascontiguousarray(boxes).data).hexdigest()[:32]
    path = cache_folder() / f"{digest}.bvh"
    kept = _read(path, len(boxes))
    if kept is not None:
        return kept
    hierarchy = hierarchy_of(boxes)
    _write(path, hierarchy)
    return hierarchy


def cache_folder() -> Path:
    """Returns the folder of the kept hierarchies; it may not exist."""
    return resources.cache_dir() / "hierarchies"


def _read(path: Path, n: int) -> BoundingVolumeHierarchy | None:
    """A kept hierarchy of n boxes; None if there is none that is sound."""
    if not path.is_file():
        return None
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
        os.utime(path)  # It has been used.
    return BoundingVolumeHierarchy.of(nodes, order.astype(np.int64))


def _write(path: Path, hierarchy: BoundingVolumeHierarchy) -> None:
    arrays = {
        "nodes": hierarchy.nodes,
        "order": hierarchy.order.astype(np.int32),
    }
    # A cache that cannot be written is no reason to stop.
    with contextlib.suppress(FileError):
        write_arrays(path, _KIND, {}, arrays)
        _drop_oldest(path)


def _drop_oldest(newest: Path) -> None:
    """Deletes what was not used longest, until the rest is small enough."""
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
