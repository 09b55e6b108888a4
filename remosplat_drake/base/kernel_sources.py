"""The digest of the sources that compiled kernels contain.

These are the files in which something is compiled, and all files that they
import from: a kernel contains their functions and, as fixed numbers, their
constants.

Reading them takes longer than asking when they were changed. So the digest is
recorded beside the compiled kernels, together with the size and the times of
every file of the package, and computed again only if one of these differs.
"""

import hashlib
import os
import re
from collections.abc import Iterable, Iterator
from contextlib import suppress
from functools import cache
from pathlib import Path

from numba.core import caching

from remosplat_drake.base.atomic_file import write_atomically
from remosplat_drake.base.errors import FileError
from remosplat_drake.base.kernel_lock import locked

_PACKAGE = Path(__file__).resolve().parents[1]

_COMPILES = re.compile(
    rb"^from (?:remosplat_drake\.base\.kernels|numba\.extending|llvmlite)\b",
    re.M,
)
"""An import without which a file compiles nothing."""

_IMPORT = re.compile(
    rb"^from remosplat_drake\.([\w.]+) import (\([^)]*\)|.*)", re.M
)


def sources_digest() -> str:
    """Returns the digest of the sources as they are on disk now.

    If it differs from the recorded one, the compiled kernels that lie among
    the sources are deleted: Numba writes over most of them, but not over those
    whose functions are on other lines now.
    """
    folder = _folder()
    record = folder / "kernel_sources"
    files = sorted(_stamps())
    stamps = _digest(repr(files).encode())
    with locked(folder):
        known_stamps, known = _recorded(record)
        if known_stamps == stamps:
            return known
        digest = _digest(*_sources(path for path, *_ in files))
        if known and known != digest and folder.is_relative_to(_PACKAGE):
            for compiled in _PACKAGE.rglob("__pycache__/*.nb[ic]"):
                with suppress(OSError):
                    compiled.unlink()
        with suppress(FileError):
            write_atomically(record, f"{stamps} {digest}\n")
    return digest


@cache
def _folder() -> Path:
    """Returns the folder in which Numba keeps kernels of this file's folder.

    It is beside the file, or in a cache where that cannot be written.
    """
    locator = caching.CompileResultCacheImpl(sources_digest).locator
    locator.ensure_cache_path()
    return Path(locator.get_cache_path())


def _recorded(record: Path) -> tuple[str, str]:
    with suppress(OSError, ValueError):
        stamps, digest = record.read_text().split()
        return stamps, digest
    return "", ""


def _stamps() -> Iterator[tuple[str, int, int, int]]:
    """Yields path, size and times of each source of the package.

    The time at which its inode changed tells a file from another one of its
    size and its time of modification that has taken its place.
    """
    for folder, folders, names in os.walk(_PACKAGE):
        folders[:] = [name for name in folders if name != "__pycache__"]
        for name in names:
            if name.endswith(".py"):
                path = os.path.join(folder, name)
                with suppress(FileNotFoundError):  # An editor's lock, say.
                    stat = os.stat(path)
                    times = stat.st_mtime_ns, stat.st_ctime_ns
                    yield path, stat.st_size, *times


def _sources(paths: Iterable[str]) -> Iterator[bytes]:
    """Yields the names and the texts of the modules that kernels contain.

    Args:
        paths: The sources of the package.
    """
    texts: dict[str, bytes] = {}
    for path in map(Path, paths):
        with suppress(FileNotFoundError):
            name = ".".join(path.relative_to(_PACKAGE).with_suffix("").parts)
            texts[name] = path.read_bytes()
    found: set[str] = set()
    new = {name for name, text in texts.items() if _COMPILES.search(text)}
    while new:
        found |= new
        used = {used for name in new for used in _imports(texts[name])}
        new = (used & texts.keys()) - found
    for name in sorted(found):
        yield name.encode()
        yield texts[name]


def _imports(text: bytes) -> Iterator[str]:
    """Yields the modules that a source imports, and more names beside them."""
    for module, names in _IMPORT.findall(text):
        module = module.decode()
        yield from (module, f"{module}.__init__")
        for name in re.findall(rb"\w+", names):
            yield f"{module}.{name.decode()}"


def _digest(*parts: bytes) -> str:
    return hashlib.sha256(b"\0".join(parts)).hexdigest()
