"""`Sight`: the state of detection, and `look`, which adds an image.

    sight = Sight()
    for image in images:
        sight = look(sight, image, spheres, scene, config)
        movers = sight.movers(config)

All objects are immutable, and independent of processes, networks and clocks.
"""

import dataclasses as dc
from collections.abc import Mapping, Sequence
from functools import partial

import numpy as np

from remosplat_drake.robot.sphere_model import Spheres
from remosplat_drake.scene.mover import MOST, Mover, Movers
from remosplat_drake.scene.mover_camera import MoverCamera
from remosplat_drake.sight.depth_image import DepthImage
from remosplat_drake.sight.following import follow, still_hidden
from remosplat_drake.sight.known_scene import KnownScene
from remosplat_drake.sight.new_points import find_new
from remosplat_drake.sight.pose_check import contradiction
from remosplat_drake.sight.sight_config import SightConfig
from remosplat_drake.sight.things import things_seen
from remosplat_drake.sight.track import Track
from remosplat_drake.sight.unseen_space import UnseenSpace
from remosplat_drake.sight.view import View


@dc.dataclass(frozen=True, eq=False)
class Sight:
    """State of detection after all images so far; a copy is the object itself.

    Attributes:
        time: Stamp of the newest image [s].
        views: The latest view of each camera, by name.
        tracks: The tracked things, which the map does not contain.
        count: Number of tracks so far, for their names.
        unseen: Space in which something may be hidden; None if that is
            disabled, or before the first image.
    """

    time: float = -np.inf
    views: Mapping[str, View] = dc.field(default_factory=dict)
    tracks: Sequence[Track] = ()
    count: int = 0
    unseen: UnseenSpace | None = None

    def __deepcopy__(self, memo) -> "Sight":
        return self

    def movers(self, config: SightConfig) -> Movers:
        """Returns the movers at the time of the newest image.

        Args:
            config: Bounds on the motion of things.
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

    def _camera(self, view: View, config: SightConfig) -> MoverCamera:
        problem = view.problem
        if not problem and self.time - view.seen > config.expiry:
            problem = f"no image for {self.time - view.seen:.1f} s"
        return view.image.as_mover_camera(view.seen, config.range, problem)

    def settled(self, config: SightConfig) -> tuple[Track, ...]:
        """Returns the things at rest, which the map should contain.

        Args:
            config: The time at rest after which a thing has settled.
        """
        return tuple(
            track
            for track in self.tracks
            if track.is_trusted and track.is_still(config)
        )


def look(
    sight: Sight,
    image: DepthImage,
    spheres: Spheres,
    scene: KnownScene,
    config: SightConfig,
) -> Sight:
    """Updates the state with an image.

    An image that is older than the newest one is ignored. If an image
    contradicts its pose, only this problem is recorded.

    Args:
        sight: The state so far.
        image: The image.
        spheres: The robot's spheres in W when it was taken.
        scene: The map.
        config: Errors, margins and bounds.
    """
    if image.time < sight.time:
        return sight
    problem = contradiction(image, scene, config)
    if problem:
        return without(sight, image, problem)
    points = find_new(image, spheres, scene, config)
    mine = View(image, points, np.full(len(points), -1), (), image.time)
    others = {
        name: view.moved_on(sight.tracks, mine, config)
        for name, view in sight.views.items()
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
        sight.tracks, sight.count, things, image.time, hidden, config
    )
    names = tuple(track.name for track in tracks[: len(things)])
    views = {
        name: dc.replace(view, of=of[name], names=names)
        for name, view in views.items()
    }
    found = Sight(image.time, views, tracks, count)
    if not config.unseen_speed:
        return found
    unseen = sight.unseen or UnseenSpace.first(spheres, image.time, config)
    images = [view.image for view in views.values()]
    unseen = unseen.after(images, spheres, scene, config)
    return dc.replace(found, unseen=unseen)


def without(sight: Sight, image: DepthImage, problem: str) -> Sight:
    """Records that an image cannot be used.

    The camera's previous view and its time are kept.

    Args:
        sight: The state so far.
        image: The image.
        problem: Why it cannot be used.
    """
    view = sight.views.get(image.camera) or View.blind(image, problem)
    view = dc.replace(view, problem=problem)
    return dc.replace(sight, views={**sight.views, image.camera: view})
