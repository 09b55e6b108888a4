"""`SeenSpaceField`: distances to the surfaces that depth images show.

Scenes from mesh files have no signed distance, since the inside of an open mesh
is undefined. Depth images determine free space: it is the space between a
camera and the surfaces in its view.
"""

from collections.abc import Sequence

import numpy as np

from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.capture.capture import back_project
from remosplat_drake.capture.rendering.camera_poses import look_at
from remosplat_drake.capture.rendering.renderer import FAR, SceneRenderer
from remosplat_drake.capture.rendering.solids import Solid
from remosplat_drake.oracle.point_distance import PointDistanceField
from remosplat_drake.robot.sphere_model import Spheres
from remosplat_drake.signals.distance_field import Clearances, DistanceField

_SIZE = 120
"""Width and height of the depth images that `look_round` renders [pixels]."""

_WIDE = np.pi / 2
"""Field of view of these images [rad], with which six show all directions."""

_ELEVATIONS = (0.15, 0.8)
_AZIMUTHS = np.arange(8) * np.pi / 4


class SeenSpaceField(DistanceField):
    """Distances to the points of depth images; negative in unseen space.

    Args:
        K: Intrinsic matrix that all images share, shape (3, 3) [pixels].
        depth: Depth z in C, shape (n, h, w) [m]; 0 where there is no surface.
        X_WC: Camera poses (OpenCV axes), shape (n, 4, 4).

    Raises:
        RemoSplatError: No image shows a surface.
    """

    def __init__(self, K: np.ndarray, depth: np.ndarray, X_WC: np.ndarray):
        points = [
            back_project(K, z, X) for z, X in zip(depth, X_WC, strict=True)
        ]
        p_WP = np.concatenate([p.reshape(-1, 3) for p in points])
        p_WP = p_WP[np.isfinite(p_WP[:, 0])]
        if not len(p_WP):
            raise RemoSplatError("no depth image shows a surface")
        self._cloud = PointDistanceField(p_WP)
        self._K, self._depth, self._X_WC = K, depth, X_WC
        self.revision = f"seen-space-{self._cloud.revision}"

    def clearances(
        self, spheres: Spheres, max_distance: float = np.inf
    ) -> Clearances:
        """Measures the clearances of spheres; see `DistanceField`."""
        answer = self._cloud.clearances(spheres)
        radius = spheres.radius[answer.sphere]
        side = np.where(self.is_seen(spheres.p_WS[answer.sphere]), 1.0, -1.0)
        return Clearances(
            answer.sphere,
            side * (answer.distance + radius) - radius,
            side[:, None] * answer.direction_W,
            answer.p_WC,
            self.revision,
        ).within(max_distance)

    def is_seen(self, p_WS: np.ndarray) -> np.ndarray:
        """Returns a mask of the points that any image shows as free.

        Args:
            p_WS: Points in W, shape (n, 3) [m].

        Returns:
            Shape (n,), bool.
        """
        seen = np.zeros(len(p_WS), bool)
        height, width = self._depth.shape[1:]
        for z, X_WC in zip(self._depth, self._X_WC, strict=True):
            p_CS = (p_WS - X_WC[:3, 3]) @ X_WC[:3, :3]
            with np.errstate(divide="ignore", invalid="ignore"):
                u, v = (p_CS @ self._K.T)[:, :2].T / p_CS[:, 2]
            ahead = p_CS[:, 2] > 0
            inside = (u >= 0) & (u < width) & (v >= 0) & (v < height)
            rows = np.flatnonzero(ahead & inside)
            limit = z[v[rows].astype(int), u[rows].astype(int)]
            limit = np.where(limit > 0, limit, FAR)
            seen[rows] |= p_CS[rows, 2] < limit
        return seen


def look_round(
    solids: Sequence[Solid],
    lower: np.ndarray,
    upper: np.ndarray,
    around: np.ndarray | None = None,
) -> SeenSpaceField:
    """Makes the field of a scene from images taken outside and inside it.

    Args:
        solids: The solids of the scene.
        lower: Lower corner of a box around the relevant space, shape (3,) [m].
        upper: Upper corner of that box, shape (3,) [m].
        around: A point of free space from which images in all directions are
            rendered, shape (3,) [m]. Scenes that enclose the workspace, such as
            rooms, need it. None: there are no such images.

    Raises:
        RemoSplatError: No image shows a surface.
    """
    center, half = (lower + upper) / 2, np.linalg.norm(upper - lower) / 2
    away = min(2 * half, 0.9 * FAR)
    outward = [np.array([0, 0, 1.0])] + [
        np.array([np.cos(e) * np.cos(a), np.cos(e) * np.sin(a), np.sin(e)])
        for e in _ELEVATIONS
        for a in _AZIMUTHS
    ]
    poses = [look_at(center + away * axis, center) for axis in outward]
    if around is not None:
        axes = np.concatenate([np.eye(3), -np.eye(3)])
        poses += [look_at(around, around + axis) for axis in axes]
    renderer = SceneRenderer(solids, _SIZE, _SIZE, _WIDE)
    depth = np.array([renderer.depth(X_WC) for X_WC in poses])
    return SeenSpaceField(
        renderer.K, depth, np.array([X.GetAsMatrix4() for X in poses])
    )
