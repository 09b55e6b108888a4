"""Benchmarks of the time from a splat's file to the first distance query.

The splat's file and the cache are in a temporary folder, which is removed at
the end.
"""

import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory

from remosplat_drake.oracle.sphere_to_ellipsoid import SphereToEllipsoidField
from remosplat_drake.splat.formats import read_splat, write_splat
from remosplat_drake.timing.measuring import Case
from remosplat_drake.timing.oracle_cases import (
    MAX_DISTANCE,
    robot_spheres,
    table_scene,
)

_CACHE = "XDG_CACHE_HOME"


def file_cases() -> list[Case]:
    """Makes benchmarks of a PLY of a million discs, with and without cache."""
    folder = TemporaryDirectory(prefix="remosplat-bench-")
    write_splat(Path(folder.name) / "discs.ply", table_scene(1_000_000))
    return [
        Case("file: 1M discs, without cache", partial(_ready_first, folder)),
        Case("file: 1M discs, ready again", partial(_ready, folder)),
    ]


def _ready_first(folder: TemporaryDirectory) -> None:
    """Reads the file and queries its distance field, with an empty cache."""
    shutil.rmtree(_cache(folder), ignore_errors=True)
    _ready(folder)


def _ready(folder: TemporaryDirectory) -> None:
    """Reads the file and queries its distance field."""
    with _cache_in(_cache(folder)):
        splat = read_splat(Path(folder.name) / "discs.ply")
        field = SphereToEllipsoidField(splat)
        field.clearances(robot_spheres(), MAX_DISTANCE)


def _cache(folder: TemporaryDirectory) -> Path:
    return Path(folder.name) / "cache"


@contextmanager
def _cache_in(folder: Path) -> Iterator[None]:
    """Uses another folder as the user's cache inside a `with` block."""
    before = os.environ.get(_CACHE)
    os.environ[_CACHE] = str(folder)
    try:
        yield
    finally:
        if before is None:
            del os.environ[_CACHE]
        else:
            os.environ[_CACHE] = before
