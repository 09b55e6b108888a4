"""Flags that select a capture and its frames; reads these frames."""

import argparse
import dataclasses as dc

from rich.console import Console

from remosplat_drake.base.errors import FieldError
from remosplat_drake.base.kept_stages import NOTHING_KEPT, KeptStages
from remosplat_drake.base.resources import resolve
from remosplat_drake.capture.capture import Capture
from remosplat_drake.capture.formats import (
    FORMATS,
    ReadingConfig,
    Report,
    read_keyframes,
)
from remosplat_drake.commands.flags import check_positive

TRUTH = "truth.json"
"""Name of the RMMI file with the true geometry of a rendered capture. It is in
the capture's folder."""

KEYFRAMES = 150
"""By default, a command uses at most this many frames of a capture. A map of
this many frames takes minutes to make."""

_MOST_MISSED = 0.01
"""The command prints a warning if the unused frames alone show more than this
fraction of the seen surfaces."""


def add_capture_arguments(parser: argparse.ArgumentParser):
    """Declares the argument CAPTURE, and the flags that select its frames."""
    parser.add_argument(
        "capture", metavar="CAPTURE", help="a file or folder with RGB-D images"
    )
    parser.add_argument(
        "--format",
        metavar="NAME",
        help=f"one of {', '.join(FORMATS)} (default: detected from the"
        " content)",
    )
    parser.add_argument(
        "--stride",
        type=int,
        default=1,
        help="use only every N-th frame (1)",
    )
    parser.add_argument(
        "--keyframes",
        type=int,
        default=KEYFRAMES,
        metavar="N",
        help=(
            "largest number of used frames; sharp frames that together show "
            f"most surfaces are selected; 0 uses all ({KEYFRAMES})"
        ),
    )
    parser.add_argument(
        "--max-depth",
        type=float,
        metavar="Z",
        help="largest depth that is used [m]; pixels with a larger depth count "
        "as unknown",
    )
    parser.add_argument(
        "--max-size",
        type=int,
        metavar="N",
        help="shrink larger images to this width or height [pixels]",
    )


def check_capture_arguments(command: str, arguments: argparse.Namespace):
    """Checks the flags that select a capture's frames.

    Raises:
        FieldError: A flag's number is out of its range.
    """
    check_positive(command, arguments, "stride", "max_depth", "max_size")
    if arguments.keyframes < 0:
        raise FieldError(command, "--keyframes", "must not be negative")


def captured(
    arguments: argparse.Namespace,
    console: Console,
    report: Report = lambda what, done, total: None,
    stages: KeptStages = NOTHING_KEPT,
    counting: str | None = None,
) -> Capture:
    """Reads all frames, or only keyframes, of the command line's capture.

    Args:
        arguments: The command's flags.
        console: Console on which the number of used frames is printed, if some
            frames are unused.
        report: Function that is called with the progress.
        stages: Storage in which the selection of frames is kept.
        counting: Name of a flag on the command line that contains frame
            numbers, which a selection of keyframes would change. None if there
            is no such flag.

    Returns:
        The capture. One of its notes is a warning if its frames omit many of
        the seen surfaces.

    Raises:
        RemoSplatError: The capture cannot be read, or a flag is unusable.
    """
    config = ReadingConfig(
        arguments.stride,
        arguments.keyframes,
        arguments.max_depth,
        arguments.max_size,
    )
    path = resolve(arguments.capture)
    capture, keyframes = read_keyframes(
        path, arguments.format, config, report, stages
    )
    if keyframes is None:
        return capture
    if counting is not None:
        raise FieldError(
            "reconstruct",
            "--keyframes",
            f"would change the frame numbers that {counting} uses; set it to "
            "0 to use all frames, or reduce the number of frames to "
            f"{arguments.keyframes} by --stride",
        )
    if keyframes.missed > _MOST_MISSED:
        note = f"{keyframes.words} (--keyframes N uses more)"
        return dc.replace(capture, notes=(*capture.notes, note))
    words = f"keyframes: {keyframes.words}"
    console.print(words, soft_wrap=True, highlight=False)
    return capture
