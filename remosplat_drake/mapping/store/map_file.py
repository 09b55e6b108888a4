"""Writes and opens the files of maps, `*.rsmap`.

The control process opens a new map with its hierarchy in about a millisecond.
It receives the file's seal from the mapping process, which has just written the
file, and maps the file into memory without checks. A file from another source,
or from another run of the program, is read, checked and prepared again, as
`array_file` and `map_parts` describe.
"""

from pathlib import Path

from remosplat_drake.base.array_file import (
    FileKind,
    VersionError,
    open_arrays,
    write_arrays,
)
from remosplat_drake.base.errors import FieldError, FileError, RemoSplatError
from remosplat_drake.mapping.store.map_parts import put_together, take_apart
from remosplat_drake.signals.scene_map import SceneMap

SUFFIX = ".rsmap"
"""File name extension of maps."""

KIND = FileKind("map", b"RSMAP\r\n\0", 4)

__all__ = ["KIND", "SUFFIX", "VersionError", "open_map", "write_map"]


def write_map(path: str | Path, scene_map: SceneMap) -> str:
    """Writes a version of the map to a file, atomically.

    Args:
        path: The file.
        scene_map: The map.

    Returns:
        The file's seal, with which this run of the program may open the file
        without checks.

    Raises:
        FileError: The file cannot be written, for example because the disk is
            full, or the map contains a field on a GPU, which a file cannot
            store.
    """
    path = Path(path)
    try:
        document, arrays = take_apart(scene_map)
    except RemoSplatError as error:
        raise FileError(path, f"cannot hold this map: {error}") from error
    return write_arrays(path, KIND, document, arrays)


def open_map(path: str | Path, seal: str | None = None) -> SceneMap:
    """Opens a version of the map that is in a file.

    Args:
        path: The file.
        seal: The return value of `write_map` in this run of the program. With a
            seal, opening takes about a millisecond, and arrays are views of the
            file. The file may then be deleted or replaced, but not modified.
            Without a seal, the whole content is checked and prepared, which
            takes some hundredths of a second.

    Raises:
        VersionError: The file has an unsupported version of the format.
        FileError: The file is missing, not a map, truncated or damaged.
        FieldError: A field of the file's document is invalid.
    """
    path = Path(path)
    file = open_arrays(path, KIND, seal)
    try:
        return put_together(file)
    except (FileError, FieldError):
        raise
    except RemoSplatError as error:
        raise FileError(path, f"holds no map: {error}") from error
