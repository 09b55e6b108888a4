"""`Sight`: true data of a case's cameras, for evaluation only."""

import dataclasses as dc

import numpy as np

from apps.studies.map_bound.judge import SEEN_BY
from apps.studies.true_maps.cameras import HEIGHT, WIDTH
from apps.studies.true_maps.case import Taken
from apps.studies.true_maps.ray_casting import Nearest

_STEEPEST = np.cos(np.deg2rad(78))
"""A view sees a surface only if the cosine of the angle of incidence is at
least this."""

_BORDER = 1
"""Pixels at the border of an image in which a surface does not count as seen: a
pixel's ray through its centre may miss it there, and no ray beyond the border
meets it."""

_OWN = 0.001
"""A ray reaches a point if it ends less than this in front of the point [m]."""

_ALIKE = 0.1
"""A depth shows a surface if it differs from the surface's depth by at most
this fraction. Noise and errors of the depth are smaller. A pixel may also have
the depth of the background, beside an outline and at objects that are nearer
than the sensor's range."""

_LOOKS = 6
"""The width of a surface is measured with this many of the nearest views."""

_STEPS = 3
"""Number of samples per pixel for widths."""

_SLOPE = 6.0
"""On one surface, the depth changes by at most this multiple of the distance
across, which permits angles of incidence up to 80 degrees."""

_ACROSS = np.deg2rad([0, 45, 90, 135])
"""Directions in the image in which widths are measured [rad]."""


@dc.dataclass(frozen=True, eq=False)
class Surface:
    """Surface points that pixels show.

    Attributes:
        p_W: The points, shape (n, 3) [m].
        part: Index of the part that each is on, shape (n,).
        p_WC: Starts of the pixels' rays, shape (n, 3) [m].
    """

    p_W: np.ndarray
    part: np.ndarray
    p_WC: np.ndarray


