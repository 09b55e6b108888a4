"""`ObjectField`: distances to objects, changed by contact rules."""

import hashlib
from collections.abc import Sequence
from functools import cached_property
from typing import NamedTuple

import numpy as np
import scipy

from remosplat_drake.base.kernels import helper, kernel
from remosplat_drake.base.kernels.packed import Packed
from remosplat_drake.oracle.composite import CompositeDistanceField
from remosplat_drake.oracle.signed_distance import (
    Primitives,
    in_primitive,
    in_world,
    primitive_arrays,
    primitive_distance,
    write_answer,
)
from remosplat_drake.oracle.sphere_queries import query_maps
from remosplat_drake.robot.sphere_model import Spheres
from remosplat_drake.scene.objects.convex_hull import ConvexHull
from remosplat_drake.scene.objects.scene_object import SceneObject
from remosplat_drake.scene.primitive_scene import Box, Cylinder, PrimitiveScene
from remosplat_drake.signals.compiled_map import Maps, register_query, together
from remosplat_drake.signals.distance_field import Clearances, DistanceField
from remosplat_drake.signals.thing import SOLID, Thing


class ObjectArrays(NamedTuple):
    """Arrays of k objects for kernels.

    Attributes:
        solids: The boxes and cylinders of the objects. Of a convex hull, only
            the pose is used.
        reach: Radii of balls that enclose the objects, with centres at the
            origins of their frames, shape (k,) [m].
        planes: The face planes of convex hulls in the objects' frames, as unit
            normals and offsets, shape (p, 4) [1, m].
        first: Index of each object's first plane, and the number of planes,
            shape (k + 1,). Boxes and cylinders have no planes.
        relief: Relief that is added to the distance of each robot sphere from
            each object, shape (n + 1, k) [m]. The last row is for other
            spheres; see `contact_rules.reliefs`.
    """

    solids: Primitives
    reach: np.ndarray
    planes: np.ndarray
    first: np.ndarray
    relief: np.ndarray


class ObjectField(DistanceField):
    """Distances to objects, which contact rules may let some links touch.

    Distances to boxes and cylinders are exact. The distance to a convex hull is
    the largest of the signed distances to the planes of its faces. It is exact
    inside the hull and in front of a face, and too small in front of edges and
    corners.

    Args:
        objects: The objects at their present poses.
        relief: The relief of each pair of a sphere and an object, as
            `contact_rules.reliefs` returns it; None if there are no contact
            rules.
    """

    def __init__(
        self, objects: Sequence[SceneObject], relief: np.ndarray | None = None
    ):
        self.objects = tuple(objects)
        if relief is None:
            relief = np.zeros((1, len(self.objects)))
        self.relief = np.array(relief, float)
        self._arrays = Packed(_arrays(self.objects, self.relief))
        self.revision = f"objects-{_digest(self._arrays.values)}"

    def __reduce__(self):
        return ObjectField, (self.objects, self.relief)

    @property
    def compiled(self) -> Packed[ObjectArrays]:
        """The objects' arrays; see `DistanceField.compiled`."""
        return self._arrays

    @cached_property
    def compiled_rows(self) -> Packed[Maps]:
        """The objects' arrays; see `DistanceField.compiled_rows`."""
        return together([self._arrays])

    def clearances(
        self, spheres: Spheres, max_distance: float = np.inf
    ) -> Clearances:
        """Measures the clearance of each sphere; see `DistanceField`.

        Returns:
            At most one row per sphere, with the least distance including
            reliefs.
        """
        maps = self.compiled_rows
        return query_maps(maps, spheres, max_distance, self.revision)

    def thing_at(self, p_W: np.ndarray) -> Thing:
        """Returns the object at a point; see `DistanceField.thing_at`."""
        if not self.objects:
            return Thing(SOLID, "an object")
        off = [
            abs(ObjectField([each]).clearances(Spheres.at(p_W)).minimum())
            for each in self.objects
        ]
        return Thing(SOLID, f"the {self.objects[int(np.argmin(off))].name}")


def with_objects(
    scene: DistanceField, objects: ObjectField
) -> CompositeDistanceField:
    """Returns the union of a scene's map and the objects in the scene.

    The union returns one row per sphere, like a map without objects.

    Args:
        scene: The map without the objects.
        objects: The objects.
    """
    return CompositeDistanceField([scene, objects], rows="closest")


