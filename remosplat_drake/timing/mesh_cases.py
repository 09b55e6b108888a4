"""Benchmarks: distances to a mesh by other packages, to surfels by this one.

The scene is the shipped table. There are two meshes of it: one with the fewest
possible triangles, and one with as many triangles as the splat has surfels. The
spheres are those of `oracle_cases`. All queries return the closest points as
NumPy arrays, and use one thread.
"""

from collections.abc import Callable
from functools import partial
from typing import NamedTuple

import numpy as np

from remosplat_drake.base import resources
from remosplat_drake.base.system_libraries import import_optional
from remosplat_drake.generation.primitive_surfels import surfel_splat
from remosplat_drake.oracle.sphere_to_ellipsoid import SphereToEllipsoidField
from remosplat_drake.scene.primitive_scene import PrimitiveScene
from remosplat_drake.scene.rmmi import read_scene
from remosplat_drake.timing.measuring import Case
from remosplat_drake.timing.optional_packages import is_there
from remosplat_drake.timing.oracle_cases import MAX_DISTANCE, robot_spheres
from remosplat_drake.timing.primitive_mesh import surface_triangles

PACKAGES = ("open3d", "trimesh", "rtree")
"""Packages whose queries are timed if they are installed."""

_SCENE = "package://remosplat_drake/models/scenes/table/scene.json"

_LONGEST = 0.085
"""If triangle edges are at most this long, the mesh has as many triangles as
the splat has surfels [m]."""

Query = Callable[[np.ndarray], np.ndarray]
"""Function that finds the closest point of a mesh to each of n points, shape
(n, 3)."""


class MeshQuery(NamedTuple):
    """A package's query for the closest points of a mesh.

    Attributes:
        make: Function that makes the query from the corners of the mesh's
            triangles, shape (t, 3, 3).
        packages: The packages that must be installed.
    """

    make: Callable[[np.ndarray], Query]
    packages: tuple[str, ...]


def mesh_cases() -> list[Case]:
    """Makes benchmarks of our query, and of those of installed packages."""
    scene, spheres = table(), robot_spheres()
    splat = surfel_splat(scene)
    clearances = SphereToEllipsoidField(splat).clearances
    cases = [
        Case(
            f"mesh: ours, {len(splat)} surfels{where}",
            partial(clearances, spheres, reach),
        )
        for where, reach in (
            (f", at most {MAX_DISTANCE:g} m", MAX_DISTANCE),
            ("", np.inf),
        )
    ]
    for triangles in (
        surface_triangles(scene),
        surface_triangles(scene, _LONGEST),
    ):
        cases += [
            Case(
                f"mesh: {name}, {len(triangles)} triangles",
                partial(query.make(triangles), spheres.p_WS),
            )
            for name, query in QUERIES.items()
            if all(map(is_there, query.packages))
        ]
    return cases


def table() -> PrimitiveScene:
    """Reads the true scene of the shipped table, with its floor."""
    return read_scene(resources.resolve(_SCENE))


def _embree(triangles: np.ndarray) -> Query:
    o3d = import_optional("open3d", "Embree", "reconstruction")
    scene = o3d.t.geometry.RaycastingScene(nthreads=1)
    p_WV, indices = _indexed(triangles)
    scene.add_triangles(p_WV.astype(np.float32), indices.astype(np.uint32))

    def query(p_WQ: np.ndarray) -> np.ndarray:
        points = o3d.core.Tensor(p_WQ.astype(np.float32))
        return scene.compute_closest_points(points, 1)["points"].numpy()

    return query


def _rtree(triangles: np.ndarray) -> Query:
    import trimesh

    closest = trimesh.proximity.ProximityQuery(
        trimesh.Trimesh(*_indexed(triangles))
    )
    return lambda p_WQ: closest.on_surface(p_WQ)[0]


def _indexed(triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Returns vertices (3t, 3), and each triangle's vertex indices (t, 3)."""
    p_WV = triangles.reshape(-1, 3)
    return p_WV, np.arange(len(p_WV)).reshape(-1, 3)


QUERIES = {
    "Embree (Open3D)": MeshQuery(_embree, ("open3d",)),
    "R-tree (trimesh)": MeshQuery(_rtree, ("trimesh", "rtree")),
}
"""Queries of meshes, by their names in tables."""
