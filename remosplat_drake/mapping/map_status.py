"""Computes the live map's `MapStatus` from events."""

import dataclasses as dc

from remosplat_drake.mapping.messages import (
    Building,
    Event,
    FrameAdded,
    FrameRefused,
    Idle,
    Note,
    Trouble,
)
from remosplat_drake.signals.map_status import MAKING, MapStatus
from remosplat_drake.signals.scene_map import SceneMap


def first_status(scene_map: SceneMap) -> MapStatus:
    """Returns the initial status, with the map in use."""
    return MapStatus(
        scene_map, text=_described(scene_map), frames=len(scene_map.frames)
    )


def noted(status: MapStatus, event: Event) -> MapStatus:
    """Returns the status after an event of the mapping process.

    The event of a new map does not change the status; `swapped` does.
    """
    match event:
        case FrameAdded(name, total):
            return dc.replace(
                status, text=f"{name} added", trouble="", frames=total
            )
        case Building(stage, done, total):
            text = f"{MAKING}{stage} {done}/{total}"
            return dc.replace(status, text=text)
        case Note(text):
            return dc.replace(status, text=text, trouble="")
        case FrameRefused(reason) | Trouble(reason):
            return dc.replace(status, trouble=reason)
        case Idle(frames=int(frames)):
            return dc.replace(status, frames=frames)
    return status


def swapped(status: MapStatus, scene_map: SceneMap) -> MapStatus:
    """Returns the status after a change of the map in use."""
    return dc.replace(
        status,
        scene_map=scene_map,
        text=_described(scene_map),
        trouble="",
        frames=len(scene_map.frames),
        swaps=status.swaps + 1,
    )


def _described(scene_map: SceneMap) -> str:
    """Describes a map in one line; the scenario's own map has no number."""
    if not scene_map.version:
        return scene_map.quality
    return f"version {scene_map.version}: {scene_map.quality}"
