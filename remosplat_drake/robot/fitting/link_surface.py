"""Samples points on the surfaces of a robot's links.

Collision shapes are sampled exactly, meshes triangle by triangle. A mesh that
is a collision shape in the model file counts as its convex hull, as in Drake's
collision queries.
"""

import numpy as np
from pydrake.geometry import (
    Box,
    Capsule,
    Convex,
    Cylinder,
    Ellipsoid,
    Mesh,
    Role,
    SceneGraphInspector,
    Shape,
    Sphere,
)
from pydrake.multibody.plant import MultibodyPlant

from remosplat_drake.base.errors import RemoSplatError


def sample_shape(
    shape: Shape, spacing: float, rng: np.random.Generator
) -> np.ndarray:
    """Draws random points on a shape's surface, one for each spacing^2.

    Args:
        shape: Any of Drake's bounded shapes.
        spacing: Mean distance of neighbouring points [m].
        rng: Source of randomness.

    Returns:
        Points p_GS in the shape's frame, shape (n, 3) [m].

    Raises:
        RemoSplatError: The shape has no bounded surface.
    """
    if isinstance(shape, Box):
        half = 0.5 * np.array(shape.size())
        corners = half * _CORNERS
        return sample_triangles(corners, _BOX_TRIANGLES, spacing, rng)
    if isinstance(shape, Sphere):
        return shape.radius() * _unit_vectors(
            _count(4 * np.pi * shape.radius() ** 2, spacing), rng
        )
    if isinstance(shape, Ellipsoid):
        axes = np.array([shape.a(), shape.b(), shape.c()])
        area = 4 * np.pi * axes.max() ** 2
        return axes * _unit_vectors(_count(area, spacing), rng)
    if isinstance(shape, (Cylinder, Capsule)):
        return _sample_round(shape, spacing, rng)
    if isinstance(shape, (Mesh, Convex)):
        hull = shape.GetConvexHull()
        vertices = np.array(
            [hull.vertex(i) for i in range(hull.num_vertices())]
        )
        triangles = _hull_triangles(vertices)
        return sample_triangles(vertices, triangles, spacing, rng)
    raise RemoSplatError(
        f"a {type(shape).__name__} has no bounded surface to cover"
    )


def sample_triangles(
    vertices: np.ndarray,
    triangles: np.ndarray,
    spacing: float,
    rng: np.random.Generator,
) -> np.ndarray:
    """Draws random points on triangles, uniform by area; adds all vertices.

    Args:
        vertices: Vertices, shape (v, 3) [m].
        triangles: Vertex indices, shape (t, 3).
        spacing: Mean distance of neighbouring points [m].
        rng: Source of randomness.

    Returns:
        Shape (n, 3) [m].
    """
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    area = 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1)
    n = _count(area.sum(), spacing)
    chosen = rng.choice(len(triangles), n, p=area / area.sum())
    # Square roots make the barycentric coordinates uniform by area.
    root, s = np.sqrt(rng.random((n, 1))), rng.random((n, 1))
    points = (
        (1 - root) * a[chosen]
        + root * (1 - s) * b[chosen]
        + root * s * c[chosen]
    )
    return np.vstack([points, vertices])


def collision_surface(
    plant: MultibodyPlant,
    inspector: SceneGraphInspector,
    link: str,
    spacing: float,
    rng: np.random.Generator,
) -> np.ndarray:
    """Draws points on all collision shapes of a link.

    Args:
        plant: The plant.
        inspector: The inspector of its scene graph.
        link: Name of the link.
        spacing: Mean distance of neighbouring points [m].
        rng: Source of randomness.

    Returns:
        Points in the link's frame, shape (n, 3) [m].
    """
    frame = plant.GetBodyFrameIdOrThrow(plant.GetBodyByName(link).index())
    parts = [np.zeros((0, 3))]
    for geometry in inspector.GetGeometries(frame, Role.kProximity):
        p_GS = sample_shape(inspector.GetShape(geometry), spacing, rng)
        X_LG = inspector.GetPoseInFrame(geometry)
        parts.append((X_LG @ p_GS.T).T)
    return np.vstack(parts)


def _sample_round(
    shape: Cylinder | Capsule, spacing: float, rng: np.random.Generator
) -> np.ndarray:
    """Draws points on the side of a cylinder or capsule, and on its ends."""
    r, length = shape.radius(), shape.length()
    angle = rng.uniform(0, 2 * np.pi, _count(2 * np.pi * r * length, spacing))
    z = rng.uniform(-length / 2, length / 2, len(angle))
    side = np.column_stack([r * np.cos(angle), r * np.sin(angle), z])
    if isinstance(shape, Capsule):
        ends = r * _unit_vectors(_count(4 * np.pi * r**2, spacing), rng)
    else:
        n = _count(2 * np.pi * r**2, spacing)
        angle = rng.uniform(0, 2 * np.pi, n)
        # Every fourth point lies on the rim, since the rim is an edge.
        rho = r * np.where(np.arange(n) % 4, np.sqrt(rng.random(n)), 1.0)
        up = rng.choice([-1e-12, 1e-12], n)
        ends = np.column_stack([rho * np.cos(angle), rho * np.sin(angle), up])
    ends[:, 2] += np.sign(ends[:, 2]) * length / 2
    return np.vstack([side, ends])


def _count(area: float, spacing: float) -> int:
    return max(int(np.ceil(area / spacing**2)), 32)


def _unit_vectors(n: int, rng: np.random.Generator) -> np.ndarray:
    v = rng.standard_normal((n, 3))
    return v / np.linalg.norm(v, axis=1, keepdims=True)


def _hull_triangles(vertices: np.ndarray) -> np.ndarray:
    from scipy.spatial import ConvexHull

    return ConvexHull(vertices).simplices


_CORNERS = np.array(
    [[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], float
)
_BOX_TRIANGLES = _hull_triangles(_CORNERS)
