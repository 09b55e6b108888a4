"""`McapFile`: writes messages to a file that is readable even after a crash.

Once per second, a chunk is completed and passed to the operating system. If the
writer is killed, the file has no index at its end, and readers scan the file
instead. Until the file is complete, it has another name; see `partial_path`.
"""

import contextlib
import errno
import json
import os
import time
from pathlib import Path

from remosplat_drake.base.errors import FileError
from remosplat_drake.base.system_libraries import import_optional
from remosplat_drake.base.version import __version__
from remosplat_drake.recording.mcap.messages import Message
from remosplat_drake.recording.mcap.schemas import SCHEMAS

_HELD = 1.0
"""Time after which messages in memory are written [s]."""


def partial_path(path: Path) -> Path:
    """Returns the path of a file before it is complete.

    Args:
        path: The final path of the file.
    """
    return path.with_name(f"{path.stem}.partial{path.suffix}")


class McapFile:
    """Writes messages until the file has reached its size limit.

    The file is at `partial_path` until it has been closed without an error.

    Attributes:
        trouble: Reason why messages are missing in the file; empty if the file
            is complete.
    """

    def __init__(self, path: Path, limit: int):
        """Creates the file.

        Args:
            path: The file; neither it nor its `partial_path` may exist.
            limit: Size of the file above which no messages are added [bytes].

        Raises:
            FileError: The file exists or cannot be made.
            MissingExtraError: The package `mcap` is not installed.
        """
        writer = import_optional("mcap.writer", "an MCAP file", "record")
        partial = partial_path(path)
        for name in (path, partial):
            if name.exists():
                raise FileError(name, os.strerror(errno.EEXIST))
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            self._file = partial.open("xb")
        except OSError as error:
            raise FileError(path, error.strerror or str(error)) from error
        self._path, self._partial = path, partial
        self._limit = limit
        self._writer = writer.Writer(self._file)
        self._writer.start(library=f"remosplat-drake {__version__}")
        self._whole, self._is_broken = 0, False
        self._schemas: dict[str, int] = {}
        self._channels: dict[str, int] = {}
        self._flushed = time.monotonic()
        self.trouble = ""
        self.flush(at_once=True)
        if self.trouble:
            self.close()
            partial.unlink()
            raise FileError(path, f"cannot be written: {self.trouble}")

    def add(self, message: Message) -> None:
        """Adds a message; if that fails, `trouble` states the reason."""
        if self.trouble:
            return
        nanoseconds = message.nanoseconds
        try:
            self._writer.add_message(
                channel_id=self._channel(message),
                log_time=nanoseconds,
                publish_time=nanoseconds,
                data=json.dumps(message.content, allow_nan=False).encode(),
            )
        except OSError as error:
            self._break(error)

    def flush(self, *, at_once: bool = False) -> None:
        """Passes data in memory to the operating system, at most once a second.

        Args:
            at_once: Whether to pass the data even if a second has not passed
                yet.
        """
        now = time.monotonic()
        if self.trouble or (now - self._flushed < _HELD and not at_once):
            return
        self._flushed = now
        try:
            self._writer.flush()
            self._whole = self._file.tell()
            if self._whole > self._limit:
                self.trouble = f"the file exceeds {self._limit >> 20} MiB"
        except OSError as error:
            self._break(error)

    def close(self) -> None:
        """Writes the index, closes the file, and renames it to its final name.

        If an error occurs, `trouble` states it, and the file keeps its
        `partial_path`.
        """
        try:
            if not self._is_broken:
                self._writer.finish()
                self._file.flush()
                os.fsync(self._file.fileno())
                self._whole = self._file.tell()
            if not self.trouble:
                self._partial.rename(self._path)
        except OSError as error:
            self._break(error)
        # `close` tries to write the remaining data again, and may write only a
        # part.
        with contextlib.suppress(OSError):
            self._file.close()
        if self._is_broken:
            with contextlib.suppress(OSError):
                os.truncate(self._partial, self._whole)

    def _break(self, error: OSError) -> None:
        """Records why writing has failed."""
        self.trouble = error.strerror or str(error)
        self._is_broken = True

    def _channel(self, message: Message) -> int:
        """Number of the message's channel, declared with its first message."""
        topic, name = message.topic, message.schema
        if name not in self._schemas:
            self._schemas[name] = self._writer.register_schema(
                name=name,
                encoding="jsonschema",
                data=json.dumps(SCHEMAS[name]).encode(),
            )
        if topic not in self._channels:
            self._channels[topic] = self._writer.register_channel(
                topic=topic,
                message_encoding="json",
                schema_id=self._schemas[name],
            )
        return self._channels[topic]
