"""`DetectionState`, and `add_image`, which updates it with a depth image.

    detection = DetectionState()
    for image in images:
        detection = look(detection, image, spheres, scene, config)
        movers = detection.movers(config)

All objects are immutable, and independent of processes, networks and clocks.
"""

import dataclasses as dc
from collections.abc import Mapping, Sequence
from functools import partial

import numpy as np

from remosplat_drake.detection.depth_image import DepthImage
from remosplat_drake.detection.detection_config import DetectionConfig
from remosplat_drake.detection.following import follow, still_hidden
from remosplat_drake.detection.known_scene import KnownScene
from remosplat_drake.detection.new_points import find_new
from remosplat_drake.detection.pose_check import contradiction
from remosplat_drake.detection.things import things_seen
from remosplat_drake.detection.track import Track
from remosplat_drake.detection.unseen_space import UnseenSpace
from remosplat_drake.detection.view import View
from remosplat_drake.robot.sphere_model import Spheres
from remosplat_drake.scene.mover import MOST, Mover, Movers
from remosplat_drake.scene.mover_camera import MoverCamera


@dc.dataclass(frozen=True, eq=False)
class DetectionState:
    """State of detection after all images so far.

    It is immutable, so a copy is the object itself.

    Attributes:
        time: Stamp of the newest image [s].
        views: The latest view of each camera, by name.
        tracks: Tracks of the objects that the map does not contain.
        count: Number of tracks that were started so far, from which they get
            their names.
        unseen: Space in which objects may be hidden; None if this is disabled,
            or before the first image.
    """

    time: float = -np.inf
    views: Mapping[str, View] = dc.field(default_factory=dict)
    tracks: Sequence[Track] = ()
    count: int = 0
    unseen: UnseenSpace | None = None

    def __deepcopy__(self, memo) -> "DetectionState":
        return self

    def movers(self, config: DetectionConfig) -> Movers:
        """Returns the movers at the time of the newest image.

        Args:
            config: Settings, with bounds on the motion of objects.
        """
        trusted = [track for track in self.tracks if track.is_trusted]
        movers: list[Mover] = []
        hidden = self.unseen.movers(self.time, config) if self.unseen else []
        most = MOST - len(hidden)
        for i, track in enumerate(trusted):
            parts = track.movers(config)
            if len(movers) + len(parts) + len(trusted) - i > most:
                parts = track.movers(config, coarse=True)
            movers.extend(parts)
        cameras = [self._camera(view, config) for view in self.views.values()]
        stamp = max(self.time, 0.0)
        return Movers(stamp, [*movers[:most], *hidden], cameras)

    def _camera(self, view: View, config: DetectionConfig) -> MoverCamera:
        problem = view.problem
        if not problem and self.time - view.seen > config.expiry:
            problem = f"no image for {self.time - view.seen:.1f} s"
        return view.image.as_mover_camera(view.seen, config.range, problem)

    def settled(self, config: DetectionConfig) -> tuple[Track, ...]:
        """Returns the objects at rest, which the map should contain.

        Args:
            config: Settings, with the time at rest after which an object has
                settled.
        """
        return tuple(
            track
            for track in self.tracks
            if track.is_trusted and track.is_still(config)
        )


def add_image(
    detection: DetectionState,
    image: DepthImage,
    spheres: Spheres,
    scene: KnownScene,
    config: DetectionConfig,
) -> DetectionState:
    """Updates the state with an image.

    An image that is older than the newest one is ignored. If an image
    contradicts its camera pose, only this problem is recorded.

    Args:
        detection: The state so far.
        image: The image.
        spheres: The robot's spheres in W when the image was taken.
        scene: The map.
        config: Settings, with errors, margins and bounds.
    """
    if image.time < detection.time:
        return detection
    problem = contradiction(image, scene, config)
    if problem:
        return without_image(detection, image, problem)
    points = find_new(image, spheres, scene, config)
    mine = View(image, points, np.full(len(points), -1), (), image.time)
    others = {
        name: view.moved_on(detection.tracks, mine, config)
        for name, view in detection.views.items()
        if name != image.camera
    }
    views = {**others, image.camera: mine}
    things, of = things_seen(views, image.time, spheres, config)
    hidden = partial(
        still_hidden,
        things=things,
        views=views,
        spheres=spheres,
        scene=scene,
        config=config,
    )
    tracks, count = follow(
        detection.tracks, detection.count, things, image.time, hidden, config
    )
    names = tuple(track.name for track in tracks[: len(things)])
    views = {
        name: dc.replace(view, of=of[name], names=names)
        for name, view in views.items()
    }
    found = DetectionState(image.time, views, tracks, count)
    if not config.unseen_speed:
        return found
    unseen = detection.unseen or UnseenSpace.first(spheres, image.time, config)
    images = [view.image for view in views.values()]
    unseen = unseen.after(images, spheres, scene, config)
    return dc.replace(found, unseen=unseen)


def without_image(
    detection: DetectionState, image: DepthImage, problem: str
) -> DetectionState:
    """Records that an image cannot be used.

    The camera's previous view and its time do not change.

    Args:
        detection: The state so far.
        image: The image.
        problem: Reason why the image cannot be used.
    """
    view = detection.views.get(image.camera) or View.blind(image, problem)
    view = dc.replace(view, problem=problem)
    return dc.replace(detection, views={**detection.views, image.camera: view})
