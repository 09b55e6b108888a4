"""Messages between control process and mapping process.

The control process sends requests, and the mapping process sends events. All
messages are small, so that neither process waits for the other. Images and maps
are passed in files of the session.
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
        objects: Known objects, which must not be in the map, either.
    """

    q: np.ndarray
    time: float
    passing: Movers = dc.field(default_factory=lambda: Movers(0.0))
    objects: tuple[PlacedObject, ...] = ()


@dc.dataclass(frozen=True, eq=False)
class Track:
    """Request: localise the base by a picture that is not stored.

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
    """Request: discard the frames that are in no map, or else the last map."""


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
    """Request: end the process, and abandon a map under construction."""


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
    """Event: pose of the base's odometry in the newest announced map.

    Attributes:
        correction: Pose of the base's odometry in the map.
    """

    correction: BaseCorrection


@dc.dataclass(frozen=True)
class Building:
    """Event: progress of the map under construction.

    Attributes:
        stage: Name of the stage, for display.
        done: Number of completed steps of the stage.
        total: Number of all steps of the stage.
    """

    stage: str
    done: int
    total: int


@dc.dataclass(frozen=True)
class MapReady:
    """Event: a map is ready, a new one or an earlier one after an undo.

    Attributes:
        path: The map's file; None for the scenario's own map.
        version: Number of the map.
        seal: Seal with which the control process opens the file without checks,
            since the mapping process has written it.
        correction: Pose of the base's odometry in this map; None if the
            odometry is not corrected.
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
    """Event: the process has answered all requests.

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
