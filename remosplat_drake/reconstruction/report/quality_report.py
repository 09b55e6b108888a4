"""`QualityReport`: how far a splat can be trusted, as a file beside it."""

import dataclasses as dc
import hashlib
import json
from pathlib import Path
from typing import Annotated

from annotated_types import Interval, Len

from remosplat_drake.base.atomic_file import write_atomically
from remosplat_drake.base.errors import FieldError, FileError
from remosplat_drake.base.ranges import Config, Coordinate, Position
from remosplat_drake.base.reading import reads_file
from remosplat_drake.base.strict_json import read_json_object
from remosplat_drake.base.strict_yaml import load_strict

MAP_ERROR_MARGIN = 0.002
"""A stopping distance must exceed the map's error by so much [m]."""

CAPTURE, TRUTH = "capture", "truth"
"""What distances are compared with: measured depth, or known geometry."""


Length = Annotated[float, Interval(ge=-1e4, le=1e4)]
Count = Annotated[int, Interval(ge=0, le=10**12)]
Share = Annotated[float, Interval(ge=0, le=1)]


@dc.dataclass
class DistanceErrors(Config):
    """An oracle's distance errors, see `DistanceQuality` [m]."""

    oracle: str = ""
    # `capture` or `truth`.
    reference: str = ""
    count: Count = 0
    median: Length = 0.0
    percentile_99: Length = 0.0
    over: Length = 0.0
    under: Length = 0.0


@dc.dataclass
class ImageScores(Config):
    """Rendered images beside captured ones."""

    # How many views.
    views: Count = 0
    # Whether training did without them.
    held_out: bool = True
    # Means over the views; PSNR in dB.
    psnr: Annotated[float, Interval(ge=-1000, le=1000)] = 0.0
    ssim: Annotated[float, Interval(ge=-1, le=1)] = 0.0
    # Of the absolute depth error of the pixels [m].
    depth_median: Length = 0.0
    depth_percentile_99: Length = 0.0


@dc.dataclass
class FloaterSummary(Config):
    """Splats in space that cameras have looked through."""

    count: Count = 0
    # Largest under-estimate of a distance that one causes [m].
    worst: Length = 0.0
    # Centres in W of up to a hundred, the worst first [m].
    p_WK: list[Position] = dc.field(default_factory=list)


@dc.dataclass
class CoverageSummary(Config):
    """What the cameras saw of the workspace, as fractions of its volume."""

    # The workspace in W [m].
    lower: Annotated[list[Coordinate], Len(0, 3)] = dc.field(
        default_factory=list
    )
    upper: Annotated[list[Coordinate], Len(0, 3)] = dc.field(
        default_factory=list
    )
    free: Share = 0.0
    surface: Share = 0.0
    # Hidden, out of view, or inside things.
    unseen: Share = 0.0


@dc.dataclass
class QualityReport(Config):
    """What was measured of a splat."""

    # How the splat was made.
    method: str = ""
    # SHA-256 of the splat's file.
    splat_digest: str = ""
    splats: Count = 0
    # Views of the capture.
    views: Count = 0
    # How thick the surfaces are that the capture measured: its noise [m].
    scatter: Length = 0.0
    distances: list[DistanceErrors] = dc.field(default_factory=list)
    images: ImageScores = dc.field(default_factory=ImageScores)
    floaters: FloaterSummary = dc.field(default_factory=FloaterSummary)
    coverage: CoverageSummary = dc.field(default_factory=CoverageSummary)
    # Largest over-estimate of a distance by any oracle, by the best
    # reference there is [m].
    map_error: Annotated[float, Interval(ge=0, le=1e4)] = 0.0
    # The verdict in words.
    trust: str = ""


def report_path(splat: Path) -> Path:
    """Where the report of a splat file is."""
    return splat.with_suffix(".quality.json")


def page_path(splat: Path) -> Path:
    """Where the page of a splat file's report is."""
    return splat.with_suffix(".quality.html")


def pose_path(splat: Path) -> Path:
    """Where the pose of the capture's world in the splat's frame is.

    There is no such file where the two frames are the same.
    """
    return splat.with_suffix(".pose.txt")


def write_report(
    splat: Path, report: QualityReport, folder: Path | None = None
):
    """Writes a report beside the splat file that it is about.

    Args:
        splat: The splat file.
        report: Its report, which learns the file's digest.
        folder: Another folder to put it in.

    Raises:
        FileError: The splat cannot be read or the report not written.
    """
    report.splat_digest = file_digest(splat)
    path = report_path(splat)
    text = json.dumps(dc.asdict(report), indent=1) + "\n"
    write_atomically((folder or path.parent) / path.name, text)


@reads_file
def read_report(splat: Path) -> QualityReport:
    """Reads the report of a splat file.

    Raises:
        FileError: It is missing, no report, or one of another splat.
        FieldError: A field is missing, unknown or unusable; names it.
    """
    path = report_path(splat)
    document = read_json_object(path)
    report = load_strict(QualityReport, path)
    for field in dc.fields(QualityReport):
        if field.name not in document:
            raise FieldError(str(path), field.name, "is missing")
    if report.splat_digest != file_digest(splat):
        raise FileError(
            path,
            f"is about another splat than {splat.name};"
            " make it anew with `remosplat quality`",
        )
    return report


def file_digest(path: Path) -> str:
    """SHA-256 of a file's bytes.

    Raises:
        FileError: It cannot be read.
    """
    try:
        return hashlib.sha256(path.read_bytes()).hexdigest()
    except OSError as error:
        raise FileError(path, error.strerror or str(error)) from error


def judge(report: QualityReport) -> str:
    """The verdict on a report: what distances may be relied on, and where."""
    reference = reference_of(report)
    judged = [d for d in report.distances if d.reference == reference]
    usual = max(d.percentile_99 for d in judged)
    stop = report.map_error + MAP_ERROR_MARGIN
    verdict = (
        f"Distances are right to {rounded_up(usual)} (99 %), over-estimates up"
        f" to {rounded_up(report.map_error)}: stopping distances from"
        f" {rounded_up(stop)} on are safe here."
    )
    if reference == TRUTH:
        verdict += " This is against the true geometry."
    if reference == CAPTURE:
        verdict += (
            " The true geometry is unknown: this is against the capture's own"
            f" depth, whose surfaces scatter by {rounded_up(report.scatter)}."
        )
    if report.floaters.count:
        verdict += (
            f" {report.floaters.count} floaters make distances too small, by"
            f" up to {rounded_up(report.floaters.worst)}."
        )
    return verdict + (
        f" No camera has seen {100 * report.coverage.unseen:.0f} % of the"
        " workspace: nothing is known there."
    )


def reference_of(report: QualityReport) -> str:
    """The best reference that a report compares distances with."""
    known = {d.reference for d in report.distances}
    return TRUTH if TRUTH in known else CAPTURE


def rounded_up(length: float) -> str:
    """A length in words; tenths of a millimetre matter below 1 cm."""
    # Whole micrometres first: what is 6 mm but for rounding stays 6 mm.
    tenths = -(-round(1e6 * length) // 100)
    return f"{tenths / 10:.1f} mm" if tenths < 100 else f"{-(-tenths // 10)} mm"
