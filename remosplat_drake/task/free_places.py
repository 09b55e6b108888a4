"""Finds free places for an object on the level top of another object."""

import dataclasses as dc

import numpy as np
import scipy
from pydrake.math import RigidTransform

from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.robot.fitting.link_spheres import LinkSpheres
from remosplat_drake.robot.sphere_model import Spheres
from remosplat_drake.scene.objects.scene_object import SceneObject
from remosplat_drake.signals.distance_field import DistanceField
from remosplat_drake.task.carrying import hull_pieces

_STEP = 0.02
"""Distance of neighbouring places on a grid [m]."""

_LEVEL = 0.001
"""A top counts as level if its heights differ by at most this [m]."""

_LEAST_AREA = 1e-4
"""A level top must have at least this area [m^2]."""

MOST = 8
"""At most this many places are returned."""

APART = 0.05
"""Returned places are at least this far from each other [m]. If a robot cannot
reach a place, it can rarely reach another place that is nearer to it."""


@dc.dataclass(frozen=True, eq=False)
class Surroundings:
    """The parts of a scene from which an object must be free.

    Attributes:
        field: The map, without the object and without its support.
        stopping: Distance that the object's spheres keep from the map [m].
        p_WA: The arm's shoulder in W, shape (3,) [m]; None if the base moves.
        reach: Length of the arm [m].
    """

    field: DistanceField
    stopping: float
    p_WA: np.ndarray | None = None
    reach: float = np.inf


def free_places(
    thing: SceneObject,
    spheres: LinkSpheres,
    support: SceneObject,
    around: Surroundings,
    near: np.ndarray | None = None,
) -> list[RigidTransform]:
    """Finds free places of an object on the level top of another object.

    The object keeps its rotation.

    Args:
        thing: The object.
        spheres: Spheres around it, in its frame.
        support: The object on whose level top `thing` shall stand.
        around: The scene without both objects.
        near: Point in W near which `thing` shall stand, shape (3,) [m]; None
            for the middle of the top.

    Returns:
        At most `MOST` poses X_WO, the nearest first. They are at least `APART`
        from each other.

    Raises:
        RemoSplatError: The top is tilted or too small, there is no free place,
            or all free places are out of the arm's reach.
    """
    top, height = level_top(support)
    R_WO = thing.X_WO.rotation().matrix()
    vertices_W = np.concatenate(hull_pieces(thing.solid)) @ R_WO.T
    places = _inside(top, vertices_W[:, :2])
    if not len(places):
        raise RemoSplatError(
            f"the top of the {support.name} is too small for the {thing.name}"
        )
    middle = top.mean(axis=0) if near is None else np.asarray(near)[:2]
    order = np.argsort(np.linalg.norm(places - middle, axis=1), kind="stable")
    z = height - vertices_W[:, 2].min()
    p_WO = np.column_stack([places[order], np.full(len(order), z)])
    p_WO = p_WO[_is_free(p_WO, R_WO, spheres, around)]
    if not len(p_WO):
        raise RemoSplatError(
            f"the {support.name} has no free place for the {thing.name}; "
            "clear a place on it"
        )
    if around.p_WA is not None:
        far = np.linalg.norm(p_WO - around.p_WA, axis=1)
        if far.min() > around.reach:
            raise RemoSplatError(
                f"the {support.name} is too far: its nearest free place is"
                f" {far.min():.2f} m from the shoulder, and the arm reaches"
                f" {around.reach:.2f} m"
            )
        p_WO = p_WO[far <= around.reach]
    rotation = thing.X_WO.rotation()
    return [RigidTransform(rotation, p) for p in _spread(p_WO)]


def _spread(p_WO: np.ndarray) -> np.ndarray:
    """Returns the first places that are at least `APART` from each other."""
    chosen: list[np.ndarray] = []
    for p in p_WO:
        if all(np.linalg.norm(p - other) >= APART for other in chosen):
            chosen.append(p)
        if len(chosen) == MOST:
            break
    return np.array(chosen)


def level_top(support: SceneObject) -> tuple[np.ndarray, float]:
    """Returns the level top of an object.

    Args:
        support: The object.

    Returns:
        The corners of the top in W, shape (k, 2) [m], and its height [m].

    Raises:
        RemoSplatError: The highest points of the object do not span a level
            area.
    """
    points = np.concatenate(hull_pieces(support.solid))
    points_W = support.X_WO.multiply(points.T).T
    height = float(points_W[:, 2].max())
    top = points_W[points_W[:, 2] > height - _LEVEL, :2]
    area = 0.0
    if len(top) > 2 and np.linalg.matrix_rank(top - top[0], tol=1e-6) == 2:
        area = scipy.spatial.ConvexHull(top).volume
    if area < _LEAST_AREA:
        raise RemoSplatError(
            f"the top of the {support.name} is tilted, so no object can stand"
            " on it"
        )
    return top, height


def _inside(top: np.ndarray, footprint: np.ndarray) -> np.ndarray:
    """Points of a grid about which a footprint is on the top, shape (k, 2)."""
    lower, upper = top.min(axis=0), top.max(axis=0)
    middle = (lower + upper) / 2
    axes = []
    for m, half in zip(middle, (upper - lower) / 2, strict=True):
        n = int(half / _STEP)
        axes.append(m + _STEP * np.arange(-n, n + 1))
    grid = np.stack(np.meshgrid(*axes), axis=-1).reshape(-1, 2)
    sides = scipy.spatial.ConvexHull(top).equations
    beyond = (footprint @ sides[:, :2].T).max(axis=0)
    return grid[(grid @ sides[:, :2].T + sides[:, 2] + beyond <= 1e-9).all(1)]


def _is_free(
    p_WO: np.ndarray,
    R_WO: np.ndarray,
    spheres: LinkSpheres,
    around: Surroundings,
) -> np.ndarray:
    """Whether the spheres keep their distance at each place, shape (k,)."""
    n = len(spheres.radius)
    p_WS = p_WO[:, None] + spheres.p_LS @ R_WO.T
    radius = np.tile(spheres.radius, len(p_WO))
    found = around.field.clearances(
        Spheres.at(p_WS.reshape(-1, 3), radius), around.stopping + 0.01
    )
    room = found.per_sphere(n * len(p_WO)).reshape(-1, n).min(axis=1)
    return room > around.stopping
