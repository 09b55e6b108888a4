"""Deletes Numba's cached kernels once a source that they contain is newer.

Numba keeps compiled kernels on disk and compiles one again when its own file
has changed. A kernel of another file that it inlines may change unseen, and the
old code runs on silently. So all are deleted as soon as a file with compiled
code is newer.
"""

import contextlib
from collections.abc import Iterable, Iterator
from itertools import chain
from pathlib import Path

PACKAGE = Path(__file__).resolve().parents[1]


def drop_stale_kernels(package: Path = PACKAGE, *others: Path) -> bool:
    """Deletes the compiled kernels if any of them may be stale.

    To be called before the first kernel is used. It concerns those who edit
    or update a checkout; an installed wheel does not change.

    Args:
        package: Where the sources are, and their kernels.
        others: Where else there are kernels that contain code of the package.

    Returns:
        Whether anything was deleted.
    """
    folders = (package, *others)
    indices = _files(folders, "__pycache__/*.nbi")
    oldest = min((_mtime(index) for index in indices), default=None)
    if oldest is None or not any(
        _mtime(source) > oldest and _is_compiled(source)
        for source in package.rglob("*.py")
    ):
        return False
    for compiled in _files(folders, "__pycache__/*.nb[ic]"):
        with contextlib.suppress(OSError):
            compiled.unlink()
    return True


def _files(folders: Iterable[Path], pattern: str) -> Iterator[Path]:
    return chain.from_iterable(folder.rglob(pattern) for folder in folders)


def _is_compiled(source: Path) -> bool:
    """Whether a module has code that Numba compiles, if only into others'."""
    with contextlib.suppress(OSError):
        text = source.read_bytes()
        return b"numba" in text or b"base.kernels import" in text
    return False


def _mtime(path: Path) -> float:
    try:
        return path.stat().st_mtime
    except OSError:
        return 0.0
