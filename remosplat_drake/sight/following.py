"""Data association: which things are those that were followed before."""

import dataclasses as dc
from collections.abc import Callable, Mapping, Sequence

import numpy as np
from scipy.optimize import linear_sum_assignment

from remosplat_drake.robot.sphere_model import Spheres
from remosplat_drake.sight.edge_filter import Edges, outline
from remosplat_drake.sight.kernels.near_any import near_any
from remosplat_drake.sight.known_scene import KnownScene
from remosplat_drake.sight.sight_config import SightConfig
from remosplat_drake.sight.things import Thing
from remosplat_drake.sight.track import TRUSTED, Stretches, Track
from remosplat_drake.sight.view import View

_LEFT = 0.05
"""Less than this share of a thing is no more than stray points."""

_NEAR = 0.05
"""A thing is one seen before if it is so near to where that can be [m]."""

_NEVER = 1e6
"""Cost of taking a thing for one that it cannot be."""

_STILL = 0.03
"""A thing that stays put stays within this distance, and errors [m]."""

_AGAIN = 0.06
"""A point shows itself again where one is seen so near to it, and may itself
be so far from where it is predicted to be [m]."""

_MOST_HIDDEN = 100
"""Most points that are remembered of a thing."""


def follow(
    tracks: Sequence[Track],
    count: int,
    things: Sequence[Thing],
    time: float,
    hidden: Callable[..., Stretches],
    config: SightConfig,
) -> tuple[tuple[Track, ...], int]:
    """Follows tracks, begins new ones and lets go of what has gone.

    Args:
        tracks: The things that were followed so far.
        count: Number of tracks so far, for the names of new ones.
        things: What is seen now.
        time: When that is [s].
        hidden: Says what of a predicted track, of which something `is_seen` or
            nothing, can be where no camera tells it now.
        config: How things may move.

    Returns:
        The tracks, those of the things that are seen first, in their order;
        and the number of tracks so far.
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
            # What has come off a thing was seen before, as a part of it.
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
    config: SightConfig,
) -> np.ndarray:
    """How little each thing is like each predicted track, `_NEVER` at most."""
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
    name: str, thing: Thing, images: int, time: float, config: SightConfig
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
    track: Track, thing: Thing, hidden: Stretches, config: SightConfig
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
    config: SightConfig,
) -> Stretches:
    """Tells what of a predicted track can be where no camera tells it now.

    In open space it is neither looked through, nor where something is seen in
    its place, nor within what is seen of this or of another thing, nor too old.
    Right beside the robot or the map no image tells it from them: what has got
    there is there still, as long as the rest of the track is seen, until it
    shows itself again. Whoever touches the robot does.

    Args:
        track: A track, predicted to the time of the newest image.
        is_seen: Whether something of it is seen now.
        things: What is seen now.
        views: What each camera sees, by its name.
        spheres: The robot's spheres in W.
        scene: What the map shows.
        config: Errors, margins and for how long things are remembered.
    """
    old, time = track.hidden, track.edges.time
    blurred = _blurred(track, spheres, scene, config)
    if is_seen:
        old = dc.replace(old, seen=np.where(blurred, time, old.seen))
    left = time - old.seen <= config.memory
    if track.is_still(config):
        # It has settled: by now it may be what the map shows.
        left &= scene.distances(old.face_W) > track.error
    hidden, clear = np.flatnonzero(blurred), np.flatnonzero(left & ~blurred)
    gone = np.zeros(len(clear), bool)
    for view in views.values():
        if time - view.seen < config.expiry:
            gone |= view.tells(old.face_W[clear], spheres, config)
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
    track: Track, spheres: Spheres, scene: KnownScene, config: SightConfig
) -> np.ndarray:
    """Whether what is hidden may be too near to robot or map to be told."""
    p_W, off = track.hidden.face_W, track.error + _AGAIN
    beside = config.beside(track.error) + _AGAIN
    near = near_any(p_W, spheres.p_WS, np.asarray(spheres.radius) + beside)
    if not track.is_still(config):
        near |= scene.distances(p_W) <= off
    return near
