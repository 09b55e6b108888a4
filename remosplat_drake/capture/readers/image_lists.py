"""Lists of image files: their order, and images without a pose."""

import re
from collections.abc import Collection, Sequence
from pathlib import Path

_MOST_LEFT_OUT = 0.2
"""A note is made if more than this fraction of the images is not used."""

IMAGES = {".png", ".jpg", ".jpeg"}
"""Suffixes of image files."""


def in_natural_order(paths: Collection[Path]) -> list[Path]:
    """Sorts files by the numbers in their names, so that 2 comes before 10."""
    return sorted(paths, key=_natural_key)


def images_in(folder: Path) -> list[Path]:
    """Lists a folder's images in natural order; [] for a missing folder."""
    if not folder.is_dir():
        return []
    files = [f for f in folder.iterdir() if f.suffix.lower() in IMAGES]
    return in_natural_order(files)


def note_left_out(
    images: Sequence[str], used: Collection[str], lacking: str
) -> list[str]:
    """Makes a note if a large part of a capture's images is not used.

    Args:
        images: Names of all images.
        used: Names of those that are used.
        lacking: Reason why images are not used: the missing part, such as "a
            pose".

    Returns:
        One sentence, or nothing.
    """
    rest = [name for name in images if name not in used]
    if len(rest) <= _MOST_LEFT_OUT * len(images):
        return []
    return [
        f"{len(rest)} of {len(images)} images lack {lacking}, the first of"
        f" them {rest[0]}"
    ]


def _natural_key(path: Path) -> list[tuple[int, str, int]]:
    """Words and numbers of a file's name, so that both can be compared."""
    return [
        (0, "", int(part)) if part.isdecimal() else (1, part, 0)
        for part in re.split(r"(\d+)", path.name)
        if part
    ]
