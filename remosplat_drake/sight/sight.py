"""`Sight`: what cameras have seen so far, and `look`, which adds an image.

    sight = Sight()
    for image in images:
        sight = look(sight, image, spheres, scene, config)
        movers = sight.movers(config)

All are values: nothing here knows of processes, wires or clocks.
"""

import dataclasses as dc
from collections.abc import Callable, Mapping, Sequence
from functools import partial

import numpy as np
from scipy.optimize import linear_sum_assignment

from remosplat_drake.robot.sphere_model import Spheres
from remosplat_drake.scene.mover import MOST, Mover, Movers
from remosplat_drake.scene.mover_camera import MoverCamera
from remosplat_drake.sight.clusters import clustered
from remosplat_drake.sight.depth_image import DepthImage
from remosplat_drake.sight.edge_filter import Edges, outline
from remosplat_drake.sight.enclosure import RoundedBox, enclose
from remosplat_drake.sight.known_scene import KnownScene
from remosplat_drake.sight.new_points import NewPoints, find_new
from remosplat_drake.sight.pose_check import contradiction
from remosplat_drake.sight.sight_config import SightConfig
from remosplat_drake.sight.track import TRUSTED, Stretches, Track
from remosplat_drake.sight.unseen_space import UnseenSpace

_LEFT = 0.05
"""Less than this share of a thing is no more than stray points."""

_STEPS = 3
"""Number of places behind a point at which another camera may look through."""

_NEAR = 0.05
"""A thing is one seen before if it is so near to where that can be [m]."""

_NEVER = 1e6
"""Cost of taking a thing for one that it cannot be."""

_STILL = 0.03
"""A thing that stays put stays within this distance, and errors [m]."""

_MOST_HIDDEN = 100
"""Most points that are remembered of a thing."""


@dc.dataclass(frozen=True, eq=False)
class View:
    """What one camera saw last.

    Attributes:
        image: Its latest image that could be used; before the first, one that
            shows nothing.
        points: What was new in it.
        of: For each of the points the index in `names` of the track that it
            belongs to, or -1, shape (n,).
        names: Names of these tracks.
        seen: When that image was taken [s].
        problem: Why there is no newer image; empty where nothing is wrong.
    """

    image: DepthImage
    points: NewPoints
    of: np.ndarray
    names: tuple[str, ...]
    seen: float
    problem: str = ""

    @staticmethod
    def blind(image: DepthImage, problem: str) -> "View":
        """Makes the view of a camera none of whose images could be used."""
        nothing = dc.replace(image, depth=np.zeros_like(image.depth))
        points = NewPoints.none(image)
        return View(nothing, points, np.zeros(0, int), (), 0.0, problem)


