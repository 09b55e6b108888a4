"""Makes objects to grasp: cans, boxes and bottles, and meshes of a folder.

For example, PyBullet's wheel contains 1,000 random meshes: unpack the wheel,
and use its folder `pybullet_data/random_urdfs`. PyBullet need not be installed.
"""

import dataclasses as dc
import re
from pathlib import Path

import numpy as np
import scipy
from pydrake.math import RigidTransform, RotationMatrix

from remosplat_drake.base.errors import FileError
from remosplat_drake.scene.objects.convex_hull import ConvexHull, read_hull
from remosplat_drake.scene.objects.scene_object import SceneObject, Solid
from remosplat_drake.scene.primitive_scene import Box, Cylinder

MASS = 0.05, 1.0
"""Least and greatest mass of an object [kg]."""

DENSITY = 150.0, 900.0
"""Least and greatest density [kg/m^3], those of a half-empty box and of a full
can."""

_STEADY = 0.008
"""An object is stable if its projected centre of mass is at least this far
inside the edge of its base [m]."""

_SIDES = 12  # Sizes of a bottle.


@dc.dataclass(frozen=True, eq=False)
class MeshLibrary:
    """Convex hulls of the meshes of a folder.

    Attributes:
        hulls: Vertices of each hull in the mesh's frame, by name, (v, 3) [m].
        refused: Problems of the unusable meshes, keyed by name.
    """

    hulls: dict[str, np.ndarray]
    refused: dict[str, str]


def read_mesh_library(folder: Path) -> MeshLibrary:
    """Reads a folder of URDF files with one mesh each.

    Args:
        folder: A folder of folders, each with a URDF file and its mesh.

    Raises:
        FileError: The folder has no such files.
    """
    hulls, refused = {}, {}
    for path in sorted(folder.glob("*/*.urdf")):
        mesh = re.search(r'mesh filename="([^"]+)"', path.read_text())
        scale = re.search(r'scale="([-+.\deE]+)', path.read_text())
        if mesh is None:
            refused[path.stem] = "has no mesh"
            continue
        try:
            vertices = read_hull(
                path.parent / mesh[1], float(scale[1]) if scale else 1.0
            )
            hulls[path.stem] = ConvexHull(RigidTransform(), vertices).vertices
        except (FileError, ValueError) as error:
            refused[path.stem] = str(error)
    if not hulls and not refused:
        raise FileError(folder, "has no folders with URDF files")
    return MeshLibrary(hulls, refused)


def standing(vertices: np.ndarray) -> np.ndarray | None:
    """Turns a hull so that it stands; moves its centre of mass to the origin.

    The hull stands on the face for which the projected centre of mass is
    farthest from the face's edge.

    Args:
        vertices: Vertices of the hull, shape (v, 3) [m].

    Returns:
        The vertices, shape (v, 3) [m]; None if the hull is not stable on any
        face.
    """
    hull = scipy.spatial.ConvexHull(vertices)
    p_cm = _centroid(vertices, hull)
    best, steady = None, _STEADY
    for plane in np.unique(hull.equations.round(6), axis=0):
        normal, height = plane[:3], plane[3]
        on = np.abs(vertices @ normal + height) < 1e-5
        if on.sum() < 3:
            continue
        aside = np.eye(3)[np.argmin(np.abs(normal))]
        u = np.cross(normal, aside)
        u /= np.linalg.norm(u)
        R = np.stack([u, -np.cross(normal, u), -normal])
        base = (vertices[on] - p_cm) @ R[:2].T
        try:
            edges = scipy.spatial.ConvexHull(base).equations
        except scipy.spatial.QhullError:
            continue
        margin = -edges[:, 2].max()
        if margin > steady:
            best, steady = (vertices - p_cm) @ R.T, margin
    return best


def draw_solid(rng: np.random.Generator) -> Solid:
    """Draws a can, a box or a bottle that stands at the origin.

    - Can: radius 25 to 36 mm, height 80 to 150 mm.
    - Box: 30 to 70 by 40 to 100 by 70 to 150 mm.
    - Bottle: a body of radius 25 to 35 mm and height 90 to 130 mm, and a neck
      of a third of this radius that extends 50 mm above it.

    Args:
        rng: Source of randomness.
    """
    kind = rng.integers(3)
    if kind == 0:
        radius, half_height = rng.uniform([0.025, 0.04], [0.036, 0.075])
        return Cylinder(RigidTransform(), radius, half_height, "can")
    if kind == 1:
        half = rng.uniform([0.015, 0.02, 0.035], [0.035, 0.05, 0.075])
        return Box(RigidTransform(), half, "box")
    radius, height = rng.uniform([0.025, 0.09], [0.035, 0.13])
    angle = 2.0 * np.pi * np.arange(_SIDES) / _SIDES
    ring = np.column_stack([np.cos(angle), np.sin(angle)])
    profile = ((1.0, 0.0), (1.0, height), (1 / 3, height + 0.05))
    points = [
        np.column_stack([scale * radius * ring, np.full(_SIDES, z)])
        for scale, z in profile
    ]
    vertices = np.concatenate(points)
    hull = scipy.spatial.ConvexHull(vertices)
    return ConvexHull(
        RigidTransform(), vertices - _centroid(vertices, hull), "bottle"
    )


def placed_object(
    solid: Solid,
    name: str,
    p_W: np.ndarray,
    yaw: float,
    rng: np.random.Generator,
) -> SceneObject:
    """Makes an object from a solid, at a place, with a random mass.

    Args:
        solid: A solid that stands at the origin.
        name: The object's name.
        p_W: Point in W on which it stands, shape (3,) [m].
        yaw: Yaw of the object [rad].
        rng: Source of randomness for the density.
    """
    low, high = SceneObject(name, solid).corners[:, 2]
    X_WO = RigidTransform(
        RotationMatrix.MakeZRotation(yaw), [p_W[0], p_W[1], p_W[2] - low]
    )
    mass = volume(solid) * rng.uniform(*DENSITY)
    assert high > low
    placed = SceneObject(name, solid, float(np.clip(mass, *MASS)))
    return placed.at(X_WO)


def volume(solid: Solid) -> float:
    """Returns the volume of a solid [m^3]."""
    if isinstance(solid, Box):
        return float(8.0 * np.prod(solid.half_extents))
    if isinstance(solid, Cylinder):
        return 2.0 * np.pi * solid.radius**2 * solid.half_height
    return float(scipy.spatial.ConvexHull(solid.vertices).volume)


def _centroid(
    vertices: np.ndarray, hull: scipy.spatial.ConvexHull
) -> np.ndarray:
    """Centre of mass of a homogeneous hull, summed over its tetrahedra."""
    middle = vertices.mean(axis=0)
    corners = vertices[hull.simplices] - middle
    weights = np.abs(np.linalg.det(corners))
    return middle + (weights @ corners.sum(axis=1)) / (4.0 * weights.sum())
