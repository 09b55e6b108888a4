"""Reads the camera files that are beside the images of a capture.

Such files follow OpenCV: the centre of the first pixel is (0, 0). In a
`Capture` it is (0.5, 0.5), so half a pixel is added to the principal point.
"""

from pathlib import Path

import numpy as np

from remosplat_drake.base.errors import FileError
from remosplat_drake.capture.readers.text_files import (
    as_matrix,
    read_json,
    read_matrix,
)

_MATRIX_FILES = ("camera-intrinsics.txt", "intrinsics.txt", "intrinsic.txt")
_JSON_PATTERNS = ("camera*.json", "intrinsic*.json")

EXPECTED = f"{', '.join(_MATRIX_FILES)} (3x3) or camera*.json (Open3D)"
"""Description of the files that `find_intrinsics` reads."""


def find_intrinsics(*folders: Path) -> np.ndarray:
    """Reads the intrinsic matrix from the first camera file in the folders.

    Returns:
        K, shape (3, 3) [pixels].

    Raises:
        FileError: There is no camera file, or it is unreadable.
    """
    for folder in folders:
        for name in _MATRIX_FILES:
            if (folder / name).is_file():
                K = read_matrix(folder / name, (3, 3))
                return from_opencv(K)
        for pattern in _JSON_PATTERNS:
            for path in sorted(folder.glob(pattern)):
                return from_opencv(_read_open3d(path))
    raise FileError(folders[0], f"no intrinsics; expected {EXPECTED}")


def from_opencv(K: np.ndarray) -> np.ndarray:
    """Adds half a pixel to a principal point in OpenCV's convention."""
    return K + np.array([[0, 0, 0.5], [0, 0, 0.5], [0, 0, 0]])


def _read_open3d(path: Path) -> np.ndarray:
    """The matrix of an Open3D camera, which is written column by column."""
    values = read_json(path).get("intrinsic_matrix")
    columns = as_matrix(path, [values], (1, 9))
    return columns.reshape(3, 3).T
