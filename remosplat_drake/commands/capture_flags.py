"""The flags that name a capture, and what reads it."""

import argparse

from remosplat_drake.base.resources import resolve
from remosplat_drake.capture.capture import Capture
from remosplat_drake.capture.formats import FORMATS, read_capture

TRUTH = "truth.json"
"""Name of the file with a rendered capture's true geometry, an RMMI file beside
its images."""


def add_capture_arguments(parser: argparse.ArgumentParser):
    """Declares the argument CAPTURE and the flags for reading it."""
    parser.add_argument(
        "capture", metavar="CAPTURE", help="a file or folder with RGB-D images"
    )
    parser.add_argument(
        "--format",
        metavar="NAME",
        help=f"one of {', '.join(FORMATS)} (default: told by the content)",
    )
    parser.add_argument(
        "--stride", type=int, default=1, help="use every so many frames (1)"
    )
    parser.add_argument(
        "--max-depth",
        type=float,
        metavar="Z",
        help="depth beyond is unknown [m]",
    )
    parser.add_argument(
        "--max-size",
        type=int,
        metavar="N",
        help="shrink larger images to that width or height [pixels]",
    )


def captured(arguments: argparse.Namespace) -> Capture:
    """Reads the capture that the flags name.

    Raises:
        RemoSplatError: The capture cannot be read.
    """
    return read_capture(
        resolve(arguments.capture),
        arguments.format,
        stride=arguments.stride,
        max_depth=arguments.max_depth,
        max_size=arguments.max_size,
    )
