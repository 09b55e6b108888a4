"""Finds the pose of a capture's map: its flags, and the file of the pose."""

import argparse
from pathlib import Path

from remosplat_drake.base.atomic_file import write_atomically
from remosplat_drake.base.resources import resolve
from remosplat_drake.capture.capture import Capture
from remosplat_drake.commands.capture_flags import TRUTH
from remosplat_drake.reconstruction.placement import (
    AUTO,
    CAPTURE,
    FLOOR,
    UPS,
    Placement,
    place,
)
from remosplat_drake.reconstruction.report.quality_report import pose_path
from remosplat_drake.scene.primitive_scene import PrimitiveScene
from remosplat_drake.scene.rmmi import read_scene


def add_placement_arguments(parser: argparse.ArgumentParser):
    """Declares `--up` and `--floor`, the flags about the upward direction."""
    parser.add_argument(
        "--up",
        choices=UPS,
        default=AUTO,
        help=(
            "source of the upward direction and of z = 0. auto: the floor if "
            "one is found, or else the format of the capture. floor: the "
            "floor, which must be found. capture: the capture's frame, in "
            "which z is up and z = 0 is the floor. none: they are unknown, and "
            "no scenario is written"
        ),
    )
    parser.add_argument(
        "--floor",
        dest="up",
        action="store_const",
        const=FLOOR,
        help="the same as --up floor",
    )


def true_scene(arguments: argparse.Namespace) -> PrimitiveScene | None:
    """Reads the true geometry in the capture's frame; None if no file has it.

    Raises:
        RemoSplatError: The true geometry cannot be read.
    """
    if arguments.truth:
        return read_scene(resolve(arguments.truth))
    path = resolve(arguments.capture) / TRUTH
    return read_scene(path) if path.is_file() else None


def find_placement(
    capture: Capture, arguments: argparse.Namespace
) -> Placement:
    """Finds the pose of the map of a capture.

    If the true geometry is known, the map's frame does not change.

    Raises:
        RemoSplatError: A floor is required, but no plane is clearly a floor.
    """
    known = arguments.up == AUTO and true_scene(arguments) is not None
    return place(capture, CAPTURE if known else arguments.up)


def write_pose(placement: Placement, splat: Path):
    """Writes the pose of the capture's frame to the file that `quality` reads.

    Raises:
        FileError: The file cannot be written.
    """
    if not placement.moves:
        pose_path(splat).unlink(missing_ok=True)
        return
    rows = placement.X_FW.GetAsMatrix4().tolist()
    text = "\n".join(
        " ".join(f"{round(x, 12):.12g}" for x in row) for row in rows
    )
    write_atomically(pose_path(splat), text + "\n")
