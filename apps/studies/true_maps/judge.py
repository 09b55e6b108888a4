"""Compares a map with the true meshes: over-estimates, and their places.

The map is first aligned rigidly with the truth, since a robot localises itself
in the map. Its scale must not differ.
"""

import dataclasses as dc

import numpy as np
from pydrake.math import RigidTransform
from scipy.spatial.transform import Rotation

from apps.studies.map_bound.judge import FARTHEST, NEAREST, Queries
from apps.studies.rigid_motion import rigid_fit, transformed
from apps.studies.true_maps.ray_casting import RayCaster
from apps.studies.true_maps.sight import Sight, Surface
from remosplat_drake.oracle.sphere_to_ellipsoid import SphereToEllipsoidField
from remosplat_drake.robot.sphere_model import Spheres
from remosplat_drake.signals.distance_field import DistanceField
from remosplat_drake.splat.gaussian_splat import GaussianSplat

QUERIES = 8_000
"""Random points are drawn in front of this many pixels."""

SURFACE = 60_000
"""Number of pixels among which the worst places are sought."""

_WORST, _WORST_OF_LABEL = 200, 30
"""Number of surface points with the largest gaps, of all and of each label."""

_AROUND = 12
"""Number of query points around each of the points with the largest gaps."""

_ICP_STEPS = 8

_ICP_GATE = 3.0
"""A disc is used if its error is at most this multiple of the median error."""

_ICP_LEAST = 0.002
"""Discs nearer to the truth than this are always used [m]."""


@dc.dataclass(frozen=True, eq=False)
class MeshQueries(Queries):
    """Points of free space near surfaces.

    Attributes:
        wide: Whether two views saw the nearest surface at least a pixel wide,
            shape (n,).
        label: Label of the nearest surface, shape (n,).
    """

    wide: np.ndarray
    label: np.ndarray


@dc.dataclass(frozen=True)
class Excess:
    """Over-estimates of distances to one kind of object.

    Attributes:
        count: Number of points.
        exceeded: Number of these at which the distance, after subtraction of
            the discs' uncertainty, exceeds the true one.
        worst: Largest excess of such a distance [m]; negative if none has any.
        over: Largest excess of a distance without subtraction [m].
    """

    count: int
    exceeded: int
    worst: float
    over: float


@dc.dataclass(frozen=True, eq=False)
class Judgement:
    """Errors of a map, relative to the truth.

    Attributes:
        all: Errors at points whose nearest surface two views saw at least a
            pixel wide.
        thin: Errors at points whose nearest surface two views saw, but less
            than a pixel wide.
        by_label: Those of `all`, by the label of the nearest surface.
    """

    all: Excess
    thin: Excess
    by_label: dict[str, Excess]


def judge(
    splat_W: GaussianSplat, sight: Sight, rng: np.random.Generator
) -> Judgement:
    """Compares a map's distances with the true ones.

    Args:
        splat_W: The map, aligned with the truth, with its discs' uncertainty.
        sight: True data of the cameras.
        rng: Source of randomness.
    """
    raw = SphereToEllipsoidField(splat_W.with_uncertainty(None))
    careful = SphereToEllipsoidField(splat_W)
    queries = random_queries(sight, QUERIES, rng)
    for field in (raw, careful):
        queries = queries.joined(worst_queries(field, sight, rng))
    return judged(queries.well_seen(), raw, careful)


def judged(
    queries: MeshQueries, raw: DistanceField, careful: DistanceField
) -> Judgement:
    """Summarises over-estimates of two fields' distances.

    Args:
        queries: Points whose nearest surface was seen.
        raw: Distances without subtraction.
        careful: Distances minus their uncertainty.
    """
    over, excess = queries.over_estimates(raw), queries.over_estimates(careful)

    def of(rows: np.ndarray) -> Excess:
        return Excess(
            count=int(rows.sum()),
            exceeded=int((excess[rows] > 0).sum()),
            worst=float(excess[rows].max(initial=-np.inf)),
            over=float(over[rows].max(initial=-np.inf)),
        )

    labels = np.unique(queries.label[queries.wide]).tolist()
    return Judgement(
        of(queries.wide),
        of(~queries.wide),
        {name: of(queries.wide & (queries.label == name)) for name in labels},
    )


def random_queries(
    sight: Sight, count: int, rng: np.random.Generator
) -> MeshQueries:
    """Draws points on rays in front of the surfaces that pixels show.

    Args:
        sight: True data of the cameras.
        count: Number of pixels, of which a part yields points.
        rng: Source of randomness.
    """
    surface = sight.surface(count, rng)
    back_W = surface.p_WC - surface.p_W
    length = np.linalg.norm(back_W, axis=1)
    part = rng.uniform(NEAREST, np.minimum(length, 2 * FARTHEST)) / length
    return _near_surfaces(surface.p_W + part[:, None] * back_W, sight)


