"""`Session`: a folder with all that a teleoperation has gathered.

    session.json          this file: the versions of the map
    scenario.yaml         the scenario that it belongs to
    frames/               what the camera saw; see `FrameStore`
    maps/map_0001.rsmap   the versions
    runs/0001/            what the robot did, written by the control process

Only the mapping process writes (but for `runs`), and each file at once.
"""

import dataclasses as dc
import fcntl
import json
from pathlib import Path
from typing import IO

from remosplat_drake.base.atomic_file import write_atomically
from remosplat_drake.base.errors import FileError, RemoSplatError
from remosplat_drake.base.json_fields import JsonFields, parse_fields
from remosplat_drake.capture.readers.nerfstudio import TRANSFORMS
from remosplat_drake.capture.readers.text_files import read_text
from remosplat_drake.mapping.store.frame_store import FrameStore
from remosplat_drake.mapping.store.map_file import SUFFIX

SESSION_FILE, SCENARIO_FILE = "session.json", "scenario.yaml"
LOCK_FILE = "session.lock"
FORMAT = "remosplat session 1"

_HALF_WRITTEN = (
    f".{SESSION_FILE}.*",
    f"frames/.{TRANSFORMS}.*",
    f"maps/.map_*{SUFFIX}.*",
)
"""What `atomic_write` leaves when it is killed."""


@dc.dataclass(frozen=True)
class Version:
    """A map of the session.

    Attributes:
        version: Its number; 0 is the scenario's own, which has no file.
        parent: The version that it was made after.
        file: Within the session's folder.
        frames: Names of the frames in it.
        seconds: How long it took to be made [s].
    """

    version: int
    parent: int
    file: str
    frames: tuple[str, ...]
    seconds: float


class Session:
    """Frames and maps of one place, and which of them count now.

    Attributes:
        folder: Of the session.
        frames: All that were taken.
        versions: All maps, by number.
        head: The version that counts; 0 is the scenario's own.
        active: Names of the frames that the next map is made of.
    """

    def __init__(
        self,
        folder: Path,
        head: int = 0,
        active: tuple[str, ...] = (),
        versions: tuple[Version, ...] = (),
    ):
        """Use `create` or `open`."""
        self.folder = folder
        self._lock: IO | None = None
        self.frames = FrameStore(folder / "frames")
        self.head = head
        self.active = active
        self.versions = {version.version: version for version in versions}

    @staticmethod
    def create(folder: Path, scenario_text: str) -> "Session":
        """Makes a session in a new or empty folder.

        Args:
            folder: The folder.
            scenario_text: The file of its scenario.

        Raises:
            FileError: The folder holds something, or cannot be made.
        """
        if folder.exists() and (not folder.is_dir() or any(folder.iterdir())):
            raise FileError(folder, "exists; a new session needs a new folder")
        session = Session(folder)
        write_atomically(folder / SCENARIO_FILE, scenario_text)
        session._write(0, (), {})
        return session

    @staticmethod
    def open(folder: Path) -> "Session":
        """Reads a session.

        Raises:
            RemoSplatError: The folder holds none, or a damaged one.
        """
        path = folder / SESSION_FILE
        document = parse_fields(read_text(path), str(path))
        if not document.has("format") or document.text("format") != FORMAT:
            raise FileError(path, f"is no {FORMAT!r}")
        versions = []
        for entry in document.inners("versions"):
            versions.append(_version(entry, {v.version for v in versions}))
        head = document.whole("head")
        if head and head not in [version.version for version in versions]:
            raise document.error("head", f"there is no map {head}")
        return Session(folder, head, document.texts("active"), tuple(versions))

    @staticmethod
    def open_to_write(folder: Path) -> "Session":
        """Opens a session for the only process that may change it.

        What another one had half written when it was killed is removed.

        Raises:
            RemoSplatError: As `open`; or another process has it open.
        """
        session = Session.open(folder)
        try:
            session._lock = lock = (folder / LOCK_FILE).open("w")
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError as error:
            problem = f"is in use, or cannot be written: {error.strerror}"
            raise FileError(folder, problem) from error
        for pattern in _HALF_WRITTEN:
            for leftover in folder.glob(pattern):
                leftover.unlink(missing_ok=True)
        return session

    @property
    def head_map(self) -> Path | None:
        """The file of the map that counts; None for the scenario's own."""
        if not self.head:
            return None
        return self.folder / self.versions[self.head].file

    @property
    def next_version(self) -> int:
        """The number of the next map."""
        return max(self.versions, default=0) + 1

    def map_path(self, version: int) -> Path:
        """Where a map goes."""
        return self.folder / _map_file(version)

    def activate(self, name: str) -> None:
        """Lets a frame of the store count for the next map."""
        self._write(self.head, (*self.active, name), self.versions)

    def refuse(self, names: set[str]) -> None:
        """Lets frames count no more, here or for other programs."""
        active = tuple(name for name in self.active if name not in names)
        self._write(self.head, active, self.versions)
        self.frames.leave_out(names)

    def record(self, version: Version, replaced: set[str]) -> None:
        """Notes a new map, whose file is there, as the one that counts.

        Args:
            version: The map.
            replaced: Frames that newer ones stand for.
        """
        active = tuple(name for name in self.active if name not in replaced)
        versions = self.versions | {version.version: version}
        self._write(version.version, active, versions)

    @property
    def map_frames(self) -> tuple[str, ...]:
        """Names of the frames in the map that counts."""
        return self._frames_of(self.head)

    @property
    def has_new_frames(self) -> bool:
        """Whether there are frames that the map does not hold."""
        return bool(set(self.active) - set(self.map_frames))

    def leave_out_new_frames(self) -> None:
        """Goes back to the frames that are in the map."""
        self._write(self.head, self.map_frames, self.versions)

    @property
    def parent(self) -> int:
        """The version that the map which counts was made after.

        Raises:
            RemoSplatError: There is none.
        """
        if not self.head:
            raise RemoSplatError("there is nothing to undo")
        return self.versions[self.head].parent

    def undo(self) -> None:
        """Goes back to the map before, and to its frames.

        Raises:
            RemoSplatError: There is none.
        """
        parent = self.parent
        self._write(parent, self._frames_of(parent), self.versions)

    def _frames_of(self, version: int) -> tuple[str, ...]:
        return self.versions[version].frames if version else ()

    def _write(
        self, head: int, active: tuple[str, ...], versions: dict[int, Version]
    ) -> None:
        """Changes the file, then this object; or neither."""
        document = {
            "format": FORMAT,
            "head": head,
            "active": active,
            "versions": [dc.asdict(version) for version in versions.values()],
        }
        text = json.dumps(document, indent=1) + "\n"
        write_atomically(self.folder / SESSION_FILE, text)
        self.head, self.active, self.versions = head, active, versions


def _version(entry: JsonFields, known: set[int]) -> Version:
    """A map that follows one of those that are known, or the scenario's own."""
    number, parent = entry.whole("version", 1), entry.whole("parent")
    if number in known:
        raise entry.error("version", f"{number} appears twice")
    if parent and parent not in known:
        raise entry.error("parent", f"there is no map {parent} before")
    file = entry.text("file")
    if file != _map_file(number):
        raise entry.error("file", f"expected {_map_file(number)!r}")
    frames, seconds = entry.texts("frames"), entry.number("seconds", 0)
    return Version(number, parent, file, frames, seconds)


def _map_file(version: int) -> str:
    """Where a map is, within the session's folder."""
    return f"maps/map_{version:04d}{SUFFIX}"
