"""Writes a long capture like that of a phone: one walk through a room.

The folder has the format of the Stray Scanner app: a video, depth images of 256
x 192 pixels with noise of one per cent, their confidence, and poses that drift.
It serves to measure `remosplat reconstruct` with a capture of this length.
"""

import argparse
import csv
import io
import sys
from collections.abc import Iterator, Sequence

import av
import numpy as np
from pydrake.math import RigidTransform, RotationMatrix
from rich.console import Console
from scipy.ndimage import gaussian_filter

from apps.studies.command_line import output_folder, study_main
from apps.studies.map_bound.ray_casting import cast_depth
from remosplat_drake.base.atomic_file import write_atomically
from remosplat_drake.base.progress import Progress
from remosplat_drake.capture.capture import back_project
from remosplat_drake.capture.images import image_module
from remosplat_drake.capture.readers.stray_scanner import (
    DEPTH_UNIT,
    ODOMETRY,
    VIDEO,
)
from remosplat_drake.commands.flags import check_positive, check_seed
from remosplat_drake.generation.scene_generators import generate

SIZE = (192, 256)
"""Height and width of a depth image [pixels]."""

FOCAL = 193.0
"""Focal length at the size of a depth image [pixels]."""

RATE = 30.0
"""Frames in each second [1/s]."""

_LOOP = 33.0
"""Time of one walk around the room [s]."""

_RANGE = 5.0
"""Largest measured depth [m]."""

_TREMBLE = 0.01
"""Standard deviation of a depth, as a fraction of it."""

_ALIKE = 4.0
"""Correlation length of depth noise [pixels]."""

_DRIFT = np.array([0.002, 0.002, 0.004, 0.02, 0.02, 0.02])
"""Error of the last pose: rotation vector [rad], position [m]."""


_COLUMNS = ("timestamp", "frame", "x", "y", "z", "qx", "qy", "qz", "qw")


def add_arguments(parser: argparse.ArgumentParser):
    """Declares the study's flags."""
    parser.add_argument("folder", type=output_folder, help="output folder")
    parser.add_argument(
        "--frames", type=int, default=1000, help="number of frames (1000)"
    )
    parser.add_argument(
        "--scale",
        type=float,
        default=2.5,
        help="width of the video over that of the depth (2.5; a phone's: 7.5)",
    )
    parser.add_argument(
        "--seed", type=int, default=0, help="seed of room and noise"
    )


def run(arguments: argparse.Namespace) -> int:
    """Writes the folder."""
    check_positive("phone_walk", arguments, "frames", "scale")
    check_seed("phone_walk", arguments)
    times = np.arange(arguments.frames) / RATE
    poses = [walk(time) for time in times.tolist()]
    with Progress(Console(), "casting rays") as progress:
        images = progress.over(poses, "writing frames")
        _write(arguments, images)
    _write_odometry(arguments, times, poses)
    return 0


def walk(time: float) -> RigidTransform:
    """Returns the pose X_WC of the camera at a time [s].

    The camera circles through the table's room once in `_LOOP`, at the height
    of a person's chest, and looks around.
    """
    along = 2 * np.pi * time / _LOOP
    p_WC = [
        2.1 + 1.3 * np.cos(along),
        1.6 * np.sin(along),
        1.35 + 0.1 * np.sin(5 * along),
    ]
    # It turns from the middle of the room to the walls, and back.
    yaw = along + np.pi + 0.9 * np.sin(4 * along)
    pitch = -0.45 + 0.3 * np.sin(7 * along)
    z_W = np.array(
        [
            np.cos(yaw) * np.cos(pitch),
            np.sin(yaw) * np.cos(pitch),
            np.sin(pitch),
        ]
    )
    x_W = np.cross(z_W, [0, 0, 1])
    x_W /= np.linalg.norm(x_W)
    R_WC = np.column_stack([x_W, np.cross(z_W, x_W), z_W])
    return RigidTransform(RotationMatrix(R_WC), p_WC)


