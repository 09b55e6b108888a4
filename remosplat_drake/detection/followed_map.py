"""`FollowedMap`: the map that detection uses, that of a control loop.

An object is new as long as the control loop's map does not contain it. So the
map that detection uses must not contain more than the control loop's map, and
should not contain less.
"""

from concurrent.futures import Future, ThreadPoolExecutor
from pathlib import Path

from remosplat_drake.base.errors import FileError, RemoSplatError
from remosplat_drake.detection.detection_config import DetectionConfig
from remosplat_drake.detection.known_scene import KnownScene, surface_points
from remosplat_drake.hardware.wire.counting import (
    EXPIRY,
    CountingMap,
    decode_counting,
)
from remosplat_drake.mapping.store.map_file import open_map
from remosplat_drake.mapping.store.session import Session


class FollowedMap:
    """Uses the version of a session's map that a control loop announces.

    A newer version is read and prepared in a thread. Until it is ready, the
    objects that it adds count as new. If the loop returns to an earlier
    version, or stops sending, the scenario's own map is used at once, which
    contains less.

    Args:
        folder: The session's folder.
        own: The scenario's own map.
        config: The settings of a `KnownScene`.

    Attributes:
        known: The map in use.
        version: Version number of this map in the session; 0 is the scenario's
            own map.
        trouble: Reason why the map in use is not the loop's. It is empty if it
            is the loop's, or while the loop's version is being read.

    Raises:
        RemoSplatError: The folder contains no session.
    """

    def __init__(self, folder: Path, own: KnownScene, config: DetectionConfig):
        Session.open(folder)
        self._folder, self._own, self._config = folder, own, config
        self.known, self.version, self.trouble = own, 0, ""
        self._named, self._heard = CountingMap(0, own.revision), -EXPIRY
        self._reader = ThreadPoolExecutor(1, "map reader")
        self._asked: CountingMap | None = None
        self._reading: Future[KnownScene] | None = None

    def hear(self, data: bytes, now: float) -> None:
        """Processes a packet of the control loop, which announces a version.

        Args:
            data: The packet.
            now: The present time by this machine's wall clock [s].

        Raises:
            BrokenMessage: The packet does not name a map.
        """
        named = decode_counting(data, now)
        if named is not None:
            self._named, self._heard = named, now

    def at(self, now: float) -> KnownScene:
        """Returns the map that detection must use now.

        Args:
            now: The present time by this machine's wall clock [s].
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
        """Starts to read another version."""
        self._asked, self._reading, self.trouble = named, None, ""
        if named.version:
            self._reading = self._reader.submit(self._read, named)
        else:
            self.trouble = "the control loop started with another map"

    def _take(self, reading: Future[KnownScene], version: int) -> None:
        """Uses a version whose reading has ended."""
        self._reading = None
        try:
            self.known, self.version = reading.result(), version
        except RemoSplatError as error:
            self.trouble = str(error)

    def _read(self, named: CountingMap) -> KnownScene:
        path = Session.open(self._folder).map_path(named.version)
        scene_map = open_map(path)
        if scene_map.field.revision != named.revision:
            raise FileError(path, "differs from the control loop's map")
        surface_W = surface_points(scene_map.splat_W, None)
        known = KnownScene(scene_map.field, self._config, surface_W)
        known.prepare_as(self.known)
        return known
