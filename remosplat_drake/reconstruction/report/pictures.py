"""Pairs of a captured view and the splat's image from the same camera."""

import dataclasses as dc
from collections.abc import Sequence

import numpy as np

from remosplat_drake.capture.capture import Capture
from remosplat_drake.reconstruction.report.image_quality import (
    psnr,
    structural_similarity,
)
from remosplat_drake.reconstruction.report.quality_report import ImageScores
from remosplat_drake.reconstruction.report.splat_image import (
    SplatImage,
    SplatRenderer,
)
from remosplat_drake.splat.gaussian_splat import GaussianSplat

_BEST_PSNR = 99.0  # Of equal images; JSON has no infinity [dB].


@dc.dataclass(frozen=True, eq=False)
class Picture:
    """A captured view and the splat's image from the same camera.

    Attributes:
        view: Index of the view in the capture.
        rendered: The splat's image from the same camera.
        rgb: The captured sRGB colours, shape (h, w, 3), uint8.
        depth: The captured depth, shape (h, w) [m]; 0 where unknown.
    """

    view: int
    rendered: SplatImage
    rgb: np.ndarray
    depth: np.ndarray

    @property
    def depth_error(self) -> np.ndarray:
        """Rendered minus captured depth, (h, w) [m]; NaN where one is 0."""
        known = (self.depth > 0) & (self.rendered.depth > 0)
        return np.where(known, self.rendered.depth - self.depth, np.nan)


def draw_pictures(
    splat_W: GaussianSplat, capture: Capture, compared: Sequence[int]
) -> tuple[Picture, ...]:
    """Renders a splat from some views of a capture.

    Args:
        splat_W: The splat, in the capture's world frame.
        capture: Posed RGB-D images.
        compared: Indices of the views.
    """
    renderer = SplatRenderer(splat_W)
    return tuple(
        Picture(
            int(i),
            renderer.render(capture.K[i], capture.X_WC[i], capture.size),
            capture.rgb[i],
            capture.depth[i],
        )
        for i in compared
    )


def score_pictures(
    pictures: tuple[Picture, ...], capture: Capture, held_out: bool
) -> ImageScores:
    """Computes mean scores of rendered views; hidden pixels do not count.

    Args:
        pictures: The views.
        capture: The capture of these views.
        held_out: Whether these views were not used for training.
    """
    ratios, similarities, depth_errors = [], [], []
    for picture in pictures:
        hidden = (
            None if capture.hidden is None else capture.hidden[picture.view]
        )
        rendered = np.clip(picture.rendered.color, 0, 1)
        captured = picture.rgb / 255.0
        ratio = psnr(rendered, captured, hidden)
        ratios.append(min(ratio, _BEST_PSNR))
        similarities.append(structural_similarity(rendered, captured, hidden))
        error = picture.depth_error
        depth_errors.append(np.abs(error[np.isfinite(error)]))
    depth_error = np.concatenate(depth_errors)
    median, percentile = (
        np.percentile(depth_error, [50, 99]) if len(depth_error) else (0, 0)
    )
    return ImageScores(
        views=len(pictures),
        held_out=held_out,
        psnr=_mean(ratios),
        ssim=_mean(similarities),
        depth_median=float(median),
        depth_percentile_99=float(percentile),
    )


def _mean(scores: list[float]) -> float:
    """Mean over the views that have a value; 0 if none has one."""
    known = [score for score in scores if np.isfinite(score)]
    return float(np.mean(known)) if known else 0.0
