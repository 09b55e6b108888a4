"""`ConvexHull`: a solid that is the convex hull of points."""

import dataclasses as dc
from pathlib import Path

import numpy as np
import scipy
from pydrake.geometry import Convex
from pydrake.math import RigidTransform

from remosplat_drake.base.errors import FileError, RemoSplatError

SUFFIXES = (".obj", ".gltf", ".vtk")
"""Formats of the mesh files that Drake reads."""


@dc.dataclass(frozen=True, eq=False)
class ConvexHull:
    """A solid convex hull.

    Attributes:
        X_WP: Pose of the hull's frame P in W.
        vertices: Vertices of the hull in P, shape (v, 3) [m].
        name: Display name of the hull; may be empty.

    Raises:
        RemoSplatError: The points are not finite, or span no volume.
    """

    X_WP: RigidTransform
    vertices: np.ndarray
    name: str = ""

    def __post_init__(self):
        points = np.array(self.vertices, float)
        if points.ndim != 2 or points.shape[1] != 3:
            raise RemoSplatError(
                f"vertices must have shape (v, 3), got {points.shape}"
            )
        if not np.isfinite(points).all():
            raise RemoSplatError("vertices must be finite")
        try:
            outer = scipy.spatial.ConvexHull(points)
        except (scipy.spatial.QhullError, ValueError) as error:
            raise RemoSplatError("the vertices span no volume") from error
        vertices = points[outer.vertices]
        vertices.flags.writeable = False
        object.__setattr__(self, "vertices", vertices)

    def __deepcopy__(self, memo) -> "ConvexHull":
        return self

    @property
    def top(self) -> float:
        """Height of the highest point in W [m]."""
        R_WP, p_WP = self.X_WP.rotation().matrix(), self.X_WP.translation()
        return float(p_WP[2] + (self.vertices @ R_WP[2]).max())


def read_hull(path: Path, scale: float = 1.0) -> np.ndarray:
    """Reads the vertices of the convex hull of a mesh.

    Args:
        path: A mesh file that Drake reads: .obj, .gltf or .vtk.
        scale: Length of the file's unit [m].

    Returns:
        Shape (v, 3) [m].

    Raises:
        FileError: The file is of another format, cannot be read, or spans no
            volume.
    """
    if path.suffix.lower() not in SUFFIXES:
        valid = ", ".join(SUFFIXES)
        raise FileError(path, f"is not a mesh that Drake reads; valid: {valid}")
    try:
        hull = Convex(path, scale).GetConvexHull()
    except (RuntimeError, ValueError) as error:
        raise FileError(path, " ".join(str(error).split())) from error
    return np.array([hull.vertex(i) for i in range(hull.num_vertices())])