def _write(arguments: argparse.Namespace, poses: Iterator[RigidTransform]):
    """Writes video, depths and confidences, frame by frame."""
    folder, K = arguments.folder, _intrinsics(1.0)
    for kind in ("depth", "confidence"):
        (folder / kind).mkdir(parents=True, exist_ok=True)
    scene = generate("room", arguments.seed).with_floor((0.0, 0.0), 6.0)
    height, width = (2 * round(s * arguments.scale / 2) for s in SIZE)
    image = image_module()
    with av.open(str(folder / VIDEO), "w") as video:
        options = {"preset": "ultrafast", "crf": "20"}
        stream = video.add_stream("libx264", rate=int(RATE), options=options)
        stream.height, stream.width, stream.pix_fmt = height, width, "yuv420p"
        for i, pose in enumerate(poses):
            rng = np.random.default_rng([arguments.seed, i])
            X_WC = pose.GetAsMatrix4()
            depth = cast_depth(scene, K, X_WC, SIZE[1], SIZE[0])
            rgb = image.fromarray(_colors(K, depth, X_WC))
            large = rgb.resize((width, height), image.Resampling.BICUBIC)
            video.mux(stream.encode(av.VideoFrame.from_image(large)))
            steps, levels = _measured(depth, rng)
            name = f"{i:06d}.png"
            image.fromarray(steps).save(folder / "depth" / name)
            image.fromarray(levels).save(folder / "confidence" / name)
        video.mux(stream.encode())


def _colors(K: np.ndarray, depth: np.ndarray, X_WC: np.ndarray) -> np.ndarray:
    """Colours that depend on the position, (h, w, 3): waves along the axes."""
    p_W = np.nan_to_num(back_project(K, depth, X_WC))
    waves = np.sin(p_W * [23.0, 29.0, 31.0]) * np.sin(p_W[..., ::-1] * 7.0)
    return (128 + 100 * waves).astype(np.uint8)


def _measured(
    depth: np.ndarray, rng: np.random.Generator
) -> tuple[np.ndarray, np.ndarray]:
    """Depth in millimetres and ARKit's confidence in it."""
    white = rng.standard_normal(depth.shape)
    smooth = gaussian_filter(white, _ALIKE) * 2 * np.sqrt(np.pi) * _ALIKE
    known = (depth > 0) & (depth < _RANGE)
    z = np.where(known, depth * (1 + _TREMBLE * smooth), 0)
    jump = np.hypot(*np.gradient(depth)) > 0.05 * depth
    levels = np.where(known & ~jump, 2, 0).astype(np.uint8)
    return np.rint(z / DEPTH_UNIT).astype(np.uint16), levels


def _intrinsics(scale: float) -> np.ndarray:
    height, width = SIZE
    K = np.array([[FOCAL, 0, width / 2], [0, FOCAL, height / 2], [0, 0, 1]])
    return np.diag([scale, scale, 1.0]) @ K


def _write_odometry(
    arguments: argparse.Namespace,
    times: np.ndarray,
    poses: Sequence[RigidTransform],
):
    """Writes the table of poses, and the intrinsics."""
    text = io.StringIO()
    rows = csv.writer(text, lineterminator="\n")
    rows.writerow(_COLUMNS)
    for i, (time, X_WC) in enumerate(zip(times.tolist(), poses, strict=True)):
        error = _DRIFT * i / max(len(poses) - 1, 1)
        turned = RotationMatrix.MakeZRotation(error[2]).multiply(
            RotationMatrix.MakeXRotation(error[0])
        )
        w, x, y, z = turned.multiply(X_WC.rotation()).ToQuaternion().wxyz()
        p_WC = (X_WC.translation() + error[3:]).tolist()
        rows.writerow([time, f"{i:06d}", *p_WC, x, y, z, w])
    write_atomically(arguments.folder / ODOMETRY, text.getvalue())
    camera = "\n".join(
        ", ".join(map(str, row)) for row in _intrinsics(arguments.scale)
    )
    write_atomically(arguments.folder / "camera_matrix.csv", camera + "\n")


def main(argv: Sequence[str] | None = None) -> int:
    """Runs the study from its command line."""
    return study_main("phone_walk", __doc__, add_arguments, run, argv)


if __name__ == "__main__":
    sys.exit(main())
