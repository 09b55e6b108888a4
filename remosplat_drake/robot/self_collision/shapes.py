"""`CollisionShapes`: the convex shapes of a robot's links, from its model file.

Self-collision is defined by these shapes. Each collision geometry of the model
file counts as its convex hull, as in Drake. A link without collision geometry
counts as its spheres.
"""

import dataclasses as dc
from functools import cached_property

import numpy as np
import scipy
from pydrake.geometry import (
    Box,
    Capsule,
    Convex,
    Cylinder,
    Ellipsoid,
    GeometryId,
    Mesh,
    Role,
    SceneGraph,
    SceneGraphInspector,
    Shape,
    Sphere,
)
from pydrake.multibody.plant import MultibodyPlant

from remosplat_drake.base.directions import spread_directions
from remosplat_drake.base.errors import FieldError
from remosplat_drake.base.lanes import WIDTH
from remosplat_drake.robot.model_file import add_robot_model
from remosplat_drake.robot.payload import Payload
from remosplat_drake.robot.robot_description import RobotDescription
from remosplat_drake.robot.self_collision.pair_arrays import (
    ShapeArrays,
    vertex_blocks,
)
from remosplat_drake.robot.sphere_model import SphereModel

_SIDES = 32
"""Number of sides of the prism that encloses a cylinder. The prism is 0.5 %
wider than the cylinder."""

_DIRECTIONS = 300
"""Number of corners of the polyhedron that encloses an ellipsoid. The
polyhedron is 2 % larger than the ellipsoid."""

