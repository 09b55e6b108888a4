"""Deletes Numba's cached kernels once a source that they contain is newer.

Numba keeps compiled kernels on disk and compiles one again when its own file
has changed. A kernel of another file that it inlines may change unseen, and the
old code runs on silently. So all are deleted as soon as one of their files is
newer.
"""

import contextlib
from pathlib import Path

_PACKAGE = Path(__file__).resolve().parents[1]


def drop_stale_kernels(package: Path = _PACKAGE) -> bool:
    """Deletes the compiled kernels if any of them may be stale.

    To be called before the first kernel is used. It concerns those who edit
    or update a checkout; an installed wheel does not change.

    Returns:
        Whether anything was deleted.
    """
    indices = list(package.rglob("__pycache__/*.nbi"))
    sources = {_source(index) for index in indices}
    changed = max((_mtime(source) for source in sources), default=0.0)
    if all(_mtime(index) >= changed for index in indices):
        return False
    for compiled in package.rglob("__pycache__/*.nb[ic]"):
        with contextlib.suppress(OSError):
            compiled.unlink()
    return True


def _source(index: Path) -> Path:
    """The file of a kernel's index, `__pycache__/MODULE.KERNEL-....nbi`."""
    module = index.name.partition(".")[0]
    return index.parent.parent / f"{module}.py"


def _mtime(path: Path) -> float:
    try:
        return path.stat().st_mtime
    except OSError:
        return 0.0
