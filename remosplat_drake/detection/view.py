"""`View`: the latest image of one camera, and the new points in it."""

import dataclasses as dc
from collections.abc import Mapping, Sequence

import numpy as np

from remosplat_drake.detection.depth_image import DepthImage
from remosplat_drake.detection.detection_config import DetectionConfig
from remosplat_drake.detection.kernels.robot_mask import robot_mask
from remosplat_drake.detection.new_points import NewPoints
from remosplat_drake.detection.track import Track
from remosplat_drake.robot.sphere_model import Spheres

_STEPS = 3
"""On the ray behind a visible point, this many samples are compared with the
images of other cameras.
"""


@dc.dataclass(frozen=True, eq=False)
class View:
    """The latest usable image of one camera, and the new points in it.

    Attributes:
        image: The camera's latest usable image; before the first one, an image
            without pixels.
        points: The new points in the image.
        of: For each point, the index of its track in `names`, or -1, shape
            (n,).
        names: Names of the tracks to which points belong.
        seen: Time of the image [s].
        problem: Reason why there is no newer image; empty if there is no
            problem.
    """

    image: DepthImage
    points: NewPoints
    of: np.ndarray
    names: tuple[str, ...]
    seen: float
    problem: str = ""

    @staticmethod
    def blind(image: DepthImage, problem: str) -> "View":
        """Makes the view of a camera that has sent no usable image."""
        nothing = dc.replace(image, depth=np.zeros_like(image.depth))
        points = NewPoints.none(image)
        return View(nothing, points, np.zeros(0, int), (), 0.0, problem)

    def looks_through(
        self, p_W: np.ndarray, config: DetectionConfig
    ) -> np.ndarray:
        """Returns a mask of points behind which the image shows surfaces.

        Args:
            p_W: The points in W, shape (n, 3).
            config: Settings, with errors and margins.

        Returns:
            True for points behind which the image shows a surface, shape (n,)
            bool.
        """
        return _is_behind(*self.image.depths_at(p_W), config)

    def observes(
        self, p_W: np.ndarray, spheres: Spheres, config: DetectionConfig
    ) -> np.ndarray:
        """Returns a mask of points that the camera can observe.

        A camera cannot observe a point that a nearer surface hides. Nor can it
        observe a point if the measured surface at its pixel may be the robot,
        unless this surface is behind the point.

        Args:
            p_W: The points in W, shape (n, 3).
            spheres: The robot's spheres in W.
            config: Settings, with errors and margins.

        Returns:
            Shape (n,), bool.
        """
        p_C, measured = self.image.depths_at(p_W)
        told, z = _is_behind(p_C, measured, config), p_C[:, 2]
        there = np.flatnonzero(~told & (measured > z - config.margin(z)))
        told[there] = ~robot_mask(
            p_C[there],
            measured[there],
            config.sigmas * config.deviation(measured[there]),
            self.image.balls(spheres),
            config.robot_margin,
        )
        return told

    def moved_on(
        self, tracks: Sequence[Track], newer: "View", config: DetectionConfig
    ) -> "View":
        """Returns the new points, moved to the time of another view.

        Points at which the newer view shows free space are removed.

        Args:
            tracks: The tracks; their points move with them.
            newer: The view of the other camera.
            config: Settings, with bounds on motions and the time for which
                points are kept.
        """
        points, time = self.points, newer.image.time
        if not len(points):
            return self
        by_name = {track.name: track for track in tracks}
        moved = points.p_W.copy()
        for index, name in enumerate(self.names):
            if name in by_name:
                v, _ = by_name[name].edges.velocity(config.max_speed)
                moved[self.of == index] += (time - points.time) * v
        keep = ~newer.looks_through(moved, config)
        if time - self.seen > config.expiry:
            keep[:] = False
        points = dc.replace(
            points, p_W=moved[keep], depth=points.depth[keep], time=time
        )
        return dc.replace(self, points=points, of=self.of[keep])


def _is_behind(
    p_C: np.ndarray, measured: np.ndarray, config: DetectionConfig
) -> np.ndarray:
    """Returns a mask of points with surfaces measured behind them."""
    z = p_C[:, 2]
    return measured > z + 2 * config.margin(z)


def backs(
    views: Mapping[str, View], camera: str, config: DetectionConfig
) -> np.ndarray:
    """Returns the possible extent of objects behind their visible faces.

    The extent is `thickness` along the ray, or less if another camera shows
    free space on the ray.

    Args:
        views: The view of each camera, by name.
        camera: Name of the camera.
        config: Settings, with the assumed thickness of objects.

    Returns:
        For each of the camera's points, the farthest point in W that may belong
        to the same object, shape (n, 3) [m].
    """
    points = views[camera].points
    rays_W = points.p_W - points.p_WC
    length = np.linalg.norm(rays_W, axis=1, keepdims=True)
    rays_W = rays_W / np.maximum(length, 1e-9)
    share = np.ones(len(points))
    others = [
        view
        for name, view in views.items()
        if name != camera and points.time - view.seen < config.expiry
    ]
    if len(points) and others:
        for step in range(_STEPS, 0, -1):
            behind = points.p_W + step / _STEPS * config.thickness * rays_W
            free = np.any(
                [view.looks_through(behind, config) for view in others],
                axis=0,
            )
            share[free & (share >= step / _STEPS)] = (step - 0.5) / _STEPS
    return points.p_W + config.thickness * share[:, None] * rays_W
