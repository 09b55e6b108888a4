"""Finds the floor of a splat without its cameras.

`reconstruction.floor` uses the orientation of a capture's cameras. A splat
without cameras has no known upward direction and no known unit of length, so
the lengths in this module are relative to the size of the splat.
"""

import dataclasses as dc
from collections.abc import Iterable, Iterator

import numpy as np
from pydrake.math import RigidTransform, RotationMatrix
from scipy.spatial import KDTree

from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.reconstruction.floor import floor_frame
from remosplat_drake.splat.gaussian_splat import GaussianSplat

_SAMPLES = 20_000
"""Number of random points on the splats' surfaces. The number of points on a
plane measures its area.
"""

_FEW = 2_000
"""Number of points with which hypotheses are first ranked."""

_HYPOTHESES, _DISTINCT = 500, 10
"""Number of hypotheses (planes through three points), and number of distinct
planes among the best of them, which are fitted to all points.
"""

_NEIGHBOURS = 200
"""The second and third point of a plane are drawn from this number of
neighbours of the first point."""

_INNER, _MARGIN = 0.9, 1.2
"""The scene's radius around its middle contains this fraction of the splats
(first number). Splats are ignored as background if they are farther from the
middle than this many radii (second number).
"""

_THICKNESS = 0.01
"""A point belongs to a plane if it is at most this far from it, in radii of the
scene."""

_DEPTH = 0.04
"""Distance beneath a plane, in radii of the scene, up to which splats may be
noise or reflections.
"""

_BENEATH = 4.0
"""Weight of points beneath a plane relative to points on it."""

_SAME, _NEAR = np.deg2rad(15.0), 0.08
"""Two planes count as the same plane if the angle between them is at most the
first number [rad], and their distance is at most the second number, in radii of
the scene.
"""

_RIVAL = 0.5
"""The floor is ambiguous if the score of another plane exceeds this fraction of
the floor's score.
"""

_STEEP = np.deg2rad(45.0)
"""Largest angle between a floor's normal and the given upward direction [rad].
"""

_COLLINEAR = np.deg2rad(1.0)
"""Three points are on one line if the angle at one of them, between the
directions to the two other points, is less than this [rad].
"""

_FEWEST = 100
"""The search for the floor needs at least this many splats."""

MIN_SHARE, MIN_SHARE_UPWARD = 0.15, 0.05
"""At least this fraction of the splats' surface belongs to a floor: the first
number holds if the upward direction is unknown, the second if it is known.
Smaller planes may be flat sides of objects.
"""

MAX_BENEATH = 0.05
"""At most this fraction of the splats' surface may lie beneath a floor."""


@dc.dataclass(frozen=True, eq=False)
class SplatFloor:
    """The floor F of a splat, whose frame is G.

    Attributes:
        X_FG: Pose of G in the frame F with z up and the floor at z = 0, see
            `floor_frame`.
        share: Fraction of the splats' surface that belongs to the floor.
        beneath: Fraction of the splats' surface that is beneath the floor.
    """

    X_FG: RigidTransform
    share: float
    beneath: float


@dc.dataclass(frozen=True, eq=False)
class _Plane:
    """A plane n p + offset = 0 with most of the scene above it."""

    normal: np.ndarray
    offset: float
    share: float
    beneath: float

    @property
    def score(self) -> float:
        return self.share - _BENEATH * self.beneath

    def is_same(self, other: "_Plane") -> bool:
        """Returns whether two planes are nearly the same."""
        is_parallel = self.normal @ other.normal > np.cos(_SAME)
        return bool(is_parallel) and abs(self.offset - other.offset) < _NEAR


