"""Reads the small text files that come with captures."""

import zipfile
from pathlib import Path

import numpy as np

from remosplat_drake.base.errors import FileError
from remosplat_drake.base.strict_json import parse_json_object

MAX_BYTES = 256_000_000
"""No capture's text is longer; a file that is, is something else."""


def read_text(path: Path | zipfile.Path) -> str:
    """A whole text file.

    Raises:
        FileError: It is missing, too long, or no text.
    """
    try:
        if isinstance(path, Path) and path.stat().st_size > MAX_BYTES:
            raise FileError(path, "is too long for a text file")
        return path.read_text(encoding="utf-8")
    except FileNotFoundError as error:
        raise FileError(str(path), "no such file") from error
    except (OSError, ValueError, EOFError, zipfile.BadZipFile) as error:
        raise FileError(str(path), f"unreadable text: {error}") from error


def read_json(path: Path | zipfile.Path) -> dict:
    """The object in a JSON file.

    Raises:
        FileError: It is missing or holds no JSON object that is read; see
            `parse_json`.
    """
    return parse_json_object(read_text(path), str(path))


def read_rows(path: Path) -> list[list[str]]:
    """The words of a file's lines, without comments (#) and empty lines.

    Raises:
        FileError: It is missing or no text.
    """
    lines = (line.split("#")[0] for line in read_text(path).splitlines())
    return [line.replace(",", " ").split() for line in lines if line.strip()]


def read_matrix(path: Path, shape: tuple[int, int]) -> np.ndarray:
    """A matrix of numbers.

    Raises:
        FileError: The file is missing or holds no such matrix.
    """
    return as_matrix(path, read_rows(path), shape)


def as_matrix(path: Path, rows: object, shape: tuple[int, int]) -> np.ndarray:
    """Rows of words or numbers as a matrix.

    Raises:
        FileError: They are no matrix of this shape; names `path`.
    """
    try:
        matrix = np.array(rows, float)
    except (TypeError, ValueError) as error:
        raise FileError(path, f"expected numbers: {error}") from error
    if matrix.shape != shape:
        raise FileError(
            path,
            f"expected a {shape[0]}x{shape[1]} matrix, got shape"
            f" {'x'.join(map(str, matrix.shape))}",
        )
    return matrix
