"""`SignedDistanceField`: exact distances to boxes and cylinders.

This field is the paper's ground-truth baseline (RMMI), and the reference of all
other fields. Distances are signed, and negative inside a solid. At points where
the gradient is not unique (the centre of a box, the axis of a cylinder), a
fixed gradient is chosen. So equal queries have equal results.
"""

from functools import cached_property
from typing import NamedTuple

import numpy as np

from remosplat_drake.base.box_distance import (
    distance_to_box,
    distance_to_cylinder,
)
from remosplat_drake.base.errors import RemoSplatError, unknown_name
from remosplat_drake.base.kernels import helper, kernel
from remosplat_drake.base.kernels.packed import Packed
from remosplat_drake.base.lanes import (
    WIDTH,
    in_all,
    lanes_from,
    where,
    write_lanes,
)
from remosplat_drake.robot.sphere_model import Spheres
from remosplat_drake.scene.kernels.solid_distance import (
    box_distance,
    cylinder_distance,
)
from remosplat_drake.scene.primitive_scene import Box, PrimitiveScene
from remosplat_drake.signals.compiled_map import Maps, register_query, together
from remosplat_drake.signals.distance_field import Clearances, DistanceField
from remosplat_drake.signals.thing import SOLID, Thing

ROWS = ("closest", "per_primitive")
"""The rows that the field returns: one per sphere, or one per sphere and
primitive."""


class SignedDistanceField(DistanceField):
    """The exact signed distance to a `PrimitiveScene` (ground truth).

    A sphere ignores primitives that are completely below its `ignore_below`.

    Args:
        scene: The solids.
        rows: "closest" returns one row per sphere, "per_primitive" one row per
            sphere and primitive.

    Raises:
        RemoSplatError: `rows` is not one of `ROWS`.
    """

    def __init__(self, scene: PrimitiveScene, rows: str = "closest"):
        if rows not in ROWS:
            raise RemoSplatError(unknown_name("rows", rows, ROWS))
        self.scene = scene
        self.rows = rows
        self.revision = f"signed-distance-{scene.content_hash}-{rows}"
        self._primitives = Packed(primitive_arrays(scene))

    @property
    def compiled(self) -> "Packed[Primitives]":
        """The arrays of the primitives; see `DistanceField.compiled`."""
        return self._primitives

    @cached_property
    def compiled_rows(self) -> Packed[Maps] | None:
        """The arrays of the primitives; see `DistanceField.compiled_rows`."""
        if self.rows != "closest":
            return None
        return together([self._primitives])

    def clearances(
        self, spheres: Spheres, max_distance: float = np.inf
    ) -> Clearances:
        """Measures the clearances of all spheres; see `DistanceField`."""
        sphere, distance, direction_W, p_WC = _clearances(
            np.ascontiguousarray(spheres.p_WS, np.float64),
            np.ascontiguousarray(spheres.radius, np.float64),
            np.ascontiguousarray(spheres.ignore_below, np.float64),
            self._primitives,
            max_distance,
            self.rows == "closest",
        )
        return Clearances(sphere, distance, direction_W, p_WC, self.revision)

    def thing_at(self, p_W: np.ndarray) -> Thing:
        """Returns the solid at a point; see `DistanceField.thing_at`."""
        if not len(self.scene):
            return Thing(SOLID, "the scene")
        all_solids = SignedDistanceField(self.scene, "per_primitive")
        off = np.abs(all_solids.clearances(Spheres.at(p_W)).distance)
        return Thing(SOLID, self.scene.name_of(int(off.argmin())))


class Primitives(NamedTuple):
    """Arrays of k boxes and cylinders for kernels.

    Attributes:
        is_box: Whether each primitive is a box, shape (k,).
        size: Half edges of a box; radius, radius and half height of a cylinder,
            shape (k, 3) [m].
        R_WP: Orientations, shape (k, 3, 3).
        p_WP: Centres in W, shape (k, 3) [m].
        top: Heights of the primitives' highest points in W, shape (k,) [m].
    """

    is_box: np.ndarray
    size: np.ndarray
    R_WP: np.ndarray
    p_WP: np.ndarray
    top: np.ndarray


def primitive_arrays(scene: PrimitiveScene) -> Primitives:
    """Returns the solids of a scene as arrays for kernels.

    Args:
        scene: The solids.
    """
    primitives = scene.primitives
    size = [
        p.half_extents
        if isinstance(p, Box)
        else (p.radius, p.radius, p.half_height)
        for p in primitives
    ]
    k = len(primitives)
    return Primitives(
        np.array([isinstance(p, Box) for p in primitives], bool),
        np.array(size, float).reshape(k, 3),
        np.array(
            [p.X_WP.rotation().matrix() for p in primitives], order="C"
        ).reshape(k, 3, 3),
        np.array([p.X_WP.translation() for p in primitives]).reshape(k, 3),
        np.array([p.top for p in primitives], float),
    )


@helper
def primitive_distance(p_WS, primitives, j):
    """Computes the signed distance of a point from a primitive.

    Args:
        p_WS: The point in W; only its first three entries are used.
        primitives: The `Primitives`.
        j: Index of the primitive.

    Returns:
        The distance [m], and the three entries of its gradient in W.
    """
    px, py, pz = in_primitive(p_WS, primitives, j)
    if primitives.is_box[j]:
        d, gx, gy, gz = box_distance(px, py, pz, primitives.size[j])
    else:
        d, gx, gy, gz = cylinder_distance(px, py, pz, primitives.size[j])
    return d, *in_world(primitives, j, gx, gy, gz)


