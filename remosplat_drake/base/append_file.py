"""`AppendFile`: a file that only grows, and stays valid if the disk is full."""

import os
from pathlib import Path

from remosplat_drake.base.errors import FileError


class AppendFile:
    """A file to which data is appended completely or not at all.

    `append` never raises an exception and does not wait for the disk. When it
    returns, the operating system has the piece, so the piece survives a crash
    of this process.

    Args:
        path: The file, which must not exist; its folder is made.
        start: First bytes of the file.

    Raises:
        FileError: The file exists or cannot be made.
    """

    def __init__(self, path: Path, start: bytes = b""):
        self.path = path
        self._size = 0
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            flags = os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_APPEND
            self._file = os.open(path, flags | os.O_CLOEXEC, 0o666)
        except OSError as error:
            raise FileError(path, error.strerror or str(error)) from error
        problem = self.append(start)
        if problem:
            self.close()
            raise FileError(path, f"cannot be written: {problem}")

    def append(self, piece: bytes | memoryview) -> str:
        """Appends all bytes of a piece of data, or leaves the file unchanged.

        Args:
            piece: The bytes to append.

        Returns:
            The system's error message, such as "No space left on device", if
            the file is unchanged; otherwise the empty string.
        """
        rest = memoryview(piece)
        try:
            while len(rest):
                rest = rest[os.write(self._file, rest) :]
        except OSError as error:
            self._take_back()
            return error.strerror or str(error)
        self._size += len(piece)
        return ""

    def close(self) -> str:
        """Closes the file; nothing can be appended any more.

        Returns:
            A description of the problem, such as "was moved or deleted while it
            was written"; the empty string if the file is still at its path.
        """
        ours = os.fstat(self._file)
        os.close(self._file)
        try:
            there = self.path.stat()
        except OSError:
            return "was moved or deleted while it was written"
        return "" if os.path.samestat(ours, there) else "was replaced meanwhile"

    def _take_back(self) -> None:
        """Removes a partly written piece; this works on a full disk, too."""
        os.ftruncate(self._file, self._size)
