"""The refined cameras of a capture, as a file beside the splat."""

import dataclasses as dc
import json
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from remosplat_drake.base.atomic_file import write_atomically
from remosplat_drake.base.errors import FileError
from remosplat_drake.base.strict_json import read_json_object
from remosplat_drake.capture.capture import Capture
from remosplat_drake.reconstruction.alignment.camera_correction import corrected
from remosplat_drake.reconstruction.alignment.camera_errors import COUNT


def cameras_path(splat: Path) -> Path:
    """Returns the path of the refined cameras of a splat file."""
    return splat.with_suffix(".cameras.json")


def write_cameras(
    splat: Path,
    refined_W: Capture | None,
    undone: Sequence[np.ndarray] = (),
):
    """Writes the file of refined cameras beside a splat, or removes it.

    Args:
        splat: Path of the splat's file.
        refined_W: The capture with refined cameras, in its own frame W; None if
            the cameras were not refined. An older file is then removed.
        undone: Camera errors that were corrected, one array of shape (`COUNT`,)
            per correction, in the order of the corrections; see
            `camera_errors`.
    """
    path = cameras_path(splat)
    if refined_W is None:
        path.unlink(missing_ok=True)
        return
    poses = refined_W.X_WC[:, :3].reshape(-1, 12)
    content = {
        "undone": [errors.tolist() for errors in undone],
        "X_WC": np.round(poses, 12).tolist(),
    }
    write_atomically(path, json.dumps(content, indent=1) + "\n")


def with_cameras(capture: Capture, splat: Path) -> Capture:
    """Returns a capture with the refined cameras of a splat.

    Without a file of refined cameras, the capture is returned unchanged.

    Raises:
        FileError: The file was not made by `write_cameras`, or has another
            number of views.
    """
    path = cameras_path(splat)
    if not path.is_file():
        return capture
    rows, undone = _read(path)
    if len(rows) != len(capture):
        raise FileError(
            path,
            f"has {len(rows)} cameras, but the capture has {len(capture)} views"
            " (read it with the stride and the keyframes that the splat was"
            " made with)",
        )
    for errors in undone:
        capture = corrected(capture, errors)
    X_WC = np.tile(np.eye(4), (len(rows), 1, 1))
    X_WC[:, :3] = rows
    return dc.replace(capture, X_WC=X_WC)


def undone_errors(splat: Path) -> np.ndarray:
    """Reads the camera errors that were corrected for a splat.

    Returns:
        The m corrections in their order, shape (m, `COUNT`); see
        `camera_errors`. m is 0 if there are no refined cameras.

    Raises:
        FileError: The file was not made by `write_cameras`.
    """
    path = cameras_path(splat)
    return _read(path)[1] if path.is_file() else np.zeros((0, COUNT))


def _read(path: Path) -> tuple[np.ndarray, np.ndarray]:
    """Poses, (n, 3, 4), and corrections, (m, `COUNT`), of a file."""
    content = read_json_object(path)
    try:
        rows = np.array(content["X_WC"], float).reshape(-1, 3, 4)
        undone = np.array(content["undone"], float).reshape(-1, COUNT)
    except (KeyError, TypeError, ValueError) as error:
        problem = f"must contain X_WC, and rows of {COUNT} numbers in undone"
        raise FileError(path, problem) from error
    return rows, undone
