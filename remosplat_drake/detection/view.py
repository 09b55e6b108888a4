"""`View`: the latest image of one camera, and the space it looks through."""

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
"""Number of samples on the ray behind a seen point that are compared with other
cameras' images."""


@dc.dataclass(frozen=True, eq=False)
class View:
    """The latest view of one camera.

    Attributes:
        image: Its latest usable image; before the first, an empty one.
        points: The new points in it.
        of: For each of the points, the index in `names` of its track, or -1,
            shape (n,).
        names: Names of these tracks.
        seen: Time of that image [s].
        problem: Why there is no newer image; empty if nothing is wrong.
    """

    image: DepthImage
    points: NewPoints
    of: np.ndarray
    names: tuple[str, ...]
    seen: float
    problem: str = ""

    @staticmethod
    def blind(image: DepthImage, problem: str) -> "View":
        """Makes the view of a camera without a usable image."""
        nothing = dc.replace(image, depth=np.zeros_like(image.depth))
        points = NewPoints.none(image)
        return View(nothing, points, np.zeros(0, int), (), 0.0, problem)

    def looks_through(
        self, p_W: np.ndarray, config: DetectionConfig
    ) -> np.ndarray:
        """Returns whether the image shows something behind points.

        Args:
            p_W: The points in W, shape (n, 3).
            config: Errors and margins.

        Returns:
            True where it does, shape (n,) bool.
        """
        return _is_behind(*self.image.depths_at(p_W), config)

    def observes(
        self, p_W: np.ndarray, spheres: Spheres, config: DetectionConfig
    ) -> np.ndarray:
        """Marks points for which the image shows whether something is there.

        A point is not marked if something nearer hides it, or if the measured
        point may belong to the robot and is not behind it.

        Args:
            p_W: The points in W, shape (n, 3).
            spheres: The robot's spheres in W.
            config: Errors and margins.

        Returns:
            True where it does, shape (n,) bool.
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
        """Returns the seen points, advanced to the time of another view.

        Points that the newer view looks through are removed.

        Args:
            tracks: The tracks, whose points move with them.
            newer: The view of the other camera.
            config: Bounds on motions, and the time for which points are kept.
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
    """Returns whether depths exceed those of points by more than noise."""
    z = p_C[:, 2]
    return measured > z + 2 * config.margin(z)


def backs(
    views: Mapping[str, View], camera: str, config: DetectionConfig
) -> np.ndarray:
    """Returns the possible extent of things behind their visible faces.

    That is `thickness` along the ray, or up to a point that another camera
    looks through.

    Args:
        views: The view of each camera, by name.
        camera: The camera.
        config: Largest thickness of things.

    Returns:
        For each of the camera's points, the farthest point in W that may belong
        to the thing, shape (n, 3).
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
