"""Formats a quality report as one HTML page that contains its pictures."""

import html
from pathlib import Path

import numpy as np

from remosplat_drake.base.atomic_file import write_atomically
from remosplat_drake.base.html_report import cards, make_page
from remosplat_drake.base.table import Table
from remosplat_drake.reconstruction.report.assessment import Assessment
from remosplat_drake.reconstruction.report.pictures import Picture
from remosplat_drake.reconstruction.report.quality_report import (
    QualityReport,
    page_path,
    rounded_up,
    write_report,
)
from remosplat_drake.reconstruction.report.report_pictures import (
    color_image,
    coverage_slices,
    depth_error_image,
    depth_error_limit,
    depth_image,
    error_histogram,
)

_MAX_VIEWS = 6
_CAPTIONS = (
    "captured",
    "rendered",
    "captured depth",
    "rendered depth",
    "depth error",
)

_STYLE = """
.view { display: grid; grid-template-columns: repeat(5, 1fr); gap: .35em;
        margin: 0 0 .35em; }
.captions { color: var(--soft); font-size: .85em; font-weight: 600; }
img { display: block; width: 100%; border-radius: .2em; }
.plot { margin-top: 1.4em; }
"""
"""Style sheet (CSS) of the pictures, in addition to that of all reports."""


def to_html(assessment: Assessment, title: str) -> str:
    """Makes one self-contained HTML page of an assessment.

    Args:
        assessment: The assessment.
        title: Heading, such as the splat's name.
    """
    report = assessment.report
    body = "\n".join(
        [
            f'<p class="method">{html.escape(report.method)} ·'
            f" {report.splats:,} splats · {report.views} views</p>",
            f'<p class="trust">{html.escape(report.trust)}</p>',
            _warnings(report),
            cards(_numbers(report)),
            _distances(assessment),
            _views(assessment),
            _coverage(assessment),
            _floaters(report),
            _camera(report),
        ]
    )
    return make_page(title, body, _STYLE)


def write_assessment(
    splat: Path, assessment: Assessment, folder: Path | None = None
) -> Path:
    """Writes an assessment of a splat as NAME.quality.json and .quality.html.

    Args:
        splat: The splat file that the assessment is about.
        assessment: The assessment.
        folder: Folder for both files; None: the splat's folder.

    Returns:
        The path of the page.

    Raises:
        FileError: The splat cannot be read or a file not written.
    """
    write_report(splat, assessment.report, folder)
    page = (folder or splat.parent) / page_path(splat).name
    write_atomically(page, to_html(assessment, splat.name))
    return page


def _warnings(report: QualityReport) -> str:
    items = "".join(f"<li>{html.escape(w)}</li>" for w in report.warnings)
    if not items:
        return ""
    return f'<ul class="warnings">{items}</ul>'


def _numbers(report: QualityReport) -> dict[str, str]:
    images = report.images
    return {
        "largest over-estimate of a distance": rounded_up(report.map_error),
        "median depth error of the pixels": _mm(images.depth_median),
        "PSNR": f"{images.psnr:.1f} dB",
        "SSIM": f"{images.ssim:.3f}",
        "floaters": str(report.floaters.count),
        "of the workspace never seen": f"{100 * report.coverage.unseen:.0f} %",
    }


def _distances(assessment: Assessment) -> str:
    names = {"capture": "the capture's depth", "truth": "the true geometry"}
    table = Table(
        "",
        (
            "oracle",
            "against",
            "points",
            "median",
            "99 %",
            "over by up to",
            "under by up to",
        ),
        tuple(
            (
                d.oracle,
                names.get(d.reference, d.reference),
                f"{d.count:,}",
                *map(_mm, (d.median, d.percentile_99, d.over, d.under)),
            )
            for d in assessment.report.distances
        ),
        texts=2,
    )
    return (
        "<h2>Distances</h2>\n"
        "<p>At random points of the workspace that cameras have seen as"
        " free, 3 to 50 cm from the nearest surface. An over-estimate hides"
        " an obstacle; an under-estimate invents one. The capture's own depth"
        " contains only seen surfaces, which scatter by"
        f" {_mm(assessment.report.scatter)}.</p>\n"
        f"{table.to_html()}"
        f'<div class="plot">{error_histogram(assessment.errors)}</div>\n'
        "<p>Right of 0 an obstacle seems farther than it is. The outermost"
        " bars contain all larger errors.</p>"
    )


