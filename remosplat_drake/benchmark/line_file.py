"""`LineFile`: a file to which results are appended, one per line."""

import os
from pathlib import Path

from remosplat_drake.base.errors import FileError


class LineFile:
    """A file to which whole lines are appended; `append` waits for the disk.

    Args:
        path: Path of the file, which is created if it does not exist.

    Raises:
        FileError: The file cannot be written.
    """

    def __init__(self, path: Path):
        self._path = path

    def __enter__(self) -> "LineFile":
        flags = os.O_RDWR | os.O_CREAT | os.O_APPEND
        try:
            self._path.parent.mkdir(parents=True, exist_ok=True)
            self._handle = os.open(self._path, flags, 0o666)
            self._cut_torn_line()
        except OSError as error:
            raise FileError(self._path, error.strerror or str(error)) from error
        return self

    def __exit__(self, *exception):
        os.close(self._handle)

    def append(self, text: str):
        """Appends one line, which is given without its line end."""
        line = (text + "\n").encode()
        try:
            written = os.write(self._handle, line)
            os.fsync(self._handle)
        except OSError as error:
            raise FileError(self._path, error.strerror or str(error)) from error
        if written < len(line):
            raise FileError(self._path, "the disk is full")

    def _cut_torn_line(self):
        """Removes an incomplete last line, which a killed program has left."""
        data = self._path.read_bytes()
        os.ftruncate(self._handle, data.rfind(b"\n") + 1)
