"""Flags, progress and result table of the refinement of camera poses."""

import argparse
from functools import partial

from rich.console import Console
from rich.table import Table

from remosplat_drake.base.errors import FieldError
from remosplat_drake.base.kept_stages import KeptStages
from remosplat_drake.base.progress import Progress
from remosplat_drake.capture.capture import Capture
from remosplat_drake.commands.flags import check_positive
from remosplat_drake.reconstruction.alignment.alignment import Alignment, align
from remosplat_drake.reconstruction.alignment.camera_errors import CameraPrior
from remosplat_drake.reconstruction.alignment.measured_length import Length
from remosplat_drake.reconstruction.alignment.refinement import AlignmentConfig
from remosplat_drake.reconstruction.alignment.summary import (
    AlignmentSummary,
    summarize_alignment,
)

_LENGTH = ("FRAME", "U", "V", "FRAME", "U", "V", "METRES")


def add_alignment_arguments(parser: argparse.ArgumentParser):
    """Declares the flags of the refinement of camera poses."""
    group = parser.add_argument_group("cameras")
    group.add_argument(
        "--align",
        choices=("auto", "off"),
        default="auto",
        help=(
            "auto: refine camera poses and the scale of depths, and keep the "
            "result if the views then agree better with each other (default: "
            "auto)"
        ),
    )
    group.add_argument(
        "--camera",
        choices=("auto", "exact"),
        default="auto",
        help=(
            "auto: with --align, also refine the camera parameters that all "
            "images share: focal length, lens distortion, delay, read-out "
            "time and mount. exact: refine only scale and offset of the "
            "depths (default: auto)"
        ),
    )
    group.add_argument(
        "--depth-scale-std",
        type=float,
        default=CameraPrior.scale,
        metavar="S",
        help=(
            "standard deviation of the depth sensor's scale, from its "
            f"specification ({CameraPrior.scale:g})"
        ),
    )
    group.add_argument(
        "--length",
        type=float,
        nargs=7,
        action="append",
        default=[],
        metavar=_LENGTH,
        help=(
            "measured distance between two points, each given by a frame and a "
            "pixel (column U, row V); it determines the scale; may be "
            "repeated"
        ),
    )


def check_alignment(arguments: argparse.Namespace):
    """Checks the flags of the refinement of camera poses.

    Raises:
        FieldError: The standard deviation is out of range, or a length has an
            invalid frame, pixel or distance.
    """
    check_positive("reconstruct", arguments, "depth_scale_std")
    if arguments.depth_scale_std > 1:
        problem = "must be a fraction of the depth, at most 1"
        raise FieldError("reconstruct", "--depth-scale-std", problem)
    for values in arguments.length:
        if any(value != int(value) or value < 0 for value in values[:6]):
            problem = "needs whole numbers from 0 for frames and pixels"
            raise FieldError("reconstruct", "--length", problem)
        if not 0 < values[6] < 1e4:
            problem = "must end in a length > 0 [m]"
            raise FieldError("reconstruct", "--length", problem)


def aligned(
    capture: Capture,
    arguments: argparse.Namespace,
    console: Console,
    stages: KeptStages,
) -> tuple[Alignment | None, AlignmentSummary | None]:
    """Refines a capture's cameras as the flags require; prints the result."""
    if arguments.align == "off":
        return None, None
    scale = arguments.depth_scale_std
    exact = arguments.camera == "exact"
    config = AlignmentConfig(
        camera=CameraPrior.exact(scale) if exact else CameraPrior(scale=scale),
        lengths=tuple(_length(values) for values in arguments.length),
        seed=arguments.seed,
    )
    what = "aligning the views"
    with Progress(console, what) as progress:
        alignment = stages.kept(
            "refined cameras",
            Alignment,
            [capture, config],
            lambda: align(capture, config, partial(progress.report, what)),
        )
    summary = summarize_alignment(alignment, capture.X_WC)
    print_alignment(console, summary)
    return alignment, summary


def _length(values: list[float]) -> Length:
    a, ua, va, b, ub, vb = (int(value) for value in values[:6])
    return Length((a, b), ((ua, va), (ub, vb)), values[6])


def print_alignment(console: Console, summary: AlignmentSummary):
    """Prints the residuals between views, and the corrections to the camera."""
    table = Table(title="distances of points from other views' surfaces [mm]")
    for heading in ("distance of views [m]", "pairs", "median", "95 %"):
        table.add_column(heading, justify="right")
    for row in summary.rows:
        before = row.median_before, row.high_before
        after = row.median_after, row.high_after
        table.add_row(
            f"{row.nearest:.2f} to {row.farthest:.2f}",
            str(row.pairs),
            *(
                f"{1e3 * old:.1f} → {1e3 * new:.1f}"
                for old, new in zip(before, after, strict=True)
            ),
        )
    console.print(table)
    console.print(summary.words, soft_wrap=True)
