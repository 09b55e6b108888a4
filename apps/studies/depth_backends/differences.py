"""Explains differences of the two backends of the depth views at a pixel.

A ray's fragments are composited once more, in NumPy and double precision, by
the definition with some rules replaced by gsplat's. The rules that reproduce
the GPU's result are the reason of the difference.
"""

import dataclasses as dc
from collections.abc import Set

import numpy as np

from remosplat_drake.oracle.depth_rasterization_reference import composite
from remosplat_drake.oracle.depth_sensor import N_VIEWS, R_DV, DepthSensor
from remosplat_drake.robot.sphere_model import Spheres
from remosplat_drake.signals.distance_field import Clearances
from remosplat_drake.splat.gaussian_splat import GaussianSplat

RULES = {
    "order": "discs are sorted by one depth each, not along the ray",
    "outline": "discs end where alpha falls below 1/255, not at 3 sigma",
    "planes": "fragments before the near and behind the far plane count",
    "clamp": "alpha is at most 0.999",
}
"""Rules of gsplat that differ from the definition of `DepthSensor`."""

SEVERAL, ROUNDING, UNEXPLAINED = "several", "rounding", "unexplained"

CLASSES = (*RULES, SEVERAL, ROUNDING, UNEXPLAINED)
"""Reasons of a difference: one rule, several, rounding at a threshold, or
none found."""

TOLERANCE = 1e-3
"""Difference of two distances up to which they count as equal [m]."""

_ROUNDING = 1e-4
"""Error of an accumulated alpha in single precision, at most."""


@dc.dataclass(frozen=True)
class ViewAnswers:
    """Distances and pixels of all six views of n spheres.

    Attributes:
        distance: Distance in each view, shape (n, 6) [m]; inf without an
            answer.
        pixel: Row-major index of the nearest pixel in each view, shape (n, 6).
    """

    distance: np.ndarray
    pixel: np.ndarray


def by_view(
    answer: Clearances, spheres: Spheres, sensor: DepthSensor
) -> ViewAnswers:
    """Sorts the rows of a depth field's answer by sphere and view.

    Args:
        answer: Rows of the field's answer, in any order.
        spheres: The n queried spheres.
        sensor: The views of a sphere.
    """
    distance = np.full((len(spheres), N_VIEWS), np.inf)
    pixel = np.zeros((len(spheres), N_VIEWS), int)
    R_WD = sensor.R_WD(spheres.R_WL)[answer.sphere]
    n_V = np.einsum("vji,nkj,nk->nvi", R_DV, R_WD, answer.direction_W)
    view = n_V[:, :, 2].argmax(axis=1)
    n_V = n_V[np.arange(len(view)), view]
    ray = n_V[:, :2] / n_V[:, 2:]
    column, row = np.floor((ray + 1) * (sensor.resolution / 2)).astype(int).T
    distance[answer.sphere, view] = answer.distance
    pixel[answer.sphere, view] = row * sensor.resolution + column
    return ViewAnswers(distance, pixel)


@dc.dataclass(frozen=True)
class Fragments:
    """The discs that one ray meets, in no order; arrays have shape (k,).

    Attributes:
        z: Depths at which the ray meets the discs, of any sign [m].
        weight: Squared Mahalanobis distances at these points.
        opacity: Opacities of the discs.
        depth: Depths by which gsplat sorts the discs of this view [m].
        shown: Whether gsplat renders a disc on the pixel's tile.
        near: Whether a disc is nearer than the queried distance.
        length: Ratio of range to depth along the ray.
    """

    z: np.ndarray
    weight: np.ndarray
    opacity: np.ndarray
    depth: np.ndarray
    shown: np.ndarray
    near: np.ndarray
    length: float


