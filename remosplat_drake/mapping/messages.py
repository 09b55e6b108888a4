"""Messages between control process and mapping process.

The control process sends requests, the mapping process events. All messages are
small, so that neither process waits for the other. Images and maps are passed
as files of the session.
"""

import dataclasses as dc
from pathlib import Path

import numpy as np

from remosplat_drake.scene.mover import Movers
from remosplat_drake.scene.objects.placed_object import PlacedObject
from remosplat_drake.scene.primitive_scene import PrimitiveScene
from remosplat_drake.signals.base_correction import BaseCorrection


@dc.dataclass(frozen=True, eq=False)
class AddFrame:
    """Request: take a picture now.

    Attributes:
        q: The robot's configuration, shape (n_q,).
        time: Time now, by the diagram's clock [s].
        passing: Movers that must not be in the map.
        objects: Known objects, which must not be in the map either.
    """

    q: np.ndarray
    time: float
    passing: Movers = dc.field(default_factory=lambda: Movers(0.0))
    objects: tuple[PlacedObject, ...] = ()


@dc.dataclass(frozen=True, eq=False)
class Track:
    """Request: localise the base; the picture is not kept.

    Attributes:
        q: The robot's configuration, shape (n_q,).
        time: Time now, by the diagram's clock [s].
        passing: Movers, which must not be used for localisation.
    """

    q: np.ndarray
    time: float
    passing: Movers = dc.field(default_factory=lambda: Movers(0.0))


@dc.dataclass(frozen=True)
class Build:
    """Request: build a map from the session's active frames.

    Attributes:
        effort: "quick" or "full".
    """

    effort: str = "quick"


@dc.dataclass(frozen=True)
class Undo:
    """Request: discard frames that are in no map yet; if none, the last map."""


@dc.dataclass(frozen=True)
class Save:
    """Request: write the map's splat as a PLY file for other programs."""


@dc.dataclass(frozen=True, eq=False)
class ShowScene:
    """Request: change the scene of a simulated camera.

    Attributes:
        scene: The solids of the new scene.
    """

    scene: PrimitiveScene


@dc.dataclass(frozen=True)
class Close:
    """Request: end the process; a map under construction is dropped."""


@dc.dataclass(frozen=True)
class FrameAdded:
    """Event: a frame has been added to the session.

    Attributes:
        name: Name of the frame.
        total: Number of frames from which the next map will be made.
    """

    name: str
    total: int


@dc.dataclass(frozen=True)
class FrameRefused:
    """Event: a frame cannot be used.

    Attributes:
        reason: Reason why the frame cannot be used, for display.
    """

    reason: str


@dc.dataclass(frozen=True, eq=False)
class Located:
    """Event: pose of the base in the newest announced map.

    Attributes:
        correction: Pose of the base's odometry in the map.
    """

    correction: BaseCorrection


@dc.dataclass(frozen=True)
class Building:
    """Event: progress of the map under construction.

    Attributes:
        stage: Name of the stage, for display.
        done: Number of the stage's steps that are done.
        total: Number of the stage's steps.
    """

    stage: str
    done: int
    total: int


@dc.dataclass(frozen=True)
class MapReady:
    """Event: a new map, or an older one after an undo, shall take effect.

    Attributes:
        path: The map's file; None for the map that the scenario began with.
        version: Number of the map.
        seal: Seal with which the control process opens the file without checks,
            since the mapping process has written it.
        correction: Pose of the base's odometry in this map; None if it is not
            corrected.
    """

    path: Path | None
    version: int
    seal: str = ""
    correction: BaseCorrection | None = None


@dc.dataclass(frozen=True)
class Note:
    """Event: a report of success, for display.

    Attributes:
        text: Description, for display.
    """

    text: str


@dc.dataclass(frozen=True)
class Trouble:
    """Event: a report of a failure; the process continues.

    Attributes:
        text: Description of the problem, for display.
    """

    text: str


@dc.dataclass(frozen=True)
class Idle:
    """Event: the process is idle.

    Attributes:
        answered: Number of requests that were answered since the process
            started.
        frames: Number of frames from which the next map will be made; None if
            it is unknown.
    """

    answered: int
    frames: int | None = None


Request = AddFrame | Track | Build | Undo | Save | ShowScene | Close
Event = (
    FrameAdded
    | FrameRefused
    | Located
    | Building
    | MapReady
    | Note
    | Trouble
    | Idle
)
