"""`QualityReport`: errors and verdict of a splat, in a file beside it."""

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
from remosplat_drake.reconstruction.alignment.alignment_summary import (
    AlignmentSummary,
)

MAP_ERROR_MARGIN = 0.002
"""A stopping distance must exceed the map's error by at least this [m]."""

CAPTURE, HELD_OUT, TRUTH = "capture", "held-out views", "truth"
"""References of distances: measured depth, depth of held-out views, or known
geometry."""

ELLIPSOIDS, DEPTH_VIEWS = "sphere-to-ellipsoid", "depth rasterisation"
"""Names of the oracles that are judged."""


Length = Annotated[float, Interval(ge=-1e4, le=1e4)]
"""A length, or a difference of lengths [m]."""
Count = Annotated[int, Interval(ge=0, le=10**12)]
"""A count."""
Share = Annotated[float, Interval(ge=0, le=1)]
"""A fraction from 0 to 1."""


@dc.dataclass
class DistanceErrors(Config):
    """Distance errors of one oracle against one reference."""

    # Name of the oracle.
    oracle: str = ""
    # Reference of the distances: `capture`, `held-out views` or `truth`.
    reference: str = ""
    # Number of points.
    count: Count = 0
    # Median of the absolute error [m].
    median: Length = 0.0
    # 99th percentile of the absolute error [m].
    percentile_99: Length = 0.0
    # Largest over-estimate, which hides an obstacle [m].
    over: Length = 0.0
    # Largest under-estimate, which invents an obstacle [m].
    under: Length = 0.0
    # Over-estimates after subtraction of the splats' uncertainty [m]; None: not
    # measured.
    remaining: Length | None = None
    # Fraction of the points at which no distance is too large after subtraction
    # of the uncertainty.
    covered: Share = 0.0


@dc.dataclass
class ImageScores(Config):
    """Quality of rendered images, compared with captured ones."""

    # Number of views.
    views: Count = 0
    # Whether these views were not used for training.
    held_out: bool = True
    # Mean peak signal-to-noise ratio of the views [dB].
    psnr: Annotated[float, Interval(ge=-1000, le=1000)] = 0.0
    # Mean structural similarity (SSIM) of the views.
    ssim: Annotated[float, Interval(ge=-1, le=1)] = 0.0
    # Median of the pixels' absolute depth error [m].
    depth_median: Length = 0.0
    # 99th percentile of the pixels' absolute depth error [m].
    depth_percentile_99: Length = 0.0


@dc.dataclass
class FloaterSummary(Config):
    """Floaters: splats in space that cameras have seen as free."""

    # Number of floaters.
    count: Count = 0
    # Largest under-estimate of a distance that a floater causes [m].
    worst: Length = 0.0
    # Centres in W of up to a hundred floaters, the worst first [m].
    p_WK: list[Position] = dc.field(default_factory=list)


@dc.dataclass
class CoverageSummary(Config):
    """Fractions of the workspace's volume that are free, surface and unseen."""

    # Lower corner of the workspace in W [m].
    lower: Annotated[list[Coordinate], Len(0, 3)] = dc.field(
        default_factory=list
    )
    # Upper corner of the workspace in W [m].
    upper: Annotated[list[Coordinate], Len(0, 3)] = dc.field(
        default_factory=list
    )
    # # Fraction that cameras have seen as free.
    free: Share = 0.0
    # Fraction that holds a measured surface.
    surface: Share = 0.0
    # Fraction that is hidden, out of view, or inside objects.
    unseen: Share = 0.0


@dc.dataclass
class QualityReport(Config):
    """Measurements of a splat's quality, with the verdict."""

    # Description of how the splat was made.
    method: str = ""
    # SHA-256 digest of the splat's file, in hex.
    splat_digest: str = ""
    # Number of splats.
    splats: Count = 0
    # Number of views of the capture.
    views: Count = 0
    # Thickness of the measured surfaces: the noise of the capture [m].
    scatter: Length = 0.0
    # Distance errors of each oracle against each reference.
    distances: list[DistanceErrors] = dc.field(default_factory=list)
    # Quality of rendered images.
    images: ImageScores = dc.field(default_factory=ImageScores)
    # Floaters in the workspace.
    floaters: FloaterSummary = dc.field(default_factory=FloaterSummary)
    # Coverage of the workspace.
    coverage: CoverageSummary = dc.field(default_factory=CoverageSummary)
    # Refinement of the cameras; None: they were not refined.
    alignment: AlignmentSummary | None = None
    # Map error [m]: the largest over-estimate of a distance by any oracle,
    # relative to the best available reference, or the splats' own uncertainty
    # if it is larger.
    map_error: Annotated[float, Interval(ge=0, le=1e4)] = 0.0
    # Problems of the capture that were accepted or only warned of.
    warnings: list[str] = dc.field(default_factory=list)
    # Largest uncertainty of a splat in the workspace [m]; 0: splats have none.
    uncertainty: Annotated[float, Interval(ge=0, le=1e4)] = 0.0
    # Part of `map_error` that remains if distances to ellipsoids subtract this
    # uncertainty [m]. `distances` contains the remaining part for depth views.
    remaining_error: Annotated[float, Interval(ge=0, le=1e4)] = 0.0
    # The verdict in words.
    trust: str = ""


