"""Data association: which things are those that were followed before."""

import dataclasses as dc
from collections.abc import Callable, Mapping, Sequence

import numpy as np
from scipy.optimize import linear_sum_assignment

from remosplat_drake.robot.sphere_model import Spheres
from remosplat_drake.sight.edge_filter import Edges, outline
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

_MOST_HIDDEN = 100
"""Most points that are remembered of a thing."""


def follow(
    tracks: Sequence[Track],
    count: int,
    things: Sequence[Thing],
    time: float,
    hidden: Callable[[Track], Stretches],
    config: SightConfig,
) -> tuple[tuple[Track, ...], int]:
    """Follows tracks, begins new ones and lets go of what has gone.

    Args:
        tracks: The things that were followed so far.
        count: Number of tracks so far, for the names of new ones.
        things: What is seen now.
        time: When that is [s].
        hidden: Says what of a predicted track can be where no camera sees now.
        config: How things may move.

    Returns:
        The tracks, those of the things that are seen first, in their order;
        and the number of tracks so far.
    """
    old = [track.after(time, config) for track in tracks]
    matched = _matched(old, things, time, config)
    new: list[Track] = []
    for j, thing in enumerate(things):
        if j in matched:
            track = matched[j]
            new.append(_followed(track, thing, hidden(track), config))
        else:
            count += 1
            new.append(_begun(f"seen {count}", thing, time, config))
    followed = {track.name for track in matched.values()}
    for track in old:
        if track.name not in followed and track.images >= TRUSTED:
            rest = hidden(track)
            if len(rest):
                new.append(dc.replace(track, hidden=rest))
    return tuple(new), count


def _matched(
    old: Sequence[Track],
    things: Sequence[Thing],
    time: float,
    config: SightConfig,
) -> dict[int, Track]:
    """Finds the predicted track of each thing that can be one seen before."""
    cost = np.full((len(old), len(things)), _NEVER)
    for i, track in enumerate(old):
        far = min(config.max_speed * (time - track.seen), 1.0)
        middle = track.edges.place.mean(axis=0)
        for j, thing in enumerate(things):
            near = Track.nearness(track.face_W, thing.shown.face_W)
            if near <= _NEAR + track.error + far:
                off = outline(thing.shown.face_W).mean(axis=0) - middle
                cost[i, j] = near + np.linalg.norm(off)
    return {
        int(j): old[i]
        for i, j in zip(*linear_sum_assignment(cost), strict=True)
        if cost[i, j] < _NEVER
    }


def _begun(name: str, thing: Thing, time: float, config: SightConfig) -> Track:
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
    things: Sequence[Thing],
    views: Mapping[str, View],
    spheres: Spheres,
    scene: KnownScene,
    config: SightConfig,
) -> Stretches:
    """Tells what of a predicted track can be where no camera sees now.

    It is neither looked through, nor where something is seen in its place, nor
    within what is seen of this or of another thing, nor part of the map by now,
    nor too old. What is as near to the robot as is taken for the robot itself
    no image shows: whoever touches it is there still.

    Args:
        track: A track, predicted to the time of the newest image.
        things: What is seen now.
        views: What each camera sees, by its name.
        spheres: The robot's spheres in W.
        scene: What the map shows.
        config: Errors, margins and for how long things are remembered.
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