class Differences:
    """Explains views of one splat that the two backends answer differently.

    Args:
        splat_W: Splat of 2DGS discs, expressed in W.
        sensor: The views of a sphere, without low-pass filter.
        max_distance: Largest distance of the queries [m].
    """

    def __init__(
        self, splat_W: GaussianSplat, sensor: DepthSensor, max_distance: float
    ):
        seen = np.flatnonzero(splat_W.opacities >= sensor.min_alpha)
        self._splat = splat_W.select(seen)
        self._sensor = sensor
        self._max_distance = max_distance
        self._p_WK = self._splat.p_GK.astype(float)
        self._opacity = self._splat.opacities.astype(float)
        self._cut = 2 * np.log(self._opacity / sensor.min_alpha)
        scales = self._splat.scales.max(axis=1).astype(float)
        self._radius = np.sqrt(self._cut) * scales

    def why(
        self,
        spheres: Spheres,
        sphere: int,
        view: int,
        cpu: ViewAnswers,
        cuda: ViewAnswers,
    ) -> str:
        """Returns the reason of a view's difference.

        Args:
            spheres: The queried spheres.
            sphere: Index of the view's sphere.
            view: Index of the view, 0 to 5.
            cpu: Answer of the CPU backend.
            cuda: Answer of the CUDA backend.

        Returns:
            One of `CLASSES`.
        """
        answers = [a.distance[sphere, view] for a in (cpu, cuda)]
        nearer = cpu if answers[0] < answers[1] else cuda
        fragments = self.fragments(
            spheres, sphere, view, int(nearer.pixel[sphere, view])
        )
        goal = min(answers[1], self._max_distance) + spheres.radius[sphere]

        def is_explained(rules: Set[str], shift: float = 0.0) -> bool:
            ranges = self._ranges(fragments, rules, shift)
            if nearer is cpu:
                return max(ranges) > goal - TOLERANCE
            return min(abs(r - goal) for r in ranges) < TOLERANCE

        for rule in RULES:
            if is_explained({rule}):
                return rule
        if is_explained(RULES.keys()):
            return SEVERAL
        if any(is_explained(RULES.keys(), s) for s in (_ROUNDING, -_ROUNDING)):
            return ROUNDING
        return UNEXPLAINED

    def fragments(
        self, spheres: Spheres, sphere: int, view: int, pixel: int
    ) -> Fragments:
        """Returns the discs that the ray through a view's pixel meets."""
        sensor = self._sensor
        row, column = divmod(pixel, sensor.resolution)
        axis = sensor.pixel_centers()
        ray_V = np.array([axis[column], axis[row], 1.0])
        length = float(np.linalg.norm(ray_V))
        R_WV = sensor.R_WD(spheres.R_WL)[sphere] @ R_DV[view]
        p_SK_W = self._p_WK - spheres.p_WS[sphere]
        square = (p_SK_W**2).sum(axis=1)
        aside = square - (p_SK_W @ (R_WV @ ray_V / length)) ** 2
        k = np.flatnonzero(
            (aside <= self._radius**2)
            & (self._p_WK[:, 2] >= spheres.ignore_below[sphere])
        )
        p_SK_V = p_SK_W[k] @ R_WV
        axes_V = R_WV.T @ self._splat.R_GK[k]
        scales = self._splat.scales[k].astype(float)
        normal_V = axes_V[:, :, 2]
        with np.errstate(divide="ignore", invalid="ignore"):
            z = (normal_V * p_SK_V).sum(axis=1) / (normal_V @ ray_V)
        uv = np.einsum(
            "kj,kji->ki", z[:, None] * ray_V - p_SK_V, axes_V[:, :, :2]
        )
        depth, shown = self._footprints(
            p_SK_V, axes_V, scales, k, np.array([column, row])
        )
        reach = spheres.radius[sphere] + self._max_distance
        return Fragments(
            z,
            ((uv / scales) ** 2).sum(axis=1),
            self._opacity[k],
            depth,
            shown,
            np.sqrt(square[k]) - self._radius[k] <= reach,
            length,
        )

    def _footprints(self, p_SK_V, axes_V, scales, k, pixel):
        import torch

        from remosplat_drake.oracle.kernels.gsplat_views import TILE, footprint

        frames_V = axes_V.copy()
        frames_V[:, :, :2] *= scales[:, None]
        frames_V[:, :, 2] = p_SK_V
        bounds = footprint(
            torch.from_numpy(frames_V),
            torch.from_numpy(self._cut[k]),
            torch.zeros(len(k)),
            self._sensor,
        )
        center, half = bounds.center.numpy(), bounds.half.numpy()
        first = np.floor((center - half) / TILE)
        last = np.ceil((center + half) / TILE) - 1
        shown = (first <= pixel // TILE) & (pixel // TILE <= last) & (half > 0)
        aside = np.abs(p_SK_V[:, :2]).max(axis=1)
        in_frustum = aside <= p_SK_V[:, 2] + np.sqrt(2) * self._radius[k]
        return bounds.depth.numpy(), shown.all(axis=1) & in_frustum

    def _ranges(
        self, fragments: Fragments, rules: Set[str], shift: float
    ) -> list[float]:
        """Returns the possible ranges of a ray with some of gsplat's `RULES`.

        There are two: the GPU uses the discs within the queried distance first,
        and the others only if these do not suffice.
        """
        sensor = dc.replace(
            self._sensor,
            alpha_cutoff=self._sensor.alpha_cutoff + shift,
            transmittance=self._sensor.transmittance - shift,
        )
        alpha = fragments.opacity * np.exp(-0.5 * fragments.weight)
        seen = alpha >= sensor.min_alpha
        if "clamp" in rules:
            alpha = np.minimum(alpha, 0.999)
        if "outline" not in rules:
            seen &= fragments.weight <= sensor.n_sigma**2
        inside = (fragments.z >= sensor.near) & (fragments.z <= sensor.far)
        seen &= fragments.shown if "planes" in rules else inside
        key = fragments.depth if "order" in rules else fragments.z
        ranges = []
        for part in (seen & fragments.near, seen):
            order = np.flatnonzero(part)
            order = order[np.argsort(key[order], kind="stable")]
            z = np.inf
            if len(order):
                z, _ = composite(fragments.z[order], alpha[order], sensor)
            is_inside = sensor.near <= z <= sensor.far
            ranges.append(z * fragments.length if is_inside else np.inf)
        return ranges