def _views(assessment: Assessment) -> str:
    images = assessment.report.images
    used = (
        "that the splat was made without"
        if images.held_out
        else "that the splat may have been made from"
    )
    pictures = assessment.pictures
    shown = np.unique(
        np.linspace(0, len(pictures) - 1, _MAX_VIEWS).round().astype(int)
    )
    limit = depth_error_limit([picture.depth_error for picture in pictures])
    rows = "\n".join(_view(pictures[i], limit) for i in shown.tolist())
    captions = "".join(f"<span>{caption}</span>" for caption in _CAPTIONS)
    return (
        "<h2>Captured and rendered</h2>\n"
        f"<p>{len(shown)} of {images.views} views {used}. Over all"
        f" {images.views} views, the PSNR is {images.psnr:.1f} dB and the SSIM"
        f" {images.ssim:.3f}. The depth error is {_mm(images.depth_median)} in"
        f" the median, and at most {_mm(images.depth_percentile_99)} at 99 % of"
        " the pixels. In the images of depth errors, blue is too near, red is"
        " too far, and white is correct; full colour is an error of"
        f" {100 * limit:.0f} cm, and grey is unknown.</p>\n"
        f'<div class="view captions">{captions}</div>\n{rows}'
    )


def _view(picture: Picture, limit: float) -> str:
    depths = picture.depth[picture.depth > 0]
    limits = np.percentile(depths, [1, 99]) if len(depths) else (0, 1)
    sources = (
        color_image(picture.rgb / 255.0),
        color_image(picture.rendered.color),
        depth_image(picture.depth, limits),
        depth_image(picture.rendered.depth, limits),
        depth_error_image(picture.depth_error, limit),
    )
    images = "".join(
        f'<img alt="view {picture.view}: {caption}" src="{source}">'
        for caption, source in zip(_CAPTIONS, sources, strict=True)
    )
    return f'<div class="view">{images}</div>'


def _coverage(assessment: Assessment) -> str:
    coverage = assessment.report.coverage
    return (
        "<h2>What the cameras have seen</h2>\n"
        f"<p>Of the workspace, {100 * coverage.free:.0f} % was seen to be free,"
        f" {100 * coverage.surface:.0f} % is surface and"
        f" {100 * coverage.unseen:.0f} % was never seen: out of view, hidden,"
        " or inside objects. Slices from above, at heights in W.</p>\n"
        f'<div class="plot">{coverage_slices(assessment.coverage)}</div>'
    )


def _floaters(report: QualityReport) -> str:
    floaters = report.floaters
    if not floaters.count:
        text = (
            "There are none: no splat is in space that two cameras saw as free."
        )
    else:
        worst = ", ".join(
            "({:.2f}, {:.2f}, {:.2f})".format(*p) for p in floaters.p_WK[:5]
        )
        text = (
            f"{floaters.count} splats are in space that at least two cameras"
            " saw as free. Near the worst of them, a distance is"
            f" {_mm(floaters.worst)} too small. The worst are at {worst} m."
        )
    return f"<h2>Floaters</h2>\n<p>{text}</p>"


def _camera(report: QualityReport) -> str:
    alignment = report.alignment
    if alignment is None or not alignment.camera:
        return ""
    table = Table(
        "",
        ("error", "found", "undone"),
        tuple(
            (error.name, str(error), "yes" if error.undone else "no")
            for error in alignment.camera
        ),
    )
    return (
        "<h2>The camera</h2>\n"
        f"<p>{html.escape(alignment.words)}</p>\n{table.to_html()}"
        "<p>Errors that all images share, with one standard deviation. Errors"
        " close to zero are not corrected; the splats' uncertainty includes"
        " them."
        "</p>"
    )


def _mm(length: float) -> str:
    return f"{1e3 * length:.1f} mm"
