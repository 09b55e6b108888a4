"""Reads and writes files of compiled kernels, one file for each kernel.

A file's name depends on the content of the kernel, the types of its arguments,
and the target processor. So a file is never out of date, and folders of kernels
can be copied and shared. Kernels are read from the user's cache and, if the
package was installed from a wheel with kernels, from the package. New kernels
are written to the user's cache.
"""

import fcntl
import hashlib
import os
import pickle
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from functools import cache
from pathlib import Path
from typing import Any

import llvmlite
import numba
from numba.core import config

from remosplat_drake.base.atomic_file import write_atomically
from remosplat_drake.base.errors import FileError
from remosplat_drake.base.resources import cache_dir

PACKAGED = Path(__file__).resolve().parents[2] / "compiled_kernels"
"""Folder of the kernels that a wheel contains."""

MADE_FOR = "made_for.txt"
"""Name of the file in the wheel's folder that states the versions and the
processor that the wheel's kernels require; see `made_for`."""

_MOST = 1_000_000_000
"""Size of the user's cache beyond which the oldest files are removed [B]."""


def kernels_dir() -> Path:
    """Returns the folder of the user's cache of kernels, which need not exist.

    The environment variable NUMBA_CACHE_DIR overrides the default.
    """
    chosen = os.environ.get("NUMBA_CACHE_DIR")
    return Path(chosen) if chosen else cache_dir() / "kernels"


def made_for() -> str:
    """Returns the versions and the processor of this process, as text."""
    python = ".".join(map(str, sys.version_info[:2]))
    processor = config.CPU_NAME or "this processor"
    return (
        f"Python {python}, Numba {numba.__version__}, llvmlite"
        f" {llvmlite.__version__}, {processor}"
    )


def unfit() -> str:
    """Returns what the wheel's kernels require, if this process does not fit.

    The text has the form of `made_for`. It is empty if the kernels fit this
    process, or if the wheel contains no kernels.
    """
    try:
        made = (PACKAGED / MADE_FOR).read_text()
    except OSError:
        return ""
    return made if made != made_for() else ""


def find(name: str) -> Path | None:
    """Returns the path of a kernel's file; None if the file does not exist.

    Args:
        name: Name of the kernel's file.
    """
    for folder in (kernels_dir(), PACKAGED):
        path = folder / name
        if path.exists():
            return path
    return None


def read(path: Path) -> tuple[Any, ...] | None:
    """Returns the parts of a kernel's file; None without a valid file."""
    try:
        return pickle.loads(path.read_bytes())
    except Exception:  # Damaged pickles raise anything.
        return None


def write(name: str, parts: tuple[Any, ...]) -> None:
    """Writes a kernel's file, unless the disk is full or read-only.

    Args:
        name: Name of the kernel's file.
        parts: The parts of the file, which `read` returns.
    """
    with suppress(FileError, OSError):
        write_atomically(kernels_dir() / name, pickle.dumps(parts))
        _remove_oldest()


def _remove_oldest() -> None:
    stats = []
    for entry in os.scandir(kernels_dir()):
        if not entry.name.endswith(".kernel"):
            continue
        with suppress(FileNotFoundError):
            stat = entry.stat()
            stats.append((stat.st_mtime, stat.st_size, entry.path))
    size = sum(size for _, size, _ in stats)
    for _, part, path in sorted(stats):
        if size <= _MOST:
            return
        Path(path).unlink(missing_ok=True)
        size -= part


@contextmanager
def locked(name: str) -> Iterator[None]:
    """Provides a context in which only this process compiles a kernel.

    If the folder is read-only, there is no lock, and each process compiles the
    kernels that it needs.

    Args:
        name: Name of the kernel's file.
    """
    place = int.from_bytes(hashlib.sha256(name.encode()).digest()[:4])
    try:
        descriptor = _lock_file(kernels_dir())
        fcntl.lockf(descriptor, fcntl.LOCK_EX, 1, place)
    except OSError:
        yield
        return
    try:
        yield
    finally:
        fcntl.lockf(descriptor, fcntl.LOCK_UN, 1, place)


@cache
def _lock_file(folder: Path) -> int:
    """Returns the open lock file, in which each byte is a lock."""
    folder.mkdir(parents=True, exist_ok=True)
    return os.open(folder / "lock", os.O_RDWR | os.O_CREAT, 0o666)
