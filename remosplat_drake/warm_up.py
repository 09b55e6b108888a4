"""Tell the user about the one slow start: compiling the numba kernels."""

from rich.console import Console

from remosplat_drake import __version__, resources
from remosplat_drake.atomic_file import atomic_write


def announce(console: Console) -> None:
    """Says once per version that kernels are about to be compiled.

    Numba keeps what it compiles, so this only concerns the first run after
    an installation.
    """
    marker = resources.cache_dir() / f"compiled-{__version__}"
    if marker.exists():
        return
    console.print(
        "first start: compiling kernels, this takes about half a minute once"
    )
    with atomic_write(marker) as file:
        file.write("")
