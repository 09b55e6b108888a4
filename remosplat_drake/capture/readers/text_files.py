"""Reads small text files of captures: JSON, tables and matrices."""

import zipfile
from pathlib import Path

import numpy as np

from remosplat_drake.base.errors import FileError
from remosplat_drake.base.strict_json import parse_json_object

MAX_BYTES = 256_000_000
"""Largest size of a text file [bytes]."""


def read_text(path: Path | zipfile.Path) -> str:
    """Reads a text file.

    Raises:
        FileError: The file is missing or too long, or is not text.
    """
    try:
        if isinstance(path, Path) and path.stat().st_size > MAX_BYTES:
            raise FileError(path, "is too large for a text file")
        return path.read_text(encoding="utf-8")
    except FileNotFoundError as error:
        raise FileError(str(path), "no such file") from error
    except (OSError, ValueError, EOFError, zipfile.BadZipFile) as error:
        raise FileError(str(path), f"unreadable text: {error}") from error


def read_json(path: Path | zipfile.Path) -> dict:
    """Reads a JSON file that holds an object.

    Raises:
        FileError: The file is missing or is not a valid JSON object, see
            `parse_json`.
    """
    return parse_json_object(read_text(path), str(path))


def read_rows(path: Path) -> list[list[str]]:
    """Splits a file's lines into words; skips comments (#) and empty lines.

    Raises:
        FileError: The file is missing, or is not text.
    """
    lines = (line.split("#")[0] for line in read_text(path).splitlines())
    return [line.replace(",", " ").split() for line in lines if line.strip()]


def read_matrix(path: Path, shape: tuple[int, int]) -> np.ndarray:
    """Reads a matrix of numbers.

    Raises:
        FileError: The file is missing or contains no matrix of this shape.
    """
    return as_matrix(path, read_rows(path), shape)


def as_matrix(path: Path, rows: object, shape: tuple[int, int]) -> np.ndarray:
    """Converts rows of words or numbers to a matrix.

    Raises:
        FileError: The rows are no matrix of this shape; the error names `path`.
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