def report_path(splat: Path) -> Path:
    """Returns the path of a splat file's report."""
    return splat.with_suffix(".quality.json")


def page_path(splat: Path) -> Path:
    """Returns the path of the HTML page of a splat file's report."""
    return splat.with_suffix(".quality.html")


def pose_path(splat: Path) -> Path:
    """Returns the path of the file with the capture's pose in the splat.

    There is no such file if the two frames are the same.
    """
    return splat.with_suffix(".pose.txt")


def write_report(
    splat: Path, report: QualityReport, folder: Path | None = None
):
    """Writes a splat file's report.

    Args:
        splat: The splat file.
        report: The report, into which the file's digest is written.
        folder: Folder for the report; None: the splat's folder.

    Raises:
        FileError: The splat cannot be read or the report not written.
    """
    report.splat_digest = file_digest(splat)
    path = report_path(splat)
    text = json.dumps(dc.asdict(report), indent=1) + "\n"
    write_atomically((folder or path.parent) / path.name, text)


@reads_file
def read_report(splat: Path) -> QualityReport:
    """Reads a splat file's report.

    Raises:
        FileError: The report is missing, the file is not a report, or it
            belongs to another splat.
        FieldError: A field is missing, unknown or unusable; the error names it.
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
            f"belongs to another splat than {splat.name}; create it again with "
            "`remosplat quality`",
        )
    return report


def file_digest(path: Path) -> str:
    """Computes the SHA-256 digest of a file's bytes, in hex.

    Raises:
        FileError: The file cannot be read.
    """
    try:
        with path.open("rb") as stream:
            return hashlib.file_digest(stream, "sha256").hexdigest()
    except OSError as error:
        raise FileError(path, error.strerror or str(error)) from error


def judge(report: QualityReport) -> str:
    """Formats the verdict: errors of distances, and safe stopping distances."""
    reference = reference_of(report)
    judged = [d for d in report.distances if d.reference == reference]
    usual = max(d.percentile_99 for d in judged)
    over, rest = report.map_error, report.map_error
    views = rest
    if report.uncertainty:
        over = max(d.over for d in judged)
        rest = report.remaining_error
        views = remaining_of(report, DEPTH_VIEWS)
    stop = rest + MAP_ERROR_MARGIN
    verdict = (
        f"99 % of the distances have an error of at most {rounded_up(usual)};"
        f" the largest over-estimate is {rounded_up(over)}."
    )
    if report.uncertainty:
        verdict += (
            " Splats with less data have an uncertainty of up to"
            f" {rounded_up(report.uncertainty)}, which oracles subtract."
        )
    least = rounded_up(stop)
    verdict += f" Stopping distances of {least} or more are safe here"
    if views > rest:
        least = rounded_up(views + MAP_ERROR_MARGIN)
        verdict += f"; with depth views, of {least} or more"
    verdict += "."
    if reference == TRUTH:
        verdict += " Errors are measured against the true geometry."
    if reference == HELD_OUT:
        verdict += (
            " The true geometry is unknown: errors are those of a map that "
            "was made from three quarters of the views, at surfaces that the "
            "remaining views show."
        )
    if reference == CAPTURE:
        verdict += (
            " The true geometry is unknown: errors are relative to the"
            " capture's own depth, whose surfaces scatter by"
            f" {rounded_up(report.scatter)}."
        )
    if report.floaters.count:
        verdict += (
            f" {report.floaters.count} floaters make distances too small, by"
            f" up to {rounded_up(report.floaters.worst)}."
        )
    verdict += (
        f" No camera has seen {100 * report.coverage.unseen:.0f} % of the"
        " workspace: its surfaces there are unknown."
    )
    if report.warnings:
        doubts = "; ".join(report.warnings)
        verdict += (
            " The capture has problems, so these numbers may be wrong:"
            f" {doubts}."
        )
    return verdict


def reference_of(report: QualityReport) -> str:
    """Returns the best reference of distances in a report."""
    known = {d.reference for d in report.distances}
    return next(
        r for r in (TRUTH, HELD_OUT, CAPTURE) if r in known or r == CAPTURE
    )


def remaining_of(report: QualityReport, oracle: str) -> float:
    """Returns the map error that remains in an oracle's distances [m].

    Args:
        report: The report of a map.
        oracle: Name of an oracle. An oracle subtracts the splats' uncertainty
            from its distances; the result is the part of the map error that
            remains.
    """
    best = reference_of(report)
    for row in report.distances:
        is_asked = (row.reference, row.oracle) == (best, oracle)
        if is_asked and row.remaining is not None:
            return max(row.remaining, 0.0)
    return report.remaining_error


def rounded_up(length: float) -> str:
    """Formats a length, rounded up to 1 mm, or below 1 cm to 0.1 mm."""
    # Rounded to micrometres first, so that 6 mm with a rounding error stay 6
    # mm.
    tenths = -(-round(1e6 * length) // 100)
    return f"{tenths / 10:.1f} mm" if tenths < 100 else f"{-(-tenths // 10)} mm"
