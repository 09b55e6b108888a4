"""Reads captures in the layout of the TUM RGB-D benchmark.

Lines of `rgb.txt` and `depth.txt` have the form `time file`, and lines of
`groundtruth.txt` the form `time tx ty tz qx qy qz qw`. These are camera poses
in OpenCV axes, from a tracking system with a clock of its own. Depth is in
steps of 1/5000 m. Poses are interpolated to the time of the depth image, since
the geometry is computed from depth.

The data sets contain no camera file. If the folder's name contains the name of
one of the benchmark's three cameras, the reader uses this camera's intrinsics
(Sturm et al., IROS 2012, and the benchmark's web page). Other cameras need a
camera file in the folder.
"""

import re
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation, Slerp

from remosplat_drake.base.errors import FileError
from remosplat_drake.capture.frames import Frame
from remosplat_drake.capture.images import read_colors, read_depth, read_size
from remosplat_drake.capture.readers.image_lists import note_left_out
from remosplat_drake.capture.readers.intrinsics import (
    find_intrinsics,
    from_opencv,
)
from remosplat_drake.capture.readers.poses import shortened
from remosplat_drake.capture.readers.text_files import as_matrix, read_rows
from remosplat_drake.capture.recording import DepthImage, Recording
from remosplat_drake.capture.undistortion import Distortion

DEPTH_UNIT = 1 / 5000
"""Length of one step of a depth image [m]."""

TOLERANCE = 0.02
"""An image and a pose belong together if their times differ by at most this
[s]."""

EXPECTED_FILES = "a folder with rgb.txt, depth.txt and groundtruth.txt"
"""Description of the files that `recognises` accepts."""

_FILES = ("rgb.txt", "depth.txt", "groundtruth.txt")
_CAMERAS = {
    1: (
        (517.3, 516.5, 318.6, 255.3),
        Distortion(0.2624, -0.9531, 1.1633, 0.0, -0.0054, 0.0026),
    ),
    2: (
        (520.9, 521.0, 325.1, 249.7),
        Distortion(0.2312, -0.7849, 0.9172, 0.0, -0.0033, -0.0001),
    ),
    3: ((535.4, 539.2, 320.1, 247.6), Distortion()),
}
"""Intrinsics fx, fy, cx, cy and distortion of the benchmark's "Freiburg"
cameras.
"""


def recognises(path: Path) -> bool:
    """Returns whether a path is a folder of the TUM RGB-D benchmark."""
    return all((path / name).is_file() for name in _FILES)


def open_recording(path: Path) -> Recording:
    """Finds all frames of a folder with colour, depth and a pose.

    Raises:
        FileError: A file is missing or unreadable.
    """
    K, distortion = _camera(path)
    _, color_files = _read_list(path / "rgb.txt")
    depth_times, depth_files = _read_list(path / "depth.txt")
    pose_times, poses = _read_trajectory(path / "groundtruth.txt")
    pairs = _pairs(path)
    if not pairs:
        raise FileError(
            path,
            f"no frame has colour, depth and pose within {TOLERANCE} s",
        )
    names = [color_files[color] for color, _ in pairs]
    depths = [path / depth_files[depth] for _, depth in pairs]
    times = depth_times[[depth for _, depth in pairs]]
    X_WC = interpolate_poses(pose_times, poses, times)

    def read_depths(
        chosen: Sequence[int],
    ) -> Iterator[tuple[int, DepthImage]]:
        for i in chosen:
            size = read_size(path / names[i])
            depth = read_depth(depths[i], DEPTH_UNIT)
            yield i, DepthImage.of_color_camera(names[i], K, size, depth)

    def read_frames(chosen: Sequence[int]) -> Iterator[tuple[int, Frame]]:
        for i in chosen:
            yield (
                i,
                Frame(
                    name=names[i],
                    K=K,
                    X_WC=X_WC[i],
                    rgb=read_colors(path / names[i]),
                    depth=read_depth(depths[i], DEPTH_UNIT),
                    distortion=distortion,
                    time=float(times[i]),
                ),
            )

    return Recording(X_WC, read_depths, read_frames, times)