@dc.dataclass(frozen=True, eq=False)
class Sight:
    """The true geometry, the true cameras, and the depths of the sensor.

    Attributes:
        taken: The case's captures.
    """

    taken: Taken

    @property
    def focus_W(self) -> np.ndarray:
        """Centre of the robot's workspace, shape (3,) [m]."""
        return self.taken.scene.focus_W

    def in_workspace(self, p_W: np.ndarray) -> np.ndarray:
        """Marks points (n, 3) at most 1 m from the focus along each axis."""
        return np.abs(p_W - self.focus_W).max(axis=1) < 1

    def labels(self, part: np.ndarray) -> np.ndarray:
        """Returns the labels of parts, given their indices (n,)."""
        names = np.array([part.label for part in self.taken.scene.parts])
        return names[part]

    def surface(self, count: int, rng: np.random.Generator) -> Surface:
        """Draws pixels with a depth, and returns their points in the workspace.

        Args:
            count: Number of pixels; not all of them show the workspace.
            rng: Source of randomness.
        """
        taken, parts = self.taken, []
        cameras = taken.cameras
        each = -(-count // len(cameras))
        for view in range(len(cameras)):
            p_WC, ray_W = cameras.rays(view)
            known = np.argwhere(taken.capture.depth[view] > 0)
            row, column = rng.permutation(known)[:each].T
            start_W, ray_W = p_WC[row, 0], ray_W[row, column]
            hits = taken.caster.cast(start_W, ray_W)
            met = hits.part >= 0
            p_W = start_W[met] + ray_W[met] * hits.z[met, None]
            keep = self.in_workspace(p_W)
            parts.append((p_W[keep], hits.part[met][keep], start_W[met][keep]))
        return Surface(*(np.concatenate(p) for p in zip(*parts, strict=True)))

    def is_free_way(self, start_W: np.ndarray, end_W: np.ndarray) -> np.ndarray:
        """Whether no surface is between points, both (n, 3) [m]; shape (n,)."""
        way_W = end_W - start_W
        length = _lengths(way_W)
        hits = self.taken.caster.cast(start_W, way_W)
        return hits.z * length > length - _OWN

    def seen(self, surface: Nearest) -> tuple[np.ndarray, np.ndarray]:
        """Returns which surface points at least two views have seen.

        A view sees a point if the point is not occluded, its incidence is not
        too oblique, and the sensor measured its depth at its pixel.

        Args:
            surface: The points.

        Returns:
            Two masks, shape (n,) each: points that at least two views saw, and
            points that at least two views saw on a surface of at least a
            pixel's width.
        """
        cameras, count = self.taken.cameras, len(surface.p_W)
        depth = np.full((len(cameras), count), np.inf)
        for view in range(len(cameras)):
            depth[view] = self._seen_at(view, surface)
        nearest = np.argsort(depth, axis=0)[:_LOOKS]
        wide = np.zeros(count, int)
        for views in nearest:
            for view in np.unique(views):
                rows = np.flatnonzero(
                    (views == view) & np.isfinite(depth[view])
                )
                wide[rows] += self._is_wide(view, surface, rows)
        seen = np.isfinite(depth).sum(axis=0) >= SEEN_BY
        return seen, wide >= SEEN_BY

    def _seen_at(self, view: int, surface: Nearest) -> np.ndarray:
        """Depths at which a view sees points, (n,) [m]; inf if unseen."""
        cameras, p_W = self.taken.cameras, surface.p_W
        u, v, z = cameras.project(view, p_W)
        inside = (u >= _BORDER) & (u < WIDTH - _BORDER)
        inside &= (v >= _BORDER) & (v < HEIGHT - _BORDER)
        rows = np.flatnonzero(inside)
        pixel = v[rows].astype(int), u[rows].astype(int)
        measured = self.taken.capture.depth[view][pixel]
        rows = rows[np.abs(measured - z[rows]) <= _ALIKE * z[rows]]
        start_W = cameras.poses(view, v[rows])[:, :3, 3]
        ray_W = p_W[rows] - start_W
        cosine = np.abs((ray_W * surface.normal_W[rows]).sum(axis=1))
        facing = cosine > _STEEPEST * _lengths(ray_W)
        facing &= self.is_free_way(start_W, p_W[rows])
        depth = np.full(len(p_W), np.inf)
        depth[rows[facing]] = z[rows[facing]]
        return depth

    def _is_wide(
        self, view: int, surface: Nearest, rows: np.ndarray
    ) -> np.ndarray:
        """Whether surfaces are a pixel wide at points, in all directions."""
        cameras, p_W = self.taken.cameras, surface.p_W[rows]
        _, v, z = cameras.project(view, p_W)
        X_WC = cameras.poses(view, v)
        pitch = z / cameras.K[0, 0]
        step = np.arange(1, _STEPS + 1) / _STEPS
        xy = np.stack([np.cos(_ACROSS), np.sin(_ACROSS)], axis=1)
        # Axes of the array: direction, side, step.
        offset = np.stack([xy, -xy], axis=1)[:, :, None] * step[:, None]
        shape = len(rows), *offset.shape[:-1]
        axes_W = X_WC[:, :3, :2].transpose(0, 2, 1)
        shift_W = (offset.reshape(-1, 2) @ axes_W) * pitch[:, None, None]
        start_W = X_WC[:, None, :3, 3]
        hits = self.taken.caster.cast(start_W, p_W[:, None] + shift_W - start_W)
        across = np.tile(step, offset[..., 0].size // _STEPS) * pitch[:, None]
        same = hits.part == surface.part[rows, None]
        same &= np.abs(hits.z - 1) * z[:, None] < _SLOPE * across + _OWN
        # Number of steps by which the surface continues to each side.
        reach = same.reshape(shape).cumprod(axis=-1).sum(axis=-1)
        return (reach.sum(axis=-1) >= _STEPS).all(axis=-1)


def _lengths(v_W: np.ndarray) -> np.ndarray:
    return np.linalg.norm(v_W, axis=-1)
