"""`Surface`: points on an object with outward normals."""

import dataclasses as dc

import numpy as np
import scipy

from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.scene.box_surface import box_surface, cell_centers
from remosplat_drake.scene.objects.scene_object import Solid
from remosplat_drake.scene.primitive_scene import Box, Cylinder
from remosplat_drake.splat.gaussian_splat import GaussianSplat
from remosplat_drake.splat.shortest_axes import shortest_axes


@dc.dataclass(frozen=True, eq=False)
class Surface:
    """n points on an object's surface, in its frame O.

    Attributes:
        points: The points, shape (n, 3) [m].
        normals: Outward unit normals at the points, shape (n, 3).
        spacing: Distance of neighbouring points [m].
    """

    points: np.ndarray
    normals: np.ndarray
    spacing: float

    def __len__(self) -> int:
        return len(self.points)


def surface_of_solid(solid: Solid, spacing: float = 0.004) -> Surface:
    """Places points on a box, a cylinder or a convex hull.

    Args:
        solid: The solid.
        spacing: Greatest distance of neighbouring points [m].
    """
    if isinstance(solid, Box):
        return Surface(*box_surface(solid.half_extents, spacing), spacing)
    if isinstance(solid, Cylinder):
        return _surface_of_cylinder(solid.radius, solid.half_height, spacing)
    hull = scipy.spatial.ConvexHull(solid.vertices)
    triangles = hull.simplices.copy()
    corner = solid.vertices[triangles]
    across = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
    inward = np.einsum("ti,ti->t", across, hull.equations[:, :3]) < 0.0
    triangles[inward] = triangles[inward][:, [0, 2, 1]]
    return surface_of_mesh(solid.vertices, triangles, spacing)


def surface_of_mesh(
    vertices: np.ndarray, triangles: np.ndarray, spacing: float = 0.004
) -> Surface:
    """Places points on the triangles of a mesh.

    Args:
        vertices: Vertices in O, shape (v, 3) [m].
        triangles: Vertices of each triangle, counter-clockwise seen from
            outside, shape (t, 3).
        spacing: Greatest distance of neighbouring points [m].

    Raises:
        RemoSplatError: No triangle has an area.
    """
    points, normals = [], []
    for a, b, c in vertices[triangles]:
        across = np.cross(b - a, c - a)
        area = np.linalg.norm(across)
        if area < 1e-12:
            continue
        longest = max(np.linalg.norm(x) for x in (b - a, c - b, a - c))
        n = int(np.ceil(longest / spacing))
        # The triangle is divided into n^2 small triangles. These are the
        # centres of the upright small triangles, then those of the inverted
        # ones.
        i, j = np.meshgrid(np.arange(n), np.arange(n), indexing="ij")
        lower = i + j < n
        upper = i + j < n - 1
        u = np.concatenate([i[lower] + 1 / 3, i[upper] + 2 / 3]) / n
        v = np.concatenate([j[lower] + 1 / 3, j[upper] + 2 / 3]) / n
        points.append(a + u[:, None] * (b - a) + v[:, None] * (c - a))
        normals.append(np.tile(across / area, (len(u), 1)))
    if not points:
        raise RemoSplatError("the mesh has no triangle with an area")
    return Surface(np.concatenate(points), np.concatenate(normals), spacing)


def surface_of_splat(splat: GaussianSplat, spacing: float = 0.004) -> Surface:
    """Makes surface points of an object's splats, one for each cell of a grid.

    A splat's normal is its shortest axis, and points away from the middle of
    all splats. The normal is therefore wrong on the inner side of a cup.

    Args:
        splat: The splats of the object, in O.
        spacing: Side of the grid's cells [m].
    """
    p_OK = np.asarray(splat.p_GK, float)
    normals = shortest_axes(splat)
    outward = np.einsum("ni,ni->n", normals, p_OK - np.median(p_OK, axis=0))
    normals = normals * np.where(outward < 0.0, -1.0, 1.0)[:, None]
    cells = np.floor(p_OK / spacing).astype(np.int64)
    _, kept = np.unique(cells, axis=0, return_index=True)
    kept.sort()
    return Surface(p_OK[kept], normals[kept], spacing)


def _surface_of_cylinder(
    radius: float, half_height: float, spacing: float
) -> Surface:
    # The number of points on each ring is even, so that each point has an
    # opposite point.
    n = 2 * int(np.ceil(np.pi * radius / spacing))
    angle = 2.0 * np.pi * np.arange(n) / n
    ring = np.column_stack([np.cos(angle), np.sin(angle), np.zeros(n)])
    heights = cell_centers(half_height, spacing)
    up = np.array([0.0, 0.0, 1.0])
    points = [radius * ring + z * up for z in heights]
    normals = [ring] * len(heights)
    grid = cell_centers(radius, spacing)
    x, y = (values.ravel() for values in np.meshgrid(grid, grid))
    inside = x**2 + y**2 < radius**2
    cap = np.column_stack([x, y, np.zeros(x.size)])[inside]
    for side in (-1.0, 1.0):
        points.append(cap + side * half_height * up)
        normals.append(np.tile(side * up, (len(cap), 1)))
    return Surface(np.concatenate(points), np.concatenate(normals), spacing)
