"""`LiveMapMemory`: the state of the live map, and functions that change it."""

import dataclasses as dc

import numpy as np

from remosplat_drake.mapping.map_status import swapped
from remosplat_drake.mapping.messages import (
    AddFrame,
    Build,
    Request,
    Save,
    ShowScene,
    Undo,
)
from remosplat_drake.scene.mover import Movers
from remosplat_drake.scene.objects.placed_object import PlacedObject
from remosplat_drake.signals.base_correction import BaseCorrection
from remosplat_drake.signals.map_requests import MapRequests
from remosplat_drake.signals.map_status import MapStatus
from remosplat_drake.signals.scene_map import SceneMap


@dc.dataclass(frozen=True, eq=False)
class LiveMapMemory:
    """State of the live map between two ticks.

    It is immutable, so a deep copy is the object itself.

    Attributes:
        status: The status that is displayed to operators.
        known: The requests that have been sent to the mapping process.
        due: Answers that take effect after a fixed latency. Each is a triple of
            the time at which it takes effect [s], the number of requests that
            must be answered by then, and whether the answer is a map.
        correction: The newest correction of the base's odometry.
        tracked: Time of the latest localisation of the base [s].
        candidate: A map that has not taken effect yet, and the pose of the
            odometry in it; None if there is no such map.
        hold: Reason why the candidate must not take effect and the robot is
            stopped; empty if there is none.
    """

    status: MapStatus
    known: MapRequests = dc.field(default_factory=MapRequests)
    due: tuple[tuple[float, int, bool], ...] = ()
    correction: BaseCorrection = dc.field(default_factory=BaseCorrection)
    tracked: float = -np.inf
    candidate: tuple[SceneMap, BaseCorrection] | None = None
    hold: str = ""

    def __deepcopy__(self, memo) -> "LiveMapMemory":
        return self


def located(memory: LiveMapMemory, correction: BaseCorrection) -> LiveMapMemory:
    """Records the pose of the odometry in the newest map.

    Until the newest map takes effect, the pose of the odometry in the map in
    use does not change.

    Args:
        memory: The previous state.
        correction: Pose of the odometry in the newest map.
    """
    if memory.candidate is not None:
        scene_map = memory.candidate[0]
        correction = dc.replace(correction, version=scene_map.version)
        return dc.replace(memory, candidate=(scene_map, correction))
    version = memory.status.scene_map.version
    correction = dc.replace(correction, version=version)
    return dc.replace(memory, correction=correction)


def taken_back(memory: LiveMapMemory) -> LiveMapMemory:
    """Discards the map that waits to take effect, and the reason for a stop.

    Args:
        memory: The previous state.
    """
    return dc.replace(memory, candidate=None, hold="")


def changed(memory: LiveMapMemory, objection: str) -> LiveMapMemory:
    """Applies the waiting map and its pose, or records an objection to it.

    Args:
        memory: The previous state.
        objection: Reason why the map must not take effect; empty if it may.
    """
    if memory.candidate is None:
        return memory
    if objection:
        status = dc.replace(memory.status, trouble=objection)
        return dc.replace(memory, status=status, hold=objection)
    scene_map, correction = memory.candidate
    return dc.replace(
        memory,
        status=swapped(memory.status, scene_map),
        correction=correction,
        candidate=None,
        hold="",
    )


def news(
    known: MapRequests,
    wanted: MapRequests,
    q: np.ndarray,
    time: float,
    passing: Movers,
    objects: tuple[PlacedObject, ...] = (),
) -> list[Request]:
    """Converts new requests to messages, in the order of their execution.

    Args:
        known: The requests that were already sent.
        wanted: All requests of the operators so far.
        q: The robot's configuration now, shape (n_q,).
        time: Time now, by the diagram's clock [s].
        passing: Movers that must not be in the map.
        objects: Known objects, which must not be in the map, either.
    """
    requests: list[Request] = []
    if wanted.scene is not None and wanted.scene is not known.scene:
        requests.append(ShowScene(wanted.scene))
    frames = wanted.frames - known.frames
    requests += [AddFrame(np.array(q), time, passing, objects)] * frames
    if frames > wanted.unfinished - known.unfinished:
        requests.append(Build("quick"))
    if wanted.refines > known.refines:
        requests.append(Build("full"))
    requests += [Undo()] * (wanted.undos - known.undos)
    if wanted.saves > known.saves:
        requests.append(Save())
    return requests