@helper
def _hull_distance(p_WS, solids, j, planes):
    """Returns the signed distance to convex hull j, and its gradient in W."""
    px, py, pz = in_primitive(p_WS, solids, j)
    most, at = -np.inf, 0
    for k in range(len(planes)):
        n = planes[k]
        d = n[0] * px + n[1] * py + n[2] * pz + n[3]
        if d > most:
            most, at = d, k
    n = planes[at]
    return most, *in_world(solids, j, n[0], n[1], n[2])


@helper
def _is_beyond(p_WS, p_WP, within):
    x, y, z = p_WS[0] - p_WP[0], p_WS[1] - p_WP[1], p_WS[2] - p_WP[2]
    return x * x + y * y + z * z >= within * within


@kernel
def query(objects, spheres, answer):
    """Finds the object nearest to each sphere, including reliefs.

    Args:
        objects: The `ObjectArrays`.
        spheres: Queries, shape (n, 6). The columns are the centre p_WS, the
            distance from the centre below which objects are searched, the
            height below which objects are ignored [m], and the sphere's index.
        answer: Output, shape (n, 8). The columns are the object's index (-1
            without a result), its signed distance from the centre plus the
            relief, p_WC and n_W.
    """
    solids, first, relief = objects.solids, objects.first, objects.relief
    last = len(relief) - 1
    for i in range(len(answer)):
        answer[i, 0] = -1.0
        least, row = spheres[i, 3], int(spheres[i, 5])
        if not 0 <= row < last:
            row = last
        for j in range(len(solids.is_box)):
            if solids.top[j] <= spheres[i, 4]:
                continue
            # If the relief is infinite, the distance is infinite, too.
            within = least - relief[row, j] + objects.reach[j]
            if within <= 0.0 or _is_beyond(spheres[i], solids.p_WP[j], within):
                continue
            if first[j] == first[j + 1]:
                d, gx, gy, gz = primitive_distance(spheres[i], solids, j)
            else:
                planes = objects.planes[first[j] : first[j + 1]]
                d, gx, gy, gz = _hull_distance(spheres[i], solids, j, planes)
            reported = d + relief[row, j]
            if reported < least:
                least = reported
                point = spheres[i]
                write_answer(answer[i], j, reported, point, d, gx, gy, gz)


register_query(ObjectArrays, query)


def _arrays(objects: Sequence[SceneObject], relief: np.ndarray) -> ObjectArrays:
    rows = [primitive_arrays(_scene(each.solid)) for each in objects] or [
        primitive_arrays(PrimitiveScene())
    ]
    solids = Primitives(
        *(np.concatenate(column) for column in zip(*rows, strict=True))
    )
    planes = [_planes(each) for each in objects]
    count = [len(each) for each in planes]
    return ObjectArrays(
        solids._replace(top=np.array([each.top for each in objects], float)),
        np.array([each.reach for each in objects], float),
        np.concatenate([np.zeros((0, 4)), *planes]),
        np.cumsum([0, *count]).astype(np.int64),
        relief,
    )


def _scene(solid: Box | Cylinder | ConvexHull) -> PrimitiveScene:
    if isinstance(solid, Cylinder):
        return PrimitiveScene(cylinders=(solid,))
    if isinstance(solid, Box):
        return PrimitiveScene(boxes=(solid,))
    # Only the pose and the planes of a convex hull are used, not its size.
    return PrimitiveScene(boxes=(Box(solid.X_WP, np.ones(3)),))


def _planes(thing: SceneObject) -> np.ndarray:
    if not isinstance(thing.solid, ConvexHull):
        return np.zeros((0, 4))
    # A face that consists of several triangles has several equal equations.
    equations = scipy.spatial.ConvexHull(thing.solid.vertices).equations
    return np.unique(equations.round(12), axis=0)


def _digest(arrays: ObjectArrays) -> str:
    digest = hashlib.sha256()
    for array in (*arrays.solids, *arrays[1:]):
        digest.update(np.ascontiguousarray(array).tobytes())
    return digest.hexdigest()[:16]
