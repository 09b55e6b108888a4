"""`Thing`: a detected object, with its points from all cameras."""

import dataclasses as dc
from collections.abc import Mapping

import numpy as np
from scipy.spatial.distance import cdist

from remosplat_drake.detection.clusters import clustered
from remosplat_drake.detection.detection_config import DetectionConfig
from remosplat_drake.detection.enclosure import RoundedBox, enclose
from remosplat_drake.detection.kernels.near_any import near_any
from remosplat_drake.detection.track import Stretches
from remosplat_drake.detection.view import View, backs
from remosplat_drake.robot.sphere_model import Spheres


@dc.dataclass(frozen=True, eq=False)
class Thing:
    """A detected object: a cluster of new points, and boxes around it.

    Attributes:
        shown: The object's visible points from all cameras, each with the
            possible extent of the object behind the point.
        parts: Boxes around the points and their possible extents.
        pitch: Greatest distance between neighbouring pixels on the object [m].
        error: Bound on position errors of the points [m].
        deviation: Standard deviation of the object's outline between images
            [m].
    """

    shown: Stretches
    parts: tuple[RoundedBox, ...]
    pitch: float
    error: float
    deviation: float

    @staticmethod
    def of(
        shown: Stretches,
        depth: np.ndarray,
        pitch: float,
        spheres: Spheres,
        config: DetectionConfig,
    ) -> "Thing":
        """Makes an object from a cluster of points.

        Points close to the robot count as points of the robot. So if the
        visible part of an object ends at such points, the object is assumed to
        touch the robot.

        Args:
            shown: The points, shape (n,).
            depth: Depths of the points in the images that show them, shape (n,)
                [m].
            pitch: Greatest distance between neighbouring pixels at the points
                [m].
            spheres: The robot's spheres in W.
            config: Settings, with the cameras' errors.
        """
        far = float(depth.max())
        margin = float(config.margin(far))
        touch_W = _touches(shown.face_W, spheres, config.beside(margin) + pitch)
        return Thing(
            shown,
            enclose(
                np.concatenate([shown.face_W, touch_W]),
                np.concatenate([shown.back_W, touch_W]),
                pitch,
            ),
            pitch,
            margin,
            0.3 * pitch + 0.7 * float(config.deviation(far)),
        )

    def distances(self, p_W: np.ndarray) -> np.ndarray:
        """Returns distances of points (n, 3) from the object's boxes [m]."""
        return np.min([part.distance(p_W) for part in self.parts], axis=0)


def _touches(p_W: np.ndarray, spheres: Spheres, beside: float) -> np.ndarray:
    """Returns points at which objects close to the robot would touch it."""
    radius = np.asarray(spheres.radius)
    p_W = p_W[near_any(p_W, spheres.p_WS, radius + beside)]
    gap = cdist(p_W, spheres.p_WS) - radius
    near, sphere = np.nonzero((gap > 0) & (gap <= beside))
    way_W = spheres.p_WS[sphere] - p_W[near]
    way_W /= np.linalg.norm(way_W, axis=1, keepdims=True)
    return p_W[near] + gap[near, sphere][:, None] * way_W


def things_seen(
    views: Mapping[str, View],
    time: float,
    spheres: Spheres,
    config: DetectionConfig,
) -> tuple[list[Thing], dict[str, np.ndarray]]:
    """Clusters the new points of all cameras into objects.

    Args:
        views: The view of each camera, by name.
        time: The present time [s].
        spheres: The robot's spheres in W.
        config: Settings, with the largest distance between neighbouring points
            of an object.

    Returns:
        The objects, and a dictionary. For the name of each camera, it contains
        the index of the object to which each of the camera's points belongs, or
        -1, shape (n,).
    """
    groups = [view.points for view in views.values()]
    face_W = np.concatenate([group.p_W for group in groups])
    back_W = np.concatenate([backs(views, name, config) for name in views])
    depth = np.concatenate([group.depth for group in groups])
    pitch = np.concatenate([group.pitch * group.depth for group in groups])
    link = max(config.link, 3 * float(np.median(pitch))) if len(pitch) else 0
    label = clustered(face_W, link)
    things: list[Thing] = []
    of = np.full(len(face_W), -1)
    for cluster in range(label.max(initial=-1) + 1):
        members = np.flatnonzero(label == cluster)
        if len(members) < config.least_points:
            continue
        of[members] = len(things)
        shown = Stretches(
            face_W[members],
            back_W[members],
            np.full(len(members), time),
        )
        wide = float(pitch[members].max())
        things.append(Thing.of(shown, depth[members], wide, spheres, config))
    sorted_points, start = {}, 0
    for name, view in views.items():
        sorted_points[name] = of[start : start + len(view.points)]
        start += len(view.points)
    return things, sorted_points