def notes(path: Path) -> list[str]:
    """Returns notes on unused data of a folder; does not read frames."""
    _, colors = _read_list(path / "rgb.txt")
    used = {colors[i] for i, _ in _pairs(path)}
    lacking = f"a depth image with a pose within {TOLERANCE} s"
    return note_left_out(colors, used, lacking)


def _pairs(path: Path) -> list[tuple[int, int]]:
    """Indices of colour and depth images that have a pose."""
    color_times, _ = _read_list(path / "rgb.txt")
    depth_times, _ = _read_list(path / "depth.txt")
    pose_times, _ = _read_trajectory(path / "groundtruth.txt")
    depths = associate(color_times, depth_times).tolist()
    near = associate(depth_times, pose_times) >= 0
    return [(i, d) for i, d in enumerate(depths) if d >= 0 and near[d]]


def associate(
    times: np.ndarray, others: np.ndarray, tolerance: float = TOLERANCE
) -> np.ndarray:
    """Finds the nearest of the sorted times `others` for each of `times`.

    Args:
        times: Times, shape (n,) [s].
        others: Sorted times, shape (m,) [s].
        tolerance: Largest difference [s].

    Returns:
        Indices into `others`, shape (n,); -1 where no time is within the
        tolerance.
    """
    after = np.searchsorted(others, times).clip(0, len(others) - 1)
    before = np.maximum(after - 1, 0)
    first = np.abs(others[before] - times) <= np.abs(others[after] - times)
    nearest = np.where(first, before, after)
    return np.where(np.abs(others[nearest] - times) <= tolerance, nearest, -1)


def interpolate_poses(
    times: np.ndarray, poses: np.ndarray, wanted: np.ndarray
) -> np.ndarray:
    """Interpolates a trajectory; poses are constant before and after it.

    Args:
        times: Sorted times of the rows, shape (n,) [s].
        poses: Rows `tx ty tz qx qy qz qw`, shape (n, 7).
        wanted: Times of the wanted poses, shape (m,) [s].

    Returns:
        The poses, shape (m, 4, 4).
    """
    wanted = np.clip(wanted, times[0], times[-1])
    X_WC = np.tile(np.eye(4), (len(wanted), 1, 1))
    turns = Slerp(times, Rotation.from_quat(poses[:, 3:]))
    X_WC[:, :3, :3] = turns(wanted).as_matrix()
    for axis in range(3):
        X_WC[:, axis, 3] = np.interp(wanted, times, poses[:, axis])
    return X_WC


def _camera(path: Path) -> tuple[np.ndarray, Distortion | None]:
    """K and distortion, from a camera file or else by the folder's name."""
    try:
        return find_intrinsics(path), None
    except FileError as error:
        named = re.search(r"(?:freiburg|fr)([123])", path.resolve().name)
        if error.path != path or named is None:
            raise
    (fx, fy, cx, cy), distortion = _CAMERAS[int(named[1])]
    K = np.array([[fx, 0, cx], [0, fy, cy], [0, 0, 1]])
    return from_opencv(K), distortion


def _read_list(path: Path) -> tuple[np.ndarray, list[str]]:
    """Times (n,) and names of the images that a file lists, in order."""
    rows = read_rows(path)
    if not rows or any(len(row) != 2 for row in rows):
        raise FileError(path, "expected a time and a file in each line")
    times = as_matrix(path, [row[:1] for row in rows], (len(rows), 1))[:, 0]
    if not np.isfinite(times).all():
        raise FileError(path, "times must be finite")
    order = np.argsort(times, kind="stable")
    return times[order], [rows[i][1] for i in order]


def _read_trajectory(path: Path) -> tuple[np.ndarray, np.ndarray]:
    """Times (n,) and rows `tx ty tz qx qy qz qw` (n, 7), in order of time."""
    rows = read_rows(path)
    table = as_matrix(path, rows, (len(rows), 8))
    _, first = np.unique(table[:, 0], return_index=True)
    table = table[first]
    if len(table) < 2:
        raise FileError(path, "expected at least two poses")
    if not np.isfinite(table).all():
        raise FileError(path, "poses must be finite")
    try:
        table[:, 4:] = shortened(table[:, 4:])
    except ValueError as error:
        raise FileError(path, f"a pose has no rotation: {error}") from error
    return table[:, 0], table[:, 1:]
