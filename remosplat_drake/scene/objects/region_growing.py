"""`find_region`: finds the connected Gaussians of an object that stands."""

import dataclasses as dc
import math
from collections.abc import Iterator

import numpy as np
import scipy

from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.scene.objects.level_surface import find_level_surface

LEAST_SPLATS = 10
"""At least this many Gaussians of a map must represent an object."""

_REACH = 1.5
"""Two Gaussians are connected if their ellipsoids of this many standard
deviations touch along the line between their centres. In the shipped splats,
1 connects 99 % of a can's discs, and 3 connects cans that are 18 mm apart."""

_NEAR = 0.05
"""Largest distance between the given point and a Gaussian's centre [m]."""

_LEVEL = math.cos(math.radians(25.0))
"""A Gaussian may belong to a level surface only if the vertical component of
its normal is at least this."""

_FOOT = 0.008
"""A region begins this far above its support, since lower Gaussians may belong
to the support [m]."""

_LAYER = 0.016
"""Level surfaces are searched in layers of this height [m]."""

_SECTORS = 8
"""In each layer, the search begins at the nearest Gaussian in each of these
horizontal directions."""

_PATCH = 0.1
"""A support is searched up to this distance from these Gaussians [m]."""

_RING = 0.05
"""Gaussians of the support within this horizontal distance of a region bear the
region [m]."""

_GAP = 0.03
"""The lowest Gaussian of a region is at most this far above its support [m]."""


@dc.dataclass(frozen=True, eq=False)
class Region:
    """Connected Gaussians that stand on a level surface.

    Attributes:
        index: Indices of the k Gaussians, increasing, shape (k,).
        bottom: Height of the level surface in W [m].
    """

    index: np.ndarray
    bottom: float


def find_region(
    points: np.ndarray,
    normals: np.ndarray,
    axes: np.ndarray,
    near: np.ndarray,
    largest: float,
    ground: np.ndarray | None = None,
) -> Region:
    """Finds the Gaussians of the object that stands around a point.

    The function tries the level surfaces below the point as supports, the
    highest first. For each support, it adds to the Gaussian at the point all
    Gaussians above the support that are connected with it, directly or by other
    Gaussians. The first support that bears the region determines the result: a
    support bears a region that reaches down to it, if the middle of the region
    is within the convex hull of the support's Gaussians around the region.

    Args:
        points: Centres of the Gaussians in W, shape (n, 3) [m].
        normals: Their normals, of either sign, shape (n, 3).
        axes: Their axes, as columns with the standard deviations as lengths,
            shape (n, 3, 3) [m].
        near: A point on the object, shape (3,) [m].
        largest: Largest extent of the object along each axis of W [m].
        ground: Further points of level surfaces, which may bear the object but
            are no Gaussians, shape (m, 3) [m].

    Raises:
        RemoSplatError: No Gaussian is near the point, the region exceeds
            `largest`, has too few Gaussians, or stands on no level surface.
    """
    box = np.abs(points - near) <= largest + _PATCH
    close = np.flatnonzero(box.all(axis=1))
    points, normals, axes = points[close], normals[close], axes[close]
    away = np.linalg.norm(points - near, axis=1)
    if not away.size or away.min() > _NEAR:
        raise RemoSplatError(
            f"the map has no Gaussian within {_NEAR:g} m of this point"
        )
    start, count = int(away.argmin()), len(points)
    if ground is not None:
        up = np.broadcast_to([0.0, 0.0, 1.0], ground.shape)
        points = np.concatenate([points, ground])
        normals = np.concatenate([normals, up])
    problem = RemoSplatError(
        f"the map has no level surface within {largest:g} m below this point,"
        " on which an object could stand"
    )
    for height in _supports(points, normals, start, largest):
        above = points[:count, 2] > height + _FOOT
        try:
            own = _connected(points[:count], axes, start, above, largest)
            bottom = _bearing_height(points, normals, own, height)
        except RemoSplatError as error:
            problem = error
        else:
            return Region(close[own], bottom)
    raise problem


