"""Keeps Numba's compiled kernels on disk, for processes that share them.

Numba compiles a kernel again when its own file has changed. It does not look
at the other files whose code and constants the kernel contains, so the old
code would run on silently. Here the digest of all these files is a part of the
key by which a kernel is kept, wherever it is kept and whatever file it is of:
a kernel that contains code of this package is never older than that code.

Numba keeps the variants of a function in numbered files, and an index of them.
Two processes that save a variant each would take the same number, and the
index that is written last would forget the other's variant. So a process locks
the folder while it reads or writes there.
"""

import fcntl
from contextlib import suppress
from typing import Any

from numba.core import caching

from remosplat_drake.base.kernel_lock import locked
from remosplat_drake.base.kernel_sources import sources_digest

_OURS = "remosplat_drake"
"""Begins the keys that `_key` makes. Other processes that use a file outside
of this package may keep theirs beside ours."""

_DIGEST = sources_digest()
"""Of the sources as this process has found them."""


class KernelCacheFile(caching.IndexDataCacheFile):
    """The index and the files of one function."""

    def save(self, key: Any, data: Any) -> None:
        """Keeps a variant of the function.

        It is not kept if the sources have changed since this process started,
        which may have imported some of them before and some afterwards, nor
        where it cannot be written, as on a full disk.
        """
        if sources_digest() != _DIGEST:
            return
        with locked(self._cache_path, fcntl.LOCK_EX), suppress(OSError):
            super().save(_key(key), data)

    def load(self, key: Any) -> Any:
        """Returns a variant of the function; None if it is not kept."""
        with locked(self._cache_path, fcntl.LOCK_SH):
            return super().load(_key(key))

    def _load_index(self) -> dict[Any, str]:
        # Without what is left of other sources: its files are written over.
        # Their types may be such that the index cannot even be read.
        try:
            index = super()._load_index()
        except Exception:
            return {}
        return {
            key: name
            for key, name in index.items()
            if key[0] != _OURS or key[1] == _DIGEST
        }


def _key(key: Any) -> Any:
    return _OURS, _DIGEST, key


def is_kept(kernel: Any) -> bool:
    """Returns whether a kernel of the present sources is on disk.

    Args:
        kernel: The kernel, as `base/kernels.py` has made it.
    """
    index = kernel._cache._cache_file._load_index()
    return any(key[0] == _OURS for key in index)


def share_kernels() -> None:
    """Makes Numba keep all kernels this way from now on in this process."""
    caching.IndexDataCacheFile = KernelCacheFile
