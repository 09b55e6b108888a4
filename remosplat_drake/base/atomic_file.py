"""Writes files atomically: completely or not at all."""

import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from tempfile import mkstemp
from typing import IO

from remosplat_drake.base.errors import FileError


@contextmanager
def atomic_write(path: Path, mode: str = "w") -> Iterator[IO]:
    """Opens a temporary file that replaces `path` at the end of the block.

    If the block raises an exception, `path` is unchanged.

    Raises:
        FileError: The folder cannot be made or written, `path` is a folder,
            or the disk is full.
    """
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        handle, name = mkstemp(dir=path.parent, prefix=f".{path.name}.")
    except OSError as error:
        raise FileError(path, error.strerror or str(error)) from error
    temporary = Path(name)
    try:
        with os.fdopen(handle, mode) as file:
            yield file
            file.flush()
            os.fsync(file.fileno())
        os.chmod(temporary, 0o666 & ~_umask())
        os.replace(temporary, path)
    except OSError as error:
        temporary.unlink(missing_ok=True)
        problem = error.strerror or str(error)
        raise FileError(path, f"cannot be written: {problem}") from error
    except BaseException:
        temporary.unlink(missing_ok=True)
        raise


def check_writable(path: Path) -> None:
    """Checks in advance whether `atomic_write` could write a file.

    Call this function before a long computation that writes its result at the
    end. It creates neither the file nor its folder.

    Raises:
        FileError: `path` is a folder, or no file can be made there.
    """
    if path.is_dir():
        raise FileError(path, "is a folder")
    folder = path.absolute().parent
    while not os.path.exists(folder):
        folder = folder.parent
    if not folder.is_dir():
        raise FileError(path, f"{folder} is not a folder")
    if not os.access(folder, os.W_OK | os.X_OK):
        raise FileError(path, f"{folder} cannot be written")


def _umask() -> int:
    umask = os.umask(0)
    os.umask(umask)
    return umask


def replace_checked(path: Path, text: str, check: Callable[[], object]) -> None:
    """Replaces a text file, and restores the old content if a check fails.

    Args:
        path: The file, which must exist.
        text: Its new content.
        check: Function that reads the new file; if it raises an exception, the
            old content is restored.

    Raises:
        FileError: The folder cannot be made or written.
        Exception: The exception that `check` raised.
    """
    before = path.read_bytes()
    write_atomically(path, text)
    try:
        check()
    except BaseException:
        write_atomically(path, before)
        raise


def write_atomically(path: Path, data: bytes | str) -> None:
    """Writes bytes, or text as UTF-8, to a file atomically; see `atomic_write`.

    Raises:
        FileError: The folder cannot be made or written.
    """
    with atomic_write(path, "wb") as file:
        file.write(data.encode() if isinstance(data, str) else data)
