"""Makes the true distance field of a real scene from its capture's depth."""

import hashlib
from functools import lru_cache
from pathlib import Path

import numpy as np
from pydrake.math import RigidTransform

from remosplat_drake.base import resources
from remosplat_drake.base.atomic_file import atomic_write
from remosplat_drake.capture.formats import read_capture
from remosplat_drake.oracle.point_distance import PointDistanceField
from remosplat_drake.reconstruction.measured_space import measured_points
from remosplat_drake.signals.distance_field import DistanceField

SURFACES_VERSION = 1
"""Version of the surface extraction. Increase it whenever the same capture
would give other surfaces; it is part of the cache file's name."""


@lru_cache(maxsize=1)
def capture_field(
    folder: Path, X_WG: tuple[float, ...], max_depth: float
) -> DistanceField:
    """Makes the distance field of a capture's measured surfaces.

    Args:
        folder: Folder of the capture.
        X_WG: Pose of the capture's world frame G in W: the upper 12 entries of
            the 4 x 4 matrix, row by row.
        max_depth: Largest depth that is used [m]; deeper pixels are ignored.

    Returns:
        The field of distances to the measured points, expressed in W.

    Raises:
        RemoSplatError: The capture cannot be read.
    """
    p_GP = _surfaces(folder, max_depth)
    transform = RigidTransform(np.reshape(X_WG, (3, 4)))
    return PointDistanceField(transform.multiply(p_GP.T).T)


def _surfaces(folder: Path, max_depth: float) -> np.ndarray:
    """Returns the surface points (n, 3) in G [m], cached on disk."""
    name = f"{content_digest(folder)}-{max_depth:g}-v{SURFACES_VERSION}.npy"
    path = resources.cache_dir() / "measured-surfaces" / name
    try:
        return np.load(path)
    except (OSError, ValueError):
        pass  # Not there yet, or damaged.
    capture = read_capture(folder, max_depth=max_depth)
    everywhere = np.full(3, np.inf)
    p_GP = measured_points(capture, -everywhere, everywhere)
    with atomic_write(path, "wb") as file:
        np.save(file, p_GP)
    return p_GP


@lru_cache(maxsize=8)
def content_digest(path: Path) -> str:
    """Returns a digest of a file, or of a folder's files and their names."""
    digest = hashlib.sha256()
    files = [path] if path.is_file() else sorted(path.rglob("*"))
    for file in files:
        if file.is_file():
            digest.update(file.relative_to(path.parent).as_posix().encode())
            digest.update(file.read_bytes())
    return digest.hexdigest()[:16]