@helper
def in_primitive(p_WS, primitives, j):
    """Returns a point's coordinates in the frame P of primitive j [m].

    The coordinates are numbers, or SIMD lanes of several points.
    """
    R_WP, p_WP = primitives.R_WP[j], primitives.p_WP[j]
    x, y, z = p_WS[0] - p_WP[0], p_WS[1] - p_WP[1], p_WS[2] - p_WP[2]
    return (
        R_WP[0, 0] * x + R_WP[1, 0] * y + R_WP[2, 0] * z,
        R_WP[0, 1] * x + R_WP[1, 1] * y + R_WP[2, 1] * z,
        R_WP[0, 2] * x + R_WP[1, 2] * y + R_WP[2, 2] * z,
    )


@helper
def in_world(primitives, j, x, y, z):
    """Expresses a vector in W that is given in the frame P of primitive j."""
    R_WP = primitives.R_WP[j]
    return (
        R_WP[0, 0] * x + R_WP[0, 1] * y + R_WP[0, 2] * z,
        R_WP[1, 0] * x + R_WP[1, 1] * y + R_WP[1, 2] * z,
        R_WP[2, 0] * x + R_WP[2, 1] * y + R_WP[2, 2] * z,
    )


@helper
def write_answer(answer, number, distance, p_WS, d, gx, gy, gz):
    """Writes the result of a query in the form of `compiled_map.query_map`.

    Args:
        answer: Output, shape (8,).
        number: Index of the nearest primitive.
        distance: The signed distance to report [m].
        p_WS: The point in W; only its first three entries are used.
        d: The point's signed distance from the primitive [m].
        gx: The x component of the gradient of `d` in W.
        gy: The y component of this gradient.
        gz: The z component of this gradient.
    """
    answer[0], answer[1] = number, distance
    answer[2] = p_WS[0] - d * gx
    answer[3] = p_WS[1] - d * gy
    answer[4] = p_WS[2] - d * gz
    answer[5], answer[6], answer[7] = -gx, -gy, -gz


@kernel
def query(primitives, spheres, answer):
    """Finds the primitive that is nearest to each sphere's centre.

    Args:
        primitives: The `Primitives`.
        spheres: Queries, shape (n, 6). The columns are the centre p_WS, the
            distance from the centre below which primitives are searched, and
            the height below which primitives are ignored [m]. The last column
            is not used.
        answer: Output, shape (n, 8). The columns are the primitive's index (-1
            without a result), its signed distance from the centre, p_WC and
            n_W.
    """
    n, columns = len(answer), np.empty((5, WIDTH))
    for first in range(0, n, WIDTH):
        count = min(WIDTH, n - first)
        for k in range(WIDTH):
            row = first + min(k, count - 1)
            for c in range(5):
                columns[c, k] = spheres[row, c]
        write_lanes(columns, 3 * WIDTH, _nearest(primitives, columns))
        for k in range(count):
            i, j = first + k, int(columns[3, k])
            answer[i, 0] = j
            if j >= 0:
                d, gx, gy, gz = primitive_distance(spheres[i], primitives, j)
                write_answer(answer[i], j, d, spheres[i], d, gx, gy, gz)


@helper
def _nearest(primitives, columns):
    """Returns the indices of the nearest primitives as lanes; -1 for none.

    Args:
        primitives: The `Primitives`.
        columns: The first five columns of eight queries, shape (5, 8).
    """
    x, y = lanes_from(columns, 0), lanes_from(columns, WIDTH)
    z, least = lanes_from(columns, 2 * WIDTH), lanes_from(columns, 3 * WIDTH)
    ignored, nearest = lanes_from(columns, 4 * WIDTH), in_all(-1.0)
    for j in range(len(primitives.is_box)):
        px, py, pz = in_primitive((x, y, z), primitives, j)
        if primitives.is_box[j]:
            d = distance_to_box(px, py, pz, primitives.size[j])
        else:
            d = distance_to_cylinder(px, py, pz, primitives.size[j])
        is_nearer = (d < least) & (ignored < primitives.top[j])
        least = where(is_nearer, d, least)
        nearest = where(is_nearer, 1.0 * j, nearest)
    return nearest


register_query(Primitives, query)


@kernel
def _clearances(p_WS, radius, ignore_below, primitives, max_distance, closest):
    n, k = len(p_WS), len(primitives.is_box)
    capacity = n if closest else n * k
    sphere = np.empty(capacity, np.int64)
    distance = np.empty(capacity)
    direction_W = np.empty((capacity, 3))
    p_WC = np.empty((capacity, 3))
    rows = 0
    for i in range(n):
        first_of_sphere = rows
        for j in range(k):
            if primitives.top[j] <= ignore_below[i]:
                continue
            d, gx, gy, gz = primitive_distance(p_WS[i], primitives, j)
            row = rows
            if closest and rows > first_of_sphere:
                row = first_of_sphere
                if d - radius[i] >= distance[row]:
                    continue
            elif d - radius[i] >= max_distance:
                continue
            else:
                rows += 1
            sphere[row] = i
            distance[row] = d - radius[i]
            direction_W[row, 0] = -gx
            direction_W[row, 1] = -gy
            direction_W[row, 2] = -gz
            p_WC[row, 0] = p_WS[i, 0] - d * gx
            p_WC[row, 1] = p_WS[i, 1] - d * gy
            p_WC[row, 2] = p_WS[i, 2] - d * gz
    return sphere[:rows], distance[:rows], direction_W[:rows], p_WC[:rows]
