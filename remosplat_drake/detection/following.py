"""Data association: matches detected objects with tracks."""

import dataclasses as dc
from collections.abc import Callable, Mapping, Sequence

import numpy as np
from scipy.optimize import linear_sum_assignment

from remosplat_drake.detection.detection_config import DetectionConfig
from remosplat_drake.detection.edge_filter import Edges, outline
from remosplat_drake.detection.kernels.near_any import near_any
from remosplat_drake.detection.known_scene import KnownScene
from remosplat_drake.detection.things import Thing
from remosplat_drake.detection.track import TRUSTED, Stretches, Track
from remosplat_drake.detection.view import View
from remosplat_drake.robot.sphere_model import Spheres

_LEFT = 0.05
"""If fewer than this fraction of an object's points may still be hidden, these
points are outliers.
"""

_NEAR = 0.05
"""A detected object matches a track if it is within this distance of the region
that the track's object can have reached [m].
"""

_NEVER = 1e6
"""Cost of an impossible match."""

_STILL = 0.03
"""An object counts as at rest while its displacement is at most this distance,
in addition to position errors [m].
"""

_AGAIN = 0.06
"""A hidden point may be this far from its prediction [m]. It counts as visible
again if a visible point is within this distance of the prediction.
"""

_MOST_HIDDEN = 100
"""At most this many hidden points of an object are stored."""


def follow(
    tracks: Sequence[Track],
    count: int,
    things: Sequence[Thing],
    time: float,
    hidden: Callable[..., Stretches],
    config: DetectionConfig,
) -> tuple[tuple[Track, ...], int]:
    """Updates tracks with detected objects; starts and removes tracks.

    Args:
        tracks: The tracks so far.
        count: Number of tracks that were started so far, for the names of new
            tracks.
        things: The objects that are visible now.
        time: The present time [s].
        hidden: Function of a predicted track, and of whether any part of it is
            visible (`is_seen`). It returns the part of the track that may be
            hidden from all cameras now.
        config: Settings, with bounds on the motion of objects.

    Returns:
        The tracks, and the number of tracks that were started so far. The
        tracks of visible objects come first, in the order of the objects.
    """
    old = [track.after(time, config) for track in tracks]
    cost = _costs(old, things, time, config)
    matched = {
        int(j): old[i]
        for i, j in zip(*linear_sum_assignment(cost), strict=True)
        if cost[i, j] < _NEVER
    }
    new: list[Track] = []
    for j, thing in enumerate(things):
        if j in matched:
            track = matched[j]
            rest = hidden(track, is_seen=True)
            new.append(_followed(track, thing, rest, config))
        else:
            count += 1
            # A part that separates from an object was visible before.
            whole = np.flatnonzero(cost[:, j] < _NEVER)
            images = 1 + max((old[i].images for i in whole), default=0)
            new.append(_begun(f"seen {count}", thing, images, time, config))
    followed = {track.name for track in matched.values()}
    for track in old:
        if track.name not in followed and track.images >= TRUSTED:
            rest = hidden(track, is_seen=False)
            if len(rest):
                new.append(dc.replace(track, hidden=rest))
    return tuple(new), count


def _costs(
    old: Sequence[Track],
    things: Sequence[Thing],
    time: float,
    config: DetectionConfig,
) -> np.ndarray:
    """Returns the costs of matching objects with tracks, at most `_NEVER`."""
    cost = np.full((len(old), len(things)), _NEVER)
    for i, track in enumerate(old):
        far = min(config.max_speed * (time - track.seen), 1.0)
        middle = track.edges.place.mean(axis=0)
        for j, thing in enumerate(things):
            near = Track.nearness(track.face_W, thing.shown.face_W)
            if near <= _NEAR + track.error + far:
                off = outline(thing.shown.face_W).mean(axis=0) - middle
                cost[i, j] = near + np.linalg.norm(off)
    return cost


def _begun(
    name: str, thing: Thing, images: int, time: float, config: DetectionConfig
) -> Track:
    place = outline(thing.shown.face_W)
    return Track(
        name,
        thing.parts,
        thing.shown,
        Stretches.none(),
        Edges.first(place, thing.deviation, config.max_speed, time),
        images,
        thing.pitch,
        thing.error,
        time,
        place,
    )


def _followed(
    track: Track, thing: Thing, hidden: Stretches, config: DetectionConfig
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


def still_hidden(
    track: Track,
    *,
    is_seen: bool,
    things: Sequence[Thing],
    views: Mapping[str, View],
    spheres: Spheres,
    scene: KnownScene,
    config: DetectionConfig,
) -> Stretches:
    """Returns the part of a predicted track that may be hidden now.

    A point in open space is removed in four cases: a camera shows free space at
    it, a camera shows another surface at its position, it is inside a visible
    part of any object, or it is too old. Close to the robot or to surfaces of
    the map, images do not distinguish an object from these. So points there are
    kept as long as other parts of the track are visible, until they are visible
    again. This is necessary if a person touches the robot.

    Args:
        track: A track, predicted to the time of the newest image.
        is_seen: Whether any part of the track is visible now.
        things: The objects that are visible now.
        views: The view of each camera, by name.
        spheres: The robot's spheres in W.
        scene: The map.
        config: Settings, with errors, margins and the time for which objects
            are remembered.
    """
    old, time = track.hidden, track.edges.time
    blurred = _blurred(track, spheres, scene, config)
    if is_seen:
        old = dc.replace(old, seen=np.where(blurred, time, old.seen))
    left = time - old.seen <= config.memory
    if track.is_still(config):
        # The object has settled, so the map may already contain it.
        left &= scene.distances(old.face_W) > track.error
    hidden, clear = np.flatnonzero(blurred), np.flatnonzero(left & ~blurred)
    gone = np.zeros(len(clear), bool)
    for view in views.values():
        if time - view.seen < config.expiry:
            gone |= view.observes(old.face_W[clear], spheres, config)
    shows_again = np.zeros(len(hidden), bool)
    for thing in things:
        gone |= thing.distances(old.face_W[clear]) <= 0
        seen_W = thing.shown.face_W
        again = np.full(len(seen_W), _AGAIN)
        shows_again |= near_any(old.face_W[hidden], seen_W, again)
    left[clear[gone]] = left[hidden[shows_again]] = False
    few = left.sum() < max(config.least_points, _LEFT * len(old))
    if few and not blurred[left].any():
        return Stretches.none()
    found = np.flatnonzero(left)
    return old.select(found[:: len(found) // _MOST_HIDDEN + 1])


def _blurred(
    track: Track, spheres: Spheres, scene: KnownScene, config: DetectionConfig
) -> np.ndarray:
    """Returns a mask of hidden points that may be next to robot or map."""
    p_W, off = track.hidden.face_W, track.error + _AGAIN
    beside = config.beside(track.error) + _AGAIN
    near = near_any(p_W, spheres.p_WS, np.asarray(spheres.radius) + beside)
    if not track.is_still(config):
        near |= scene.distances(p_W) <= off
    return near
