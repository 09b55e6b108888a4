"""What control process and mapping process tell each other.

Requests go one way, events the other. All are small, so that neither side
waits for the other: images and maps travel as files of the session.
"""

import dataclasses as dc
from pathlib import Path

import numpy as np

from remosplat_drake.scene.primitive_scene import PrimitiveScene


@dc.dataclass(frozen=True, eq=False)
class AddFrame:
    """Take a picture now.

    Attributes:
        q: The robot's configuration, shape (n_q,).
        time: Of the diagram's clock [s].
    """

    q: np.ndarray
    time: float


@dc.dataclass(frozen=True)
class Build:
    """Make a map of the frames.

    Attributes:
        effort: "quick" or "full".
    """

    effort: str = "quick"


@dc.dataclass(frozen=True)
class Undo:
    """Leave out the frames that no map has yet, else the latest map."""


@dc.dataclass(frozen=True)
class Save:
    """Write the map's splat as a file that other programs read."""


@dc.dataclass(frozen=True, eq=False)
class ShowScene:
    """Change what a simulated camera sees.

    Attributes:
        scene: What there is from now on.
    """

    scene: PrimitiveScene


@dc.dataclass(frozen=True)
class Close:
    """Leave; what is being made is dropped."""


@dc.dataclass(frozen=True)
class FrameAdded:
    """A frame is in the session.

    Attributes:
        name: The frame's.
        total: Frames that the next map is made of.
    """

    name: str
    total: int


@dc.dataclass(frozen=True)
class FrameRefused:
    """A frame cannot be used.

    Attributes:
        reason: Why, for people.
    """

    reason: str


@dc.dataclass(frozen=True)
class Building:
    """How far the map that is being made has come.

    Attributes:
        stage: What is being done, for people.
        done: Steps of it that are done.
        total: Its steps.
    """

    stage: str
    done: int
    total: int


@dc.dataclass(frozen=True)
class MapReady:
    """A map to change to: a new one, or after an undo an older one.

    Attributes:
        path: Its file; None for the map that the scenario began with.
        version: Its number.
        seal: That of the file, which the mapping process itself has written.
    """

    path: Path | None
    version: int
    seal: str = ""


@dc.dataclass(frozen=True)
class Note:
    """Something went well.

    Attributes:
        text: What, for people.
    """

    text: str


@dc.dataclass(frozen=True)
class Trouble:
    """Something went wrong; the process goes on.

    Attributes:
        text: What, for people.
    """

    text: str


@dc.dataclass(frozen=True)
class Idle:
    """Nothing is left to do.

    Attributes:
        answered: Requests so far, since the process started.
        frames: Of which the next map is made; None where nobody knows.
    """

    answered: int
    frames: int | None = None


Request = AddFrame | Build | Undo | Save | ShowScene | Close
Event = FrameAdded | FrameRefused | Building | MapReady | Note | Trouble | Idle