@dc.dataclass(frozen=True, eq=False)
class Sight:
    """What is known by all images so far; copying returns the object itself.

    Attributes:
        time: Stamp of the newest image [s].
        views: What each camera saw last, by its name.
        tracks: The things that were seen to be new.
        count: Number of tracks so far, for their names.
        unseen: Where something may be hidden; None where nothing is taken to
            be, or before the first image.
    """

    time: float = -np.inf
    views: Mapping[str, View] = dc.field(default_factory=dict)
    tracks: Sequence[Track] = ()
    count: int = 0
    unseen: UnseenSpace | None = None

    def __deepcopy__(self, memo) -> "Sight":
        return self

    def movers(self, config: SightConfig) -> Movers:
        """Tells what moves, as of the newest image.

        Args:
            config: How it may move.
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
        """Returns what stays where it is, so that the map should show it.

        Args:
            config: For how long it must have stayed.
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
    """Adds an image to what is known.

    An image that is older than the newest one is left out, and one that
    contradicts its pose tells only that.

    Args:
        sight: What is known so far.
        image: The image.
        spheres: The robot's spheres in W when it was taken.
        scene: What the map shows.
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
        name: _recent(view, sight.tracks, image, scene, config)
        for name, view in sight.views.items()
        if name != image.camera
    }
    views = {**others, image.camera: mine}
    found = _tracked(sight, views, image, spheres, scene, config)
    if not config.unseen_speed:
        return found
    unseen = sight.unseen or UnseenSpace.first(spheres, image.time, config)
    images = [view.image for view in views.values()]
    unseen = unseen.after(images, spheres, scene, config)
    return dc.replace(found, unseen=unseen)


def without(sight: Sight, image: DepthImage, problem: str) -> Sight:
    """Notes that an image cannot be used.

    What its camera saw before stays, and from when nothing newer is known.

    Args:
        sight: What is known so far.
        image: The image.
        problem: Why it cannot be used.
    """
    view = sight.views.get(image.camera) or View.blind(image, problem)
    view = dc.replace(view, problem=problem)
    return dc.replace(sight, views={**sight.views, image.camera: view})


def _recent(
    view: View,
    tracks: Sequence[Track],
    image: DepthImage,
    scene: KnownScene,
    config: SightConfig,
) -> View:
    """What another camera saw, moved on to the time of a newer image.

    What the newer image looks through is no longer there.
    """
    points = view.points
    if not len(points):
        return view
    by_name = {track.name: track for track in tracks}
    moved = points.p_W.copy()
    for index, name in enumerate(view.names):
        if name in by_name:
            v, _ = by_name[name].edges.velocity(config.max_speed)
            moved[view.of == index] += (image.time - points.time) * v
    keep = ~_looked_through(moved, image, config)
    if image.time - view.seen > config.expiry:
        keep[:] = False
    points = dc.replace(
        points, p_W=moved[keep], depth=points.depth[keep], time=image.time
    )
    return dc.replace(view, points=points, of=view.of[keep])


def _looked_through(
    p_W: np.ndarray, image: DepthImage, config: SightConfig
) -> np.ndarray:
    """Whether an image shows something behind points, shape (n,) bool."""
    z, measured = image.depths_at(p_W)
    with np.errstate(invalid="ignore"):
        return (z > 0) & (measured > z + 2 * config.margin(z))


@dc.dataclass(frozen=True, eq=False)
class _Thing:
    """A cluster of the points of all cameras, and boxes around it."""

    shown: Stretches
    parts: tuple[RoundedBox, ...]
    pitch: float
    error: float
    deviation: float

    @staticmethod
    def of(
        shown: Stretches, depth: np.ndarray, pitch: float, config: SightConfig
    ) -> "_Thing":
        far = float(depth.max())
        return _Thing(
            shown,
            enclose(shown.face_W, shown.back_W, pitch),
            pitch,
            float(config.margin(far)),
            # How far outlines jump from image to image.
            0.3 * pitch + 0.7 * float(config.deviation(far)),
        )


def _tracked(
    sight: Sight,
    views: dict[str, View],
    image: DepthImage,
    spheres: Spheres,
    scene: KnownScene,
    config: SightConfig,
) -> Sight:
    """Sorts all points into things, and these into tracks."""
    groups = [view.points for view in views.values()]
    face_W = np.concatenate([group.p_W for group in groups])
    back_W = np.concatenate([_backs(views, name, config) for name in views])
    depth = np.concatenate([group.depth for group in groups])
    pitch = np.concatenate([group.pitch * group.depth for group in groups])
    link = max(config.link, 3 * float(np.median(pitch))) if len(pitch) else 0
    label = clustered(face_W, link)
    things: list[_Thing] = []
    of = np.full(len(face_W), -1)
    for cluster in range(label.max(initial=-1) + 1):
        members = np.flatnonzero(label == cluster)
        if len(members) < config.least_points:
            continue
        of[members] = len(things)
        shown = Stretches(
            face_W[members],
            back_W[members],
            np.full(len(members), image.time),
        )
        wide = float(pitch[members].max())
        things.append(_Thing.of(shown, depth[members], wide, config))
    known = partial(
        _hidden,
        things=things,
        views=views,
        spheres=spheres,
        scene=scene,
        config=config,
    )
    tracks, count = _assigned(sight, things, image.time, known, config)
    names = tuple(track.name for track in tracks[: len(things)])
    start, sorted_views = 0, {}
    for view, group in zip(views.items(), groups, strict=True):
        part = of[start : start + len(group)]
        sorted_views[view[0]] = dc.replace(view[1], of=part, names=names)
        start += len(group)
    return Sight(image.time, sorted_views, tuple(tracks), count)


def _backs(
    views: Mapping[str, View], camera: str, config: SightConfig
) -> np.ndarray:
    """How far the things whose faces a camera sees may reach behind them.

    That is `thickness` along the ray, or up to where another camera looks
    through.
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
                [_looked_through(behind, v.image, config) for v in others],
                axis=0,
            )
            share[free & (share >= step / _STEPS)] = (step - 0.5) / _STEPS
    return points.p_W + config.thickness * share[:, None] * rays_W


