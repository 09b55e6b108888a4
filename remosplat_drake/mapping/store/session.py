"""`Session`: the stored frames and maps of one teleoperation.

The documentation of `mapping.store` lists the files in a session's folder.
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
"""Names of files in a session's folder."""

FORMAT = "remosplat session 1"
"""Name of the format in `session.json`."""

_HALF_WRITTEN = (
    f".{SESSION_FILE}.*",
    f"frames/.{TRANSFORMS}.*",
    f"maps/.map_*{SUFFIX}.*",
)
"""Patterns of the files that `atomic_write` leaves behind if its process is
killed."""


@dc.dataclass(frozen=True)
class Version:
    """A session's record of one version of the map.

    Attributes:
        version: Number of the version, from 1 on; 0 is the scenario's map,
            which has no file.
        parent: Number of the previous version.
        file: Path of the map's file, relative to the session's folder.
        frames: Names of its frames.
        seconds: Time that its construction took [s].
    """

    version: int
    parent: int
    file: str
    frames: tuple[str, ...]
    seconds: float


class Session:
    """Stored frames and map versions, and the version that is in use.

    `create`, `open` and `open_to_write` return a session.

    Attributes:
        folder: The session's folder.
        frames: All frames that were taken.
        versions: All versions of the map, by their numbers.
        head: Number of the version in use; 0 is the scenario's own map.
        active: Names of the frames from which the next map will be made.
    """

    def __init__(
        self,
        folder: Path,
        head: int = 0,
        active: tuple[str, ...] = (),
        versions: tuple[Version, ...] = (),
    ):
        """Stores the results of `create` or `open`."""
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
            folder: The session's folder.
            scenario_text: Content of the session's scenario file (YAML).

        Raises:
            FileError: The folder is not empty, or cannot be made.
        """
        if folder.exists() and (not folder.is_dir() or any(folder.iterdir())):
            raise FileError(folder, "is not empty; choose a new folder")
        session = Session(folder)
        write_atomically(folder / SCENARIO_FILE, scenario_text)
        session._write(0, (), {})
        return session

    @staticmethod
    def open(folder: Path) -> "Session":
        """Opens a session for reading.

        Args:
            folder: The session's folder.

        Raises:
            RemoSplatError: The folder contains no session, or the session is
                damaged.
        """
        path = folder / SESSION_FILE
        document = parse_fields(read_text(path), str(path))
        if not document.has("format") or document.text("format") != FORMAT:
            raise FileError(path, f"is not a {FORMAT!r}")
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

        Partly written files of a killed process are removed.

        Args:
            folder: The session's folder.

        Raises:
            RemoSplatError: The folder contains no session, the session is
                damaged, or another process has opened it for writing.
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
        """File of the map in use; None for the scenario's own map."""
        if not self.head:
            return None
        return self.folder / self.versions[self.head].file

    @property
    def next_version(self) -> int:
        """Number that the next version of the map will have."""
        return max(self.versions, default=0) + 1

    def map_path(self, version: int) -> Path:
        """Returns the path of a version's file, which may not exist yet."""
        return self.folder / _map_file(version)

    def activate(self, name: str) -> None:
        """Adds a stored frame to the frames of the next map.

        Raises:
            FileError: `session.json` cannot be written.
        """
        self._write(self.head, (*self.active, name), self.versions)

    def refuse(self, names: set[str]) -> None:
        """Removes invalid or wrong frames from the session.

        Raises:
            FileError: A file cannot be written.
        """
        active = tuple(name for name in self.active if name not in names)
        self._write(self.head, active, self.versions)
        self.frames.leave_out(names)

    def record(self, version: Version, replaced: set[str]) -> None:
        """Records a new version of the map as the one in use.

        Args:
            version: The version; its file has been written.
            replaced: Names of frames that newer frames replace; later maps
                exclude them.
        """
        active = tuple(name for name in self.active if name not in replaced)
        versions = self.versions | {version.version: version}
        self._write(version.version, active, versions)

    @property
    def map_frames(self) -> tuple[str, ...]:
        """Names of the frames of the map in use."""
        return self._frames_of(self.head)

    @property
    def has_new_frames(self) -> bool:
        """Whether there are active frames that the map does not contain."""
        return bool(set(self.active) - set(self.map_frames))

    def leave_out_new_frames(self) -> None:
        """Restricts the frames of the next map to those of the map in use."""
        self._write(self.head, self.map_frames, self.versions)

    @property
    def parent(self) -> int:
        """Number of the version that preceded the one in use.

        Raises:
            RemoSplatError: The map in use is the scenario's own map.
        """
        if not self.head:
            raise RemoSplatError("there is nothing to undo")
        return self.versions[self.head].parent

    def undo(self) -> None:
        """Returns to the previous version and its frames.

        Raises:
            RemoSplatError: The map in use is the scenario's own map.
        """
        parent = self.parent
        self._write(parent, self._frames_of(parent), self.versions)

    def _frames_of(self, version: int) -> tuple[str, ...]:
        return self.versions[version].frames if version else ()

    def _write(
        self, head: int, active: tuple[str, ...], versions: dict[int, Version]
    ) -> None:
        """Changes the file and then this object, or neither of them."""
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
    """Reads a version, whose parent must be known."""
    number, parent = entry.whole("version", 1), entry.whole("parent")
    if number in known:
        raise entry.error("version", f"{number} appears twice")
    if parent and parent not in known:
        raise entry.error("parent", f"no previous map {parent} is listed")
    file = entry.text("file")
    if file != _map_file(number):
        raise entry.error("file", f"expected {_map_file(number)!r}")
    frames, seconds = entry.texts("frames"), entry.number("seconds", 0)
    return Version(number, parent, file, frames, seconds)


def _map_file(version: int) -> str:
    """Returns the path of a map within the session's folder."""
    return f"maps/map_{version:04d}{SUFFIX}"
