"""Lists image files in order, and notes images that are not used."""

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
    """Lists a folder's images in natural order; [] if it does not exist."""
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
        used: Names of the images that are used.
        lacking: Data that the unused images do not have, such as "a pose".

    Returns:
        A list of one sentence, or an empty list.
    """
    rest = [name for name in images if name not in used]
    if len(rest) <= _MOST_LEFT_OUT * len(images):
        return []
    return [
        f"{len(rest)} of {len(images)} images lack {lacking} and are not used, "
        f"the first of them {rest[0]}"
    ]


def _natural_key(path: Path) -> list[tuple[int, str, int]]:
    """Words and numbers of a file's name, as a key for sorting."""
    return [
        (0, "", int(part)) if part.isdecimal() else (1, part, 0)
        for part in re.split(r"(\d+)", path.name)
        if part
    ]