def worst_queries(
    field: DistanceField, sight: Sight, rng: np.random.Generator
) -> MeshQueries:
    """Searches for the places with the largest errors of a map.

    The map's distances are 1-Lipschitz. So none is too large by more than the
    map's distance at the truly nearest surface point. The worst places are
    therefore the measured surface points with the largest distances, and points
    in front of them are queried.

    Args:
        field: The map.
        sight: True data of the cameras.
        rng: Source of randomness.
    """
    surface = sight.surface(SURFACE, rng)
    chosen = _worst_places(field, surface, sight.labels(surface.part))
    p_W, p_WC = surface.p_W[chosen], surface.p_WC[chosen]
    back_W = p_WC - p_W
    back_W /= np.linalg.norm(back_W, axis=1, keepdims=True)
    aside = rng.standard_normal((_AROUND, *p_W.shape))
    away = back_W + 0.7 * aside / np.sqrt(3)
    away /= np.linalg.norm(away, axis=-1, keepdims=True)
    reach = NEAREST * rng.uniform(1, 2, (*away.shape[:2], 1))
    around = (p_W + reach * away).reshape(-1, 3)
    free = sight.is_free_way(np.tile(p_WC, (_AROUND, 1)), around)
    return _near_surfaces(around[free], sight)


def _worst_places(
    field: DistanceField, surface: Surface, labels: np.ndarray
) -> np.ndarray:
    """Indices of the surface points with the largest distances from a map."""
    count = len(surface.p_W)
    spheres = Spheres.at(surface.p_W)
    order = np.argsort(-field.clearances(spheres).per_sphere(count))
    chosen = [order[:_WORST]]
    for label in np.unique(labels):
        chosen.append(order[labels[order] == label][:_WORST_OF_LABEL])
    return np.unique(np.concatenate(chosen))


def _near_surfaces(p_W: np.ndarray, sight: Sight) -> MeshQueries:
    """Points of the workspace whose true distance is in the judged range."""
    p_W = p_W[sight.in_workspace(p_W)]
    nearest = sight.taken.caster.nearest(p_W)
    near = (nearest.distance > NEAREST) & (nearest.distance < FARTHEST)
    nearest = nearest.selected(near)
    seen, wide = sight.seen(nearest)
    return MeshQueries(
        p_W[near], nearest.distance, seen, wide, sight.labels(nearest.part)
    )


def laid_on_truth(
    splat_M: GaussianSplat,
    X_MC: np.ndarray,
    true_X_WC: np.ndarray,
    sight: Sight,
) -> GaussianSplat:
    """Aligns a map rigidly with the truth.

    Args:
        splat_M: The map in its own frame M.
        X_MC: The camera poses of the map, shape (n, 4, 4).
        true_X_WC: The true poses, shape (n, 4, 4).
        sight: The truth.
    """
    X_WM = rigid_fit(_corners(X_MC), _corners(true_X_WC))
    p_WK = transformed(X_WM, splat_M.p_GK.astype(float))
    p_WK = p_WK[sight.in_workspace(p_WK)]
    X_WM = registration(p_WK, sight.taken.caster) @ X_WM
    return splat_M.transformed(RigidTransform(X_WM))


def registration(p_AK: np.ndarray, caster: RayCaster) -> np.ndarray:
    """Finds the rigid motion that aligns points with surfaces, point to plane.

    Args:
        p_AK: Points near the surfaces, shape (n, 3) [m].
        caster: The surfaces, in W.

    Returns:
        The pose X_WA, shape (4, 4).
    """
    X_WA = np.eye(4)
    for _ in range(_ICP_STEPS):
        p_WK = transformed(X_WA, p_AK)
        nearest = caster.nearest(p_WK)
        gate = max(_ICP_GATE * np.median(nearest.distance), _ICP_LEAST)
        keep = nearest.distance < gate
        p_WK, nearest = p_WK[keep], nearest.selected(keep)
        middle = p_WK.mean(axis=0)
        rest = ((p_WK - nearest.p_W) * nearest.normal_W).sum(axis=1)
        turn = np.cross(p_WK - middle, nearest.normal_W)
        J = np.concatenate([turn, nearest.normal_W], axis=1)
        step = np.linalg.lstsq(J, -rest, rcond=1e-6)[0]
        X_WA = _moved(step, middle) @ X_WA
    return X_WA


def _moved(step: np.ndarray, middle: np.ndarray) -> np.ndarray:
    """A rotation about a point, then a translation, as a matrix (4, 4)."""
    X = np.eye(4)
    X[:3, :3] = Rotation.from_rotvec(step[:3]).as_matrix()
    X[:3, 3] = middle - X[:3, :3] @ middle + step[3:]
    return X


def _corners(X_WC: np.ndarray) -> np.ndarray:
    """Each camera's centre, and the points 1 m along its axes, (4n, 3)."""
    corners_C = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1.0]])
    corners_W = corners_C @ X_WC[:, :3, :3].transpose(0, 2, 1)
    return (corners_W + X_WC[:, None, :3, 3]).reshape(-1, 3)