_CORNERS = np.array(
    [[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], float
)


@dc.dataclass(frozen=True, eq=False)
class ConvexShape:
    """All points within a radius of the convex hull of some vertices.

    A sphere has one vertex, a capsule has two vertices, and a polyhedron has
    radius zero.

    Attributes:
        vertices: Vertices in the link's frame, shape (v, 3) [m].
        radius: The radius [m].
    """

    vertices: np.ndarray
    radius: float = 0.0


@dc.dataclass(frozen=True, eq=False)
class CollisionShapes:
    """The s convex shapes of a robot.

    Attributes:
        links: Name of each shape's link, length s.
        shapes: The shapes, in their links' frames, length s.
        by_spheres: Names of the links without collision geometry in the model
            file, which their spheres represent.
    """

    links: tuple[str, ...]
    shapes: tuple[ConvexShape, ...]
    by_spheres: tuple[str, ...] = ()

    def __len__(self) -> int:
        return len(self.links)

    def of(self, link: str) -> list[ConvexShape]:
        """Returns the shapes of one link; there may be none."""
        pairs = zip(self.links, self.shapes, strict=True)
        return [shape for name, shape in pairs if name == link]

    def with_payload(self, payload: Payload) -> "CollisionShapes":
        """Returns the shapes, with the payload's shapes at the end.

        Args:
            payload: The payload.
        """
        pieces = [ConvexShape(np.array(piece)) for piece in payload.pieces]
        return CollisionShapes(
            (*self.links, *[payload.name] * len(pieces)),
            (*self.shapes, *pieces),
            self.by_spheres,
        )

    @cached_property
    def radius(self) -> np.ndarray:
        """The radius of each shape, shape (s,) [m]."""
        return np.array([shape.radius for shape in self.shapes], float)

    @cached_property
    def center(self) -> np.ndarray:
        """The centre of each shape's box in its link's frame, (s, 3) [m]."""
        return np.array(
            [
                0.5 * (s.vertices.min(axis=0) + s.vertices.max(axis=0))
                for s in self.shapes
            ]
        ).reshape(-1, 3)

    @cached_property
    def half(self) -> np.ndarray:
        """Half edges of each shape's box, ignoring its radius, (s, 3) [m]."""
        return np.array(
            [0.5 * np.ptp(s.vertices, axis=0) for s in self.shapes]
        ).reshape(-1, 3)

    @cached_property
    def reach(self) -> np.ndarray:
        """Greatest distance of a vertex from its shape's centre, (s,) [m]."""
        return np.array(
            [
                np.linalg.norm(s.vertices - center, axis=1).max()
                for s, center in zip(self.shapes, self.center, strict=True)
            ]
        )

    def arrays(self, body: np.ndarray) -> ShapeArrays:
        """Returns the shapes packed for kernels.

        Args:
            body: Body of the robot's tree that each shape is fixed to, shape
                (s,).
        """
        blocks = [vertex_blocks(shape.vertices) for shape in self.shapes]
        first = np.cumsum([0, *map(len, blocks)]).astype(np.int64)
        return ShapeArrays(
            np.concatenate([np.zeros((0, 3, WIDTH)), *blocks]),
            first,
            self.radius,
            self.center,
            self.half,
            self.reach,
            body,
        )


def read_collision_shapes(
    description: RobotDescription, spheres: SphereModel
) -> CollisionShapes:
    """Reads the convex shapes of all links from a robot's model file.

    Args:
        description: The robot, whose `model` names the file.
        spheres: Spheres of links without collision geometry.

    Raises:
        FileError: The file is not a model.
        FieldError: A shape of a link has no bounded hull.
    """
    plant, scene_graph = MultibodyPlant(0.0), SceneGraph()
    plant.RegisterAsSourceForSceneGraph(scene_graph)
    add_robot_model(description, plant)
    plant.Finalize()
    inspector = scene_graph.model_inspector()
    links, shapes = [], []
    for geometry in inspector.GetAllGeometryIds(Role.kProximity):
        body = plant.GetBodyFromFrameId(inspector.GetFrameId(geometry))
        links.append(body.name())
        shapes.append(_shape(description, inspector, geometry, body.name()))
    by_spheres = [x for x in dict.fromkeys(spheres.links) if x not in links]
    for link in by_spheres:
        own = spheres.on_link(link)
        for p_LS, radius in zip(own.p_LS, own.radius, strict=True):
            links.append(link)
            shapes.append(ConvexShape(p_LS[None].copy(), float(radius)))
    return CollisionShapes(tuple(links), tuple(shapes), tuple(by_spheres))


def _shape(
    description: RobotDescription,
    inspector: SceneGraphInspector,
    geometry: GeometryId,
    link: str,
) -> ConvexShape:
    """Returns the convex shape of one geometry in its link's frame."""
    shape = inspector.GetShape(geometry)
    core = convex_core(shape)
    if core is None:
        problem = f"link {link!r} collides as a {type(shape).__name__}, which"
        problem += " has no bounded hull; use a box, mesh, cylinder or capsule"
        raise FieldError(description.source, "model", problem)
    X_LG = inspector.GetPoseInFrame(geometry)
    p_LV = X_LG.multiply(core.vertices.T).T
    return ConvexShape(np.ascontiguousarray(p_LV), core.radius)


def convex_core(shape: Shape) -> ConvexShape | None:
    """Returns the convex shape of a geometry in its own frame.

    Cylinders and ellipsoids are enclosed by polyhedra.

    Args:
        shape: The geometry's shape.

    Returns:
        The convex shape; None if the geometry is unbounded.
    """
    if isinstance(shape, Sphere):
        return ConvexShape(np.zeros((1, 3)), shape.radius())
    if isinstance(shape, Capsule):
        ends = 0.5 * shape.length() * np.array([[0, 0, -1.0], [0, 0, 1.0]])
        return ConvexShape(ends, shape.radius())
    if isinstance(shape, Box):
        return ConvexShape(0.5 * np.array(shape.size()) * _CORNERS)
    if isinstance(shape, Cylinder):
        angle = 2 * np.pi * np.arange(_SIDES) / _SIDES
        r = shape.radius() / np.cos(np.pi / _SIDES)
        rim = np.column_stack([r * np.cos(angle), r * np.sin(angle)])
        half = 0.5 * shape.length()
        return ConvexShape(
            np.vstack([np.insert(rim, 2, z, axis=1) for z in (-half, half)])
        )
    if isinstance(shape, Ellipsoid):
        axes = np.array([shape.a(), shape.b(), shape.c()])
        return ConvexShape(axes * _around_unit_ball())
    if isinstance(shape, (Mesh, Convex)):
        hull = shape.GetConvexHull()
        count = hull.num_vertices()
        return ConvexShape(np.array([hull.vertex(i) for i in range(count)]))
    return None


def _around_unit_ball() -> np.ndarray:
    """Evenly spread corners of a polyhedron that contains the unit ball."""
    p = spread_directions(_DIRECTIONS)
    return p / -scipy.spatial.ConvexHull(p).equations[:, 3].max()
