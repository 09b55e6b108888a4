"""Makes triangle meshes of a robot's links, for a viewer in a browser."""

import dataclasses as dc
from pathlib import Path

import numpy as np
import trimesh
from pydrake.geometry import (
    Box,
    Capsule,
    Convex,
    Cylinder,
    Ellipsoid,
    Mesh,
    Shape,
    Sphere,
)
from pydrake.math import RigidTransform

from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.visualization.drawn_plant import drawn_plant

# In glTF files, y is up; Drake rotates them so that z is up.
_X_MESH_GLTF = np.array(
    [[1, 0, 0, 0], [0, 0, -1, 0], [0, 1, 0, 0], [0, 0, 0, 1.0]]
)


@dc.dataclass(frozen=True, eq=False)
class Shapes:
    """Triangle meshes of a robot's links, in the frames of the links.

    Attributes:
        coloured: Meshes with their colours, keyed by link name. Links without
            visual geometry are absent.
        joined: One mesh per link, which contains all shapes of the link,
            without colours.
    """

    coloured: dict[str, list[trimesh.Trimesh]]
    joined: dict[str, trimesh.Trimesh]


def robot_shapes(robot: RobotModel) -> Shapes:
    """Makes the meshes of all links.

    Args:
        robot: The robot.
    """
    drawn = drawn_plant(robot)
    shapes: dict[str, list[trimesh.Trimesh]] = {}
    for body in drawn.bodies:
        for content in drawn.looks(body):
            colour = content.colour
            rgba = colour.r(), colour.g(), colour.b(), colour.a()
            for mesh in _meshes(content.shape, rgba):
                mesh.apply_transform(content.X_LG.GetAsMatrix4())
                shapes.setdefault(body.name(), []).append(mesh)
    return Shapes(shapes, {name: _joined(m) for name, m in shapes.items()})


def _joined(meshes: list[trimesh.Trimesh]) -> trimesh.Trimesh:
    bare = [trimesh.Trimesh(m.vertices, m.faces, process=False) for m in meshes]
    return trimesh.util.concatenate(bare)


def _meshes(shape: Shape, colour: tuple) -> list[trimesh.Trimesh]:
    """Makes the coloured meshes of one of Drake's shapes."""
    if isinstance(shape, Mesh | Convex):
        return _from_file(Path(shape.source().path()), shape.scale3())
    make = trimesh.creation
    if isinstance(shape, Box):
        mesh = make.box(extents=shape.size())
    elif isinstance(shape, Sphere):
        mesh = make.icosphere(radius=shape.radius())
    elif isinstance(shape, Cylinder):
        mesh = make.cylinder(shape.radius(), shape.length())
    elif isinstance(shape, Capsule):
        mesh = make.capsule(shape.length(), shape.radius())
        mesh.apply_translation(-mesh.bounds.mean(axis=0))
    elif isinstance(shape, Ellipsoid):
        mesh = make.icosphere()
        mesh.apply_scale([shape.a(), shape.b(), shape.c()])
    else:
        return []
    mesh.visual = _material(colour)
    return [mesh]


def _from_file(path: Path, scale: np.ndarray) -> list[trimesh.Trimesh]:
    scene = trimesh.load_scene(path)
    meshes = [m for m in scene.dump() if isinstance(m, trimesh.Trimesh)]
    for mesh in meshes:
        if path.suffix in (".gltf", ".glb"):
            mesh.apply_transform(_X_MESH_GLTF)
        mesh.apply_scale(scale)
    return meshes


def _material(colour: tuple) -> trimesh.visual.TextureVisuals:
    material = trimesh.visual.material.PBRMaterial(
        baseColorFactor=list(colour), metallicFactor=0.1, roughnessFactor=0.6
    )
    return trimesh.visual.TextureVisuals(material=material)


def wxyz_position(X: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Splits a pose into the parts that viser uses.

    Args:
        X: The pose, shape (4, 4).

    Returns:
        Unit quaternion wxyz, shape (4,), and position, shape (3,) [m].
    """
    rotation = RigidTransform(X).rotation().ToQuaternion().wxyz()
    return rotation, X[:3, 3].copy()
