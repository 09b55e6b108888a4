"""Draws shapes that Meshcat does not have: tubes along lines, and triads."""

import numpy as np
from pydrake.geometry import Cylinder, Meshcat, Rgba
from pydrake.math import RigidTransform, RotationMatrix

_SIDES = 6
_LAST = 9.0  # Three.js draws in this order, from small to large.
_AXIS_COLORS = (
    Rgba(0.86, 0.20, 0.18),
    Rgba(0.20, 0.62, 0.25),
    Rgba(0.16, 0.36, 0.85),
)


def rigid_transform(X: np.ndarray) -> RigidTransform:
    """Converts a pose to Drake's type; makes its rotation orthonormal.

    Args:
        X: The pose, shape (4, 4), orthonormal up to rounding.
    """
    R = RotationMatrix.ProjectToRotationMatrix(X[:3, :3])
    return RigidTransform(R, X[:3, 3])


def tube_mesh(
    p_WP: np.ndarray, radius: float, sides: int = _SIDES
) -> tuple[np.ndarray, np.ndarray]:
    """Makes the triangle mesh of a closed tube around a polyline.

    The cross-section does not twist along the polyline: each direction across
    the tube is the previous direction, projected perpendicular to the new
    tangent.

    Args:
        p_WP: Points of the polyline in W, shape (n, 3) [m]; n >= 2, and
            neighbouring points differ.
        radius: Radius of the tube [m].
        sides: Number of corners of the cross-section.

    Returns:
        Vertices, shape (n * sides, 3) [m], and faces, shape (m, 3), whose
        normals point outward by the right-hand rule.
    """
    n = len(p_WP)
    steps = np.diff(p_WP, axis=0)
    steps /= np.linalg.norm(steps, axis=1, keepdims=True)
    tangents = np.vstack([steps[:1], steps[:-1] + steps[1:], steps[-1:]])
    across = np.eye(3)[np.abs(tangents[0]).argmin()]
    angle = 2 * np.pi * np.arange(sides) / sides
    rings = np.empty((n, sides, 3))
    for i, tangent in enumerate(tangents):
        # If the polyline reverses, there is no mean direction, so the direction
        # of the last segment is used.
        if tangent @ tangent < 1e-6:
            tangent = steps[i - 1]
        tangent = tangent / np.linalg.norm(tangent)
        across = across - (across @ tangent) * tangent
        across /= np.linalg.norm(across)
        other = np.cross(tangent, across)
        rings[i] = p_WP[i] + radius * (
            np.outer(np.cos(angle), across) + np.outer(np.sin(angle), other)
        )
    return rings.reshape(-1, 3), _tube_faces(n, sides)


def _tube_faces(n: int, sides: int) -> np.ndarray:
    """Returns two triangles per side and segment, and a fan at each end."""
    k = np.arange(sides)
    turn = (k + 1) % sides
    row = sides * np.arange(n - 1)[:, None]
    near, near_next = row + k, row + turn
    far, far_next = near + sides, near_next + sides
    fan = np.arange(1, sides - 1)
    start = np.stack([0 * fan, fan + 1, fan], axis=1)
    end = np.stack([0 * fan, fan, fan + 1], axis=1) + sides * (n - 1)
    return np.concatenate(
        [
            np.stack([near, near_next, far], axis=-1).reshape(-1, 3),
            np.stack([near_next, far_next, far], axis=-1).reshape(-1, 3),
            start,
            end,
        ]
    ).astype(np.int32)


def draw_triad(
    meshcat: Meshcat, path: str, length: float = 0.14, radius: float = 0.005
):
    """Draws a frame's axes x, y, z in red, green, blue, in front of all else.

    Args:
        meshcat: The Meshcat server.
        path: Path in the scene tree below which the axes are drawn.
        length: Length of an axis [m].
        radius: Radius of an axis [m].
    """
    for i, (axis, color) in enumerate(zip("xyz", _AXIS_COLORS, strict=True)):
        direction = np.eye(3)[i]
        meshcat.SetObject(f"{path}/{axis}", Cylinder(radius, length), color)
        meshcat.SetTransform(
            f"{path}/{axis}",
            RigidTransform(
                RotationMatrix.MakeFromOneVector(direction, axis_index=2),
                direction * length / 2,
            ),
        )
        shine_through(meshcat, f"{path}/{axis}")


def shine_through(meshcat: Meshcat, path: str):
    """Makes an object visible through objects in front of it.

    Args:
        meshcat: The Meshcat server.
        path: Path of the object.
    """
    node = f"{path}/<object>"
    meshcat.SetProperty(node, "material.depthTest", False)
    meshcat.SetProperty(node, "renderOrder", _LAST)