def find_splat_floor(
    splat: GaussianSplat, up_G: np.ndarray | None = None, seed: int = 0
) -> SplatFloor:
    """Finds the floor by RANSAC: a large plane with few splats beneath it.

    Points are drawn on the splats' surfaces, by area and opacity. A hypothesis
    is the plane through three neighbouring points, fitted by least squares to
    all points near it. Its upper side is the side with most of the points.
    There may also be no splats behind a wall or a ceiling. So if the score of
    another plane is similar, an error is raised.

    Args:
        splat: Splats in G, in any unit.
        up_G: Upward direction in G, shape (3,), of any length, with an error of
            at most 45 degrees; None if unknown.
        seed: Seed of the random choice of points.

    Raises:
        RemoSplatError: No plane meets the thresholds; the error states which
            threshold the best plane does not meet.
    """
    rng = np.random.default_rng(seed)
    p_G, radius = _surface_points(splat, rng)
    if up_G is not None:
        up_G = np.asarray(up_G) / np.linalg.norm(up_G)
    middle = p_G.mean(axis=0)
    p_M = (p_G - middle) / radius
    few = p_M[rng.choice(len(p_M), _FEW, replace=False)]
    tried = [
        _fitted(few, normal, offset, up_G)
        for normal, offset in _hypotheses(few, rng)
    ]
    if up_G is not None:
        cosine = np.cos(_STEEP)
        tried = [plane for plane in tried if plane.normal @ up_G > cosine]
    planes = _distinct(
        _fitted(p_M, plane.normal, plane.offset, up_G)
        for plane in _distinct(tried)[:_DISTINCT]
    )
    if not planes:
        raise RemoSplatError("no floor: no plane is level enough")
    best = planes[0]
    _check(planes, MIN_SHARE if up_G is None else MIN_SHARE_UPWARD)
    offset = radius * best.offset - float(best.normal @ middle)
    return SplatFloor(
        floor_frame(best.normal, offset), best.share, best.beneath
    )


def frame_of_points(
    p_GO: np.ndarray, p_GX: np.ndarray, p_GY: np.ndarray
) -> RigidTransform:
    """Makes the pose X_FG of G in a frame F, from three points on a floor.

    Args:
        p_GO: Origin of F, shape (3,).
        p_GX: A point on F's x axis, shape (3,).
        p_GY: A point on the floor with a positive y coordinate in F, shape
            (3,).

    Raises:
        RemoSplatError: The points lie on one line.
    """
    x_G, y_G = p_GX - p_GO, p_GY - p_GO
    lengths = np.linalg.norm(x_G) * np.linalg.norm(y_G)
    if not lengths or (p_GX == p_GY).all():
        raise RemoSplatError("two of the three points are the same")
    up_G = np.cross(x_G, y_G)
    if np.linalg.norm(up_G) < np.sin(_COLLINEAR) * lengths:
        raise RemoSplatError("the three points lie on one line")
    x_G, z_G = x_G / np.linalg.norm(x_G), up_G / np.linalg.norm(up_G)
    R_FG = RotationMatrix(np.stack([x_G, np.cross(z_G, x_G), z_G]))
    return RigidTransform(R_FG, -(R_FG @ p_GO))


def _surface_points(
    splat: GaussianSplat, rng: np.random.Generator
) -> tuple[np.ndarray, float]:
    """Points on splats without background, (n, 3), and the scene's radius."""
    if len(splat) < _FEWEST:
        raise RemoSplatError(f"no floor: there are only {len(splat)} splats")
    p_GK = splat.p_GK.astype(float)
    distance = np.linalg.norm(p_GK - np.median(p_GK, axis=0), axis=1)
    radius = float(np.quantile(distance, _INNER))
    if not radius:
        raise RemoSplatError("no floor: all splats are at the same point")
    inner = np.flatnonzero(distance <= _MARGIN * radius)
    # Splats above this size are not flat surfaces, and count with this size.
    most = 5 * _THICKNESS * radius
    largest = np.sort(splat.scales[inner], axis=1)[:, :-3:-1].astype(float)
    weight = np.minimum(largest, most).prod(axis=1) * splat.opacities[inner]
    kept = inner[rng.choice(len(inner), _SAMPLES, p=weight / weight.sum())]
    # Only the rotations of the drawn splats are computed, since those of all
    # splats may need much memory.
    few = splat.select(kept)
    axes = np.argsort(-few.scales, axis=1)[:, :2]
    scales = np.take_along_axis(few.scales, axes, axis=1).astype(float)
    offsets = np.minimum(scales, most) * rng.normal(size=(_SAMPLES, 2))
    p_K = np.zeros((_SAMPLES, 3))
    np.put_along_axis(p_K, axes, offsets, axis=1)
    return p_GK[kept] + np.einsum("nij,nj->ni", few.R_GK, p_K), radius