def _supports(
    points: np.ndarray, normals: np.ndarray, start: int, largest: float
) -> Iterator[float]:
    """Yields heights of level surfaces below a point, the highest first [m]."""
    drop = points[start, 2] - points[:, 2]
    level = (np.abs(normals[:, 2]) > _LEVEL) & (drop > _FOOT)
    left = np.flatnonzero(level & (drop < largest))
    while left.size:
        top = points[left, 2].max()
        in_layer = points[left, 2] > top - _LAYER
        layer, left = left[in_layer], left[~in_layer]
        off = (points[layer] - points[start])[:, :2]
        turn = (np.arctan2(off[:, 1], off[:, 0]) / math.tau) % 1.0
        sector = (_SECTORS * turn).astype(int)
        nearest_first = np.argsort(np.linalg.norm(off, axis=1))
        _, first = np.unique(sector[nearest_first], return_index=True)
        for near in points[layer[nearest_first[first]]]:
            try:
                found = find_level_surface(points, normals, near, _PATCH)
            except RemoSplatError:
                continue
            yield found.top
            break


def _connected(
    points: np.ndarray,
    axes: np.ndarray,
    start: int,
    allowed: np.ndarray,
    largest: float,
) -> np.ndarray:
    """Returns the allowed Gaussians that are connected with one of them."""
    own = np.zeros(len(points), bool)
    if not allowed[start]:
        raise RemoSplatError(
            "the point is on a level surface, not on an object"
        )
    rows = np.flatnonzero(allowed)
    tree = scipy.spatial.cKDTree(points[rows])
    sigma = np.linalg.norm(axes, axis=1).max(axis=1)
    widest = sigma[rows].max()
    own[start] = True
    front = np.array([start])
    while front.size:
        # Along any line, an ellipsoid extends no farther than its longest axis.
        within = _REACH * (sigma[front] + widest)
        near = tree.query_ball_point(points[front], within)
        i = np.repeat(front, [len(each) for each in near])
        j = rows[np.concatenate([np.array(each, int) for each in near])]
        i, j = i[~own[j]], j[~own[j]]
        off = points[j] - points[i]
        apart = np.linalg.norm(off, axis=1)
        along = off / np.maximum(apart, 1e-12)[:, None]
        reach = _REACH * (_extent(axes[i], along) + _extent(axes[j], along))
        front = np.unique(j[apart <= reach])
        own[front] = True
        if np.ptp(points[own], axis=0).max() > largest:
            raise RemoSplatError(
                f"all that the map connects with this point is larger than"
                f" {largest:g} m"
            )
    if np.count_nonzero(own) < LEAST_SPLATS:
        raise RemoSplatError(
            f"the map connects fewer than {LEAST_SPLATS} Gaussians with this"
            " point"
        )
    return np.flatnonzero(own)


def _extent(axes: np.ndarray, along: np.ndarray) -> np.ndarray:
    """Standard deviations of Gaussians along unit vectors, shape (m,) [m]."""
    return np.linalg.norm(np.einsum("mij,mi->mj", axes, along), axis=1)


def _bearing_height(
    points: np.ndarray, normals: np.ndarray, own: np.ndarray, height: float
) -> float:
    """Returns the height of a support at a region that it bears [m]."""
    gap = points[own, 2].min() - height
    if gap > _GAP:
        raise RemoSplatError(
            f"the object ends {1e3 * gap:.0f} mm above the level surface below"
            " it, so it stands on nothing"
        )
    on_it = np.abs(points[:, 2] - height) < _FOOT
    on_it &= np.abs(normals[:, 2]) > _LEVEL
    ground = points[on_it]
    tree = scipy.spatial.cKDTree(points[own, :2])
    ring = ground[tree.query(ground[:, :2])[0] <= _RING]
    middle = 0.5 * (points[own].min(axis=0) + points[own].max(axis=0))
    if not _is_within(middle[:2], ring[:, :2]):
        raise RemoSplatError(
            "the middle of the object is not above the level surface beside it,"
            " so it does not stand there"
        )
    return float(np.median(ring[:, 2]))


def _is_within(point: np.ndarray, others: np.ndarray) -> bool:
    """Whether a point is in the convex hull of others, shape (k, 2)."""
    try:
        hull = scipy.spatial.ConvexHull(others)
    except (scipy.spatial.QhullError, ValueError):
        return False
    normals, offsets = hull.equations[:, :2], hull.equations[:, 2]
    return bool((normals @ point + offsets <= 0.0).all())