def _assigned(
    sight: Sight,
    things: Sequence[_Thing],
    time: float,
    hidden: Callable[[Track], Stretches],
    config: SightConfig,
) -> tuple[list[Track], int]:
    """Follows tracks, begins new ones and lets go of what has gone.

    Args:
        sight: What is known so far.
        things: What is seen now.
        time: When that is [s].
        hidden: Says what of a predicted track can be where no camera sees now.
        config: How things may move.

    Returns:
        The tracks, those of the things that are seen first, in their order;
        and the number of tracks so far.
    """
    old = [track.after(time, config) for track in sight.tracks]
    cost = np.full((len(old), len(things)), _NEVER)
    for i, track in enumerate(old):
        far = min(config.max_speed * (time - track.seen), 1.0)
        middle = track.edges.place.mean(axis=0)
        for j, thing in enumerate(things):
            near = Track.nearness(track.face_W, thing.shown.face_W)
            if near <= _NEAR + track.error + far:
                off = outline(thing.shown.face_W).mean(axis=0) - middle
                cost[i, j] = near + np.linalg.norm(off)
    matched = {
        int(j): old[i]
        for i, j in zip(*linear_sum_assignment(cost), strict=True)
        if cost[i, j] < _NEVER
    }
    tracks: list[Track] = []
    count = sight.count
    for j, thing in enumerate(things):
        if j in matched:
            track = matched[j]
            tracks.append(_followed(track, thing, hidden(track), config))
        else:
            count += 1
            tracks.append(_begun(f"seen {count}", thing, time, config))
    followed = {track.name for track in matched.values()}
    for track in old:
        if track.name not in followed and track.images >= TRUSTED:
            rest = hidden(track)
            if len(rest):
                tracks.append(dc.replace(track, hidden=rest))
    return tracks, count


def _begun(name: str, thing: _Thing, time: float, config: SightConfig) -> Track:
    place = outline(thing.shown.face_W)
    return Track(
        name,
        thing.parts,
        thing.shown,
        Stretches.none(),
        Edges.first(place, thing.deviation, config.max_speed, time),
        1,
        thing.pitch,
        thing.error,
        time,
        place,
    )


def _followed(
    track: Track, thing: _Thing, hidden: Stretches, config: SightConfig
) -> Track:
    place, time = outline(thing.shown.face_W), track.edges.time
    apart = np.abs(place - track.home).max()
    moved = apart > _STILL + 4 * thing.deviation
    return dc.replace(
        track,
        parts=thing.parts,
        shown=thing.shown,
        hidden=hidden,
        edges=track.edges.seen(place, thing.deviation, config.max_speed),
        images=track.images + 1,
        padding=thing.pitch,
        error=thing.error,
        still_since=time if moved else track.still_since,
        home=place if moved else track.home,
    )


def _hidden(
    track: Track,
    *,
    things: Sequence[_Thing],
    views: Mapping[str, View],
    spheres: Spheres,
    scene: KnownScene,
    config: SightConfig,
) -> Stretches:
    """What of a predicted track can be where no camera sees now.

    It is neither looked through, nor where something is seen in its place, nor
    within what is seen of this or of another thing, nor part of the map by now,
    nor too old. What is as near to the robot as is taken for the robot itself
    no image shows: whoever touches it is there still.
    """
    old, time = track.hidden, track.edges.time
    left = time - old.seen <= config.memory
    left &= scene.distances(old.face_W) > track.error
    beside = config.robot_margin + track.error - config.pose_error
    apart = np.linalg.norm(old.face_W[:, None] - spheres.p_WS, axis=2)
    shown = (apart > np.asarray(spheres.radius) + beside).all(axis=1)
    for view in views.values():
        if time - view.seen < config.expiry:
            z, measured = view.image.depths_at(old.face_W)
            with np.errstate(invalid="ignore"):
                through = (z > 0) & (measured > z - config.margin(z))
            left &= ~(through & shown)
    for thing in things:
        for part in thing.parts:
            left &= ~(shown & (part.distance(old.face_W) <= 0))
    if left.sum() < max(config.least_points, _LEFT * len(old)):
        return Stretches.none()
    found = np.flatnonzero(left)
    return old.select(found[:: len(found) // _MOST_HIDDEN + 1])