def _hypotheses(
    p_M: np.ndarray, rng: np.random.Generator
) -> Iterator[tuple[np.ndarray, float]]:
    """Planes n p + offset = 0 through three points each."""
    first = rng.choice(len(p_M), _HYPOTHESES)
    near = KDTree(p_M).query(p_M[first], _NEIGHBOURS)[1]
    others = rng.integers(1, _NEIGHBOURS, (_HYPOTHESES, 2))
    second, third = np.take_along_axis(near, others, axis=1).T
    normals = np.cross(p_M[second] - p_M[first], p_M[third] - p_M[first])
    lengths = np.linalg.norm(normals, axis=1)
    for i in np.flatnonzero(lengths):
        normal = normals[i] / lengths[i]
        yield normal, -float(normal @ p_M[first[i]])


def _distinct(planes: Iterable[_Plane]) -> list[_Plane]:
    """The planes that differ from all better planes, the best first."""
    kept: list[_Plane] = []
    for plane in sorted(planes, key=lambda plane: -plane.score):
        if not any(plane.is_same(other) for other in kept):
            kept.append(plane)
    return kept


def _fitted(
    p_M: np.ndarray, normal: np.ndarray, offset: float, up: np.ndarray | None
) -> _Plane:
    """The least-squares plane of the points near a plane, by two iterations."""
    for thickness in (3 * _THICKNESS, 2 * _THICKNESS, *[_THICKNESS] * 3):
        own = p_M[np.abs(p_M @ normal + offset) < thickness]
        if len(own) < 3:
            break
        mean = own.mean(axis=0)
        fitted = np.linalg.eigh(np.cov((own - mean).T))[1][:, 0]
        normal = fitted * np.sign(fitted @ normal)
        offset = -float(normal @ mean)
    return _judged(p_M, normal, offset, up)


def _judged(
    p_M: np.ndarray, normal: np.ndarray, offset: float, up: np.ndarray | None
) -> _Plane:
    """Computes a plane's share and score, with the normal pointing up."""
    height = p_M @ normal + offset
    above, beneath = (height > _DEPTH).mean(), (height < -_DEPTH).mean()
    share = float((np.abs(height) < _THICKNESS).mean())
    flips = beneath > above if up is None else normal @ up < 0
    if flips:
        return _Plane(-normal, -offset, share, float(above))
    return _Plane(normal, offset, share, float(beneath))


def _check(planes: list[_Plane], min_share: float) -> None:
    """Raises an error if the first plane is not clearly the floor."""
    best = planes[0]
    if best.beneath > MAX_BENEATH:
        raise RemoSplatError(
            f"no clear floor: the best plane has {100 * best.beneath:.0f} % of"
            " the splat beneath it"
        )
    if best.share < min_share:
        raise RemoSplatError(
            "no clear floor: the largest plane with nothing beneath it has"
            f" {100 * best.share:.0f} % of the splat"
        )
    if len(planes) > 1 and planes[1].score > _RIVAL * best.score:
        cosine = np.clip(planes[1].normal @ best.normal, -1, 1)
        raise RemoSplatError(
            f"no clear floor: planes with {100 * best.share:.0f} % and"
            f" {100 * planes[1].share:.0f} % of the splat,"
            f" {np.degrees(np.arccos(cosine)):.0f} degrees apart, might both be"
            " the floor"
        )
