"""Tell the user about the one slow start: compiling the numba kernels."""

import contextlib
from pathlib import Path

from rich.console import Console

from remosplat_drake import __version__, resources
from remosplat_drake.atomic_file import atomic_write
from remosplat_drake.errors import FileError


def announce(console: Console) -> None:
    """Says that kernels are about to be compiled, until that has happened.

    Numba keeps what it compiles, so this only concerns the first run after
    an installation.
    """
    if not _marker().exists():
        console.print(
            "first start: compiling kernels, this takes about half a minute"
            " once"
        )


def remember() -> None:
    """Notes that the kernels have been compiled, where that is possible."""
    with contextlib.suppress(FileError), atomic_write(_marker()) as file:
        file.write("")


def _marker() -> Path:
    return resources.cache_dir() / f"compiled-{__version__}"
