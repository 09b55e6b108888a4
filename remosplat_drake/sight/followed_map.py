"""`FollowedMap`: the map that a control loop goes by, for who looks beside it.

A thing that a camera sees is new as long as the control loop's map does not
show it. So whoever looks for what is new must not know more than that map, and
should know no less.
"""

from concurrent.futures import Future, ThreadPoolExecutor
from pathlib import Path

from remosplat_drake.base.errors import FileError, RemoSplatError
from remosplat_drake.hardware.wire.counting import (
    EXPIRY,
    CountingMap,
    decode_counting,
)
from remosplat_drake.mapping.store.map_file import open_map
from remosplat_drake.mapping.store.session import Session
from remosplat_drake.sight.known_scene import KnownScene, surface_points
from remosplat_drake.sight.sight_config import SightConfig


class FollowedMap:
    """Keeps to the version of a session's map that a control loop names.

    A newer one is read and prepared in a thread: until then what it shows
    remains new. If the loop goes back to one before, or falls silent, the
    scenario's own map counts at once, which shows less.

    Args:
        folder: The session's folder.
        own: What the scenario's own map shows.
        config: The settings of a `KnownScene`.

    Attributes:
        known: What is known to stand.
        version: Number of the session's version that shows it; 0 is the
            scenario's own.
        trouble: Why that is not what the loop goes by; empty where it is, or
            the version is being read.

    Raises:
        RemoSplatError: The folder holds no session.
    """

    def __init__(self, folder: Path, own: KnownScene, config: SightConfig):
        Session.open(folder)
        self._folder, self._own, self._config = folder, own, config
        self.known, self.version, self.trouble = own, 0, ""
        self._named, self._heard = CountingMap(0, own.revision), -EXPIRY
        self._reader = ThreadPoolExecutor(1, "map reader")
        self._asked: CountingMap | None = None
        self._reading: Future[KnownScene] | None = None

    def hear(self, data: bytes, now: float) -> None:
        """Takes in what the control loop says.

        Args:
            data: The packet.
            now: Our wall clock [s].

        Raises:
            BrokenMessage: It names no map.
        """
        named = decode_counting(data, now)
        if named is not None:
            self._named, self._heard = named, now

    def at(self, now: float) -> KnownScene:
        """Returns what is known to stand now.

        Args:
            now: Our wall clock [s].
        """
        named = self._named
        if now - self._heard > EXPIRY:
            named = CountingMap(0, self._own.revision)
        if named.version < self.version:
            self.known, self.version = self._own, 0
        if named.revision == self.known.revision:
            self._asked, self._reading, self.trouble = None, None, ""
        elif named != self._asked:
            self._ask(named)
        elif self._reading is not None and self._reading.done():
            self._take(self._reading, named.version)
        return self.known

    def _ask(self, named: CountingMap) -> None:
        """Begins to read another version."""
        self._asked, self._reading, self.trouble = named, None, ""
        if named.version:
            self._reading = self._reader.submit(self._read, named)
        else:
            self.trouble = "the control loop began with another map"

    def _take(self, reading: Future[KnownScene], version: int) -> None:
        """Takes over what has been read."""
        self._reading = None
        try:
            self.known, self.version = reading.result(), version
        except RemoSplatError as error:
            self.trouble = str(error)

    def _read(self, named: CountingMap) -> KnownScene:
        path = Session.open(self._folder).map_path(named.version)
        scene_map = open_map(path)
        if scene_map.field.revision != named.revision:
            raise FileError(path, "is not the map that the control loop has")
        surface_W = surface_points(scene_map.splat_W, None)
        known = KnownScene(scene_map.field, self._config, surface_W)
        known.prepare_as(self.known)
        return known
