"""The refined cameras of a capture, as a file beside the splat."""

import dataclasses as dc
import json
from pathlib import Path

import numpy as np

from remosplat_drake.base.atomic_file import write_atomically
from remosplat_drake.base.errors import FileError
from remosplat_drake.base.strict_json import read_json_object
from remosplat_drake.capture.capture import Capture
from remosplat_drake.reconstruction.alignment.alignment import Alignment
from remosplat_drake.reconstruction.alignment.camera_correction import corrected
from remosplat_drake.reconstruction.alignment.camera_errors import COUNT


def cameras_path(splat: Path) -> Path:
    """Returns the path of the refined cameras of a splat file."""
    return splat.with_suffix(".cameras.json")


def write_cameras(splat: Path, alignment: Alignment | None):
    """Keeps refined cameras beside a splat; removes what is out of date.

    Args:
        splat: Path of the splat's file.
        alignment: The alignment; None, or one that was not accepted, leaves the
            capture's own cameras.
    """
    path = cameras_path(splat)
    if alignment is None or not alignment.accepted:
        path.unlink(missing_ok=True)
        return
    poses = alignment.capture.X_WC[:, :3].reshape(-1, 12)
    content = {
        "undone": alignment.undone.tolist(),
        "X_WC": [[round(x, 12) for x in row] for row in poses.tolist()],
    }
    write_atomically(path, json.dumps(content, indent=1) + "\n")


def with_cameras(capture: Capture, splat: Path) -> Capture:
    """Gives a capture the refined cameras beside a splat, if there are any.

    Raises:
        FileError: The file is not what `write_cameras` writes, or is of
            another number of views.
    """
    path = cameras_path(splat)
    if not path.is_file():
        return capture
    content = read_json_object(path)
    try:
        rows = np.array(content["X_WC"], float).reshape(-1, 3, 4)
        undone = np.array(content["undone"], float).reshape(COUNT)
    except (KeyError, TypeError, ValueError) as error:
        problem = f"must hold X_WC and {COUNT} numbers in undone"
        raise FileError(path, problem) from error
    if len(rows) != len(capture):
        raise FileError(
            path,
            f"has {len(rows)} cameras, but the capture has {len(capture)} views"
            " (read it with the stride that the splat was made with)",
        )
    X_WC = np.tile(np.eye(4), (len(rows), 1, 1))
    X_WC[:, :3] = rows
    return dc.replace(corrected(capture, undone), X_WC=X_WC)
