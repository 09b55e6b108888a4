"""`remosplat capture-info`: describes a capture and finds its defects."""

import argparse
from pathlib import Path

import numpy as np

from remosplat_drake.base.atomic_file import check_writable
from remosplat_drake.base.progress import Progress
from remosplat_drake.base.resources import resolve
from remosplat_drake.base.table import Table
from remosplat_drake.capture.checks.findings import list_frames
from remosplat_drake.capture.checks.inspection import (
    CaptureInspection,
    inspect_capture,
)
from remosplat_drake.capture.checks.overlap import TOLERANCE
from remosplat_drake.capture.formats import detect_format
from remosplat_drake.commands.capture_admission import tell_findings
from remosplat_drake.commands.capture_flags import (
    add_capture_arguments,
    captured,
    check_capture_arguments,
)
from remosplat_drake.commands.json_output import add_json_argument, print_json
from remosplat_drake.commands.tables import open_console, print_table

WRONG = 1
"""Exit code if the capture has a problem."""

EXAMPLES = """
remosplat capture-info my_capture
remosplat capture-info my_capture --picture frames.png
"""
"""Examples at the end of `--help`."""


def add_arguments(parser: argparse.ArgumentParser):
    """Declares the command's flags."""
    add_capture_arguments(parser)
    parser.add_argument(
        "--picture",
        type=Path,
        metavar="FILE.png",
        help="write a picture of the frames, and of the cameras seen from "
        "above, to this file",
    )
    add_json_argument(parser)


def run(arguments: argparse.Namespace) -> int:
    """Reads, checks and describes the capture."""
    check_capture_arguments("capture-info", arguments)
    if arguments.picture:
        check_writable(arguments.picture)
    console = open_console(stderr=arguments.json)
    path = resolve(arguments.capture)
    arguments.format = arguments.format or detect_format(path)
    with Progress(console, "reading the capture") as progress:
        capture = captured(arguments, console, progress.report)
        progress.report("inspecting the capture")
        inspection = inspect_capture(capture)
    if arguments.json:
        print_json(_document(path, arguments.format, inspection))
    else:
        title = f"{path} ({arguments.format})"
        rows = tuple(_rows(inspection))
        print_table(console, Table(title, ("", ""), rows, texts=2))
        tell_findings(console, inspection.findings)
        if not inspection.findings:
            console.print("[green]no problem found[/green]")
    if arguments.picture:
        from remosplat_drake.capture.picture import draw_capture
        from remosplat_drake.visualization.depth_views import save_picture

        save_picture(
            draw_capture(capture, str(path), inspection.wrong_frames),
            arguments.picture,
        )
        console.print(f"picture in {arguments.picture}")
    return WRONG if inspection.findings else 0


def _document(path: Path, kind: str, inspection: CaptureInspection) -> dict:
    """Makes the document of `--json` about a capture."""
    height, width = inspection.size
    near, median, far = inspection.depth
    registration, overlap = inspection.registration, inspection.overlap
    return {
        "capture": path,
        "format": kind,
        "frames": inspection.frames,
        "width": width,
        "height": height,
        "focal": inspection.focal,
        "fov_deg": inspection.fov_deg,
        "depth": {"percentile_1": near, "median": median, "percentile_99": far},
        "known": inspection.known,
        "hidden": inspection.hidden,
        "path_length": inspection.path_length,
        "extent": inspection.extent,
        "registration": registration
        and {
            "shift": registration.shift,
            "correlation": registration.correlation,
        },
        "overlap": {
            "pairs": len(overlap),
            "agreement": overlap.agreement,
            "median": overlap.median,
        },
        "wrong_frames": inspection.wrong_frames,
        "findings": [
            {
                "name": finding.name,
                "severity": finding.severity,
                "problem": finding.problem,
                "frames": finding.frames,
                "remedy": finding.remedy,
            }
            for finding in inspection.findings
        ],
    }


def _rows(inspection: CaptureInspection) -> list[tuple[str, str]]:
    height, width = inspection.size
    low, high = inspection.focal
    focal = f"{low:.1f}" if high - low < 0.1 else f"{low:.1f} to {high:.1f}"
    near, median, far = inspection.depth
    sides = " x ".join(f"{x:.2f}" for x in inspection.extent)
    right, up = inspection.fov_deg
    return [
        ("frames", f"{inspection.frames} of {width}x{height} pixels"),
        ("focal length", f"{focal} pixels"),
        ("field of view", f"{right:.1f} x {up:.1f} degrees"),
        (
            "depth",
            f"{near:.2f} to {far:.2f} m (98 % of it), median {median:.2f} m",
        ),
        ("known depth", f"{100 * inspection.known:.1f} % of the pixels"),
        ("hidden", f"{100 * inspection.hidden:.1f} % of the pixels"),
        (
            "camera path",
            f"{inspection.path_length:.2f} m long, in a box of {sides} m",
        ),
        ("colour on depth", _registration(inspection)),
        ("overlap", _overlap(inspection)),
        (
            "wrong frames",
            list_frames(inspection.wrong_frames)
            if len(inspection.wrong_frames)
            else "none",
        ),
    ]


def _registration(inspection: CaptureInspection) -> str:
    registration = inspection.registration
    if registration is None:
        return "too few edges to compare colour and depth"
    right, down = registration.shift
    return (
        "edges of colour and depth match best if the depth image is shifted "
        f"by {right:+d}, {down:+d} pixels (correlation "
        f"{registration.correlation:.2f})"
    )


def _overlap(inspection: CaptureInspection) -> str:
    overlap = inspection.overlap
    if np.isnan(overlap.agreement):
        return "no two frames show the same surface"
    return (
        f"{len(overlap)} pairs of frames; their depths differ by"
        f" {1e3 * overlap.median:.1f} mm (median),"
        f" {100 * overlap.within(0.01):.0f} % by less than 10 mm,"
        f" {100 * overlap.agreement:.0f} % by less than"
        f" {100 * TOLERANCE:.0f} %"
    )
