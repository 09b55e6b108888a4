"""Compares a map with the truth: over-estimates, and their places."""

import dataclasses as dc
from typing import Self

import numpy as np

from remosplat_drake.capture.capture import Capture
from remosplat_drake.capture.rendering.sensor_noise import SensorNoise
from remosplat_drake.oracle.signed_distance import SignedDistanceField
from remosplat_drake.robot.sphere_model import Spheres
from remosplat_drake.scene.primitive_scene import PrimitiveScene
from remosplat_drake.signals.distance_field import DistanceField

NEAREST, FARTHEST = 0.03, 0.5
"""Range of the true distances that are judged [m]. The centres of the robot's
spheres are not nearer to surfaces, and the controller ignores larger
distances."""

SEEN_BY = 2
"""A surface counts as seen if at least this many views see it well."""

_STEEPEST = 0.2
"""A view sees a surface well only if the cosine of the angle of incidence is at
least this."""

_NOISIEST = 0.01
"""A depth is measured well only if its standard deviation is at most this
[m]."""

_WORST = 300
"""Number of surface points with the largest gaps, around which queries are
made."""

_OWN = 0.005
"""A view sees a surface point if the depths agree within this tolerance [m]."""

NOTHING = 1.0
"""Distance that is used if a field has no surface in range [m]."""


@dc.dataclass(frozen=True, eq=False)
class Sight:
    """True data of the cameras, for evaluation only.

    Attributes:
        scene: The truth.
        perfect: The capture with its true poses and exact depths.
        depth: The depths that the sensor delivered, shape (n, h, w) [m]: a
            surface whose pixels have no depth was not seen.
        sensor: The noise of the sensor.
    """

    scene: PrimitiveScene
    perfect: Capture
    depth: np.ndarray
    sensor: SensorNoise

    @property
    def focus_W(self) -> np.ndarray:
        """Middle of the workspace: the scene's target, shape (3,) [m]."""
        assert self.scene.X_WE_target is not None
        return self.scene.X_WE_target.translation()


@dc.dataclass(frozen=True, eq=False)
class Queries:
    """Points of free space near surfaces.

    Attributes:
        p_W: The points, shape (n, 3) [m].
        distance: Their true distances, shape (n,) [m].
        seen: Whether the nearest surface was seen well, shape (n,).
    """

    p_W: np.ndarray
    distance: np.ndarray
    seen: np.ndarray

    def over_estimates(self, field: DistanceField) -> np.ndarray:
        """Returns measured minus true distances, shape (n,) [m]."""
        count = len(self.p_W)
        measured = field.clearances(Spheres.at(self.p_W)).per_sphere(count)
        return np.minimum(measured, NOTHING) - self.distance

    def well_seen(self) -> Self:
        """Returns the points whose nearest surface was seen well."""
        return self.selected(self.seen)

    def selected(self, keep: np.ndarray) -> Self:
        """Returns the points that a mask (n,) selects."""
        return type(self)(
            *(getattr(self, field.name)[keep] for field in dc.fields(self))
        )

    def joined(self, other: Self) -> Self:
        """Returns these points, then another's."""
        return type(self)(
            *(
                np.concatenate([getattr(self, f.name), getattr(other, f.name)])
                for f in dc.fields(self)
            )
        )


def random_queries(
    sight: Sight, count: int, rng: np.random.Generator
) -> Queries:
    """Draws points of the robot's workspace.

    Args:
        sight: True data of the cameras.
        count: Number of random points, of which a part can be used.
        rng: Source of randomness.
    """
    focus_W = sight.focus_W
    return _near_surfaces(
        rng.uniform(focus_W - 1, focus_W + 1, (count, 3)), sight
    )


def worst_queries(
    field: DistanceField, sight: Sight, rng: np.random.Generator
) -> Queries:
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
    perfect = sight.perfect
    points = [
        perfect.points_W(i)[sight.depth[i] > 0][::7]
        for i in range(len(perfect))
    ]
    p_W = np.concatenate(points)
    p_W = p_W[np.abs(p_W - sight.focus_W).max(axis=1) < 1]
    measured = field.clearances(Spheres.at(p_W)).per_sphere(len(p_W))
    worst = p_W[np.argsort(-measured)[:_WORST]]
    away = rng.standard_normal((40, *worst.shape))
    away /= np.linalg.norm(away, axis=-1, keepdims=True)
    reach = NEAREST * rng.uniform(1, 2, (*away.shape[:2], 1))
    return _near_surfaces((worst + away * reach).reshape(-1, 3), sight)


def _near_surfaces(p_W: np.ndarray, sight: Sight) -> Queries:
    """The points whose true distance is in the judged range."""
    truth = SignedDistanceField(sight.scene).clearances(Spheres.at(p_W))
    near = (truth.distance > NEAREST) & (truth.distance < FARTHEST)
    views = times_seen(truth.p_WC[near], truth.direction_W[near], sight)
    return Queries(
        p_W[truth.sphere[near]], truth.distance[near], views >= SEEN_BY
    )


def times_seen(
    p_W: np.ndarray, inward_W: np.ndarray, sight: Sight
) -> np.ndarray:
    """Counts the views that saw points of surfaces well.

    Args:
        p_W: The points, shape (n, 3) [m].
        inward_W: Unit normals into the solid, shape (n, 3).
        sight: True data of the cameras.

    Returns:
        Shape (n,).
    """
    perfect, count = sight.perfect, np.zeros(len(p_W), int)
    height, width = perfect.size
    for view in range(len(perfect)):
        X_WC, K = perfect.X_WC[view], perfect.K[view]
        p_C = (p_W - X_WC[:3, 3]) @ X_WC[:3, :3]
        with np.errstate(divide="ignore", invalid="ignore"):
            u, v = (p_C @ K.T)[:, :2].T / p_C[:, 2]
        inside = (p_C[:, 2] > 0) & (u >= 0) & (u < width)
        rows = np.flatnonzero(inside & (v >= 0) & (v < height))
        pixel = v[rows].astype(int), u[rows].astype(int)
        exact, z = perfect.depth[view][pixel], p_C[rows, 2]
        ray_W = p_W[rows] - X_WC[:3, 3]
        ray_W /= np.linalg.norm(ray_W, axis=1, keepdims=True)
        cosine = (ray_W * inward_W[rows]).sum(axis=1)
        incidence = np.arccos(np.clip(cosine, -1, 1))
        count[rows] += (
            (exact > 0)
            & (sight.depth[view][pixel] > 0)
            & (np.abs(exact - z) < _OWN)
            & (cosine > _STEEPEST)
            & (sight.sensor.axial(z, incidence) < _NOISIEST)
        )
    return count
