"""`inspect_capture`: measures a capture, and finds its problems."""

import dataclasses as dc

import numpy as np

from remosplat_drake.capture.capture import Capture
from remosplat_drake.capture.checks.contradictions import (
    contradicting_frames,
    judge_motion,
)
from remosplat_drake.capture.checks.exactness import (
    judge_exactness,
    judge_exchange,
)
from remosplat_drake.capture.checks.findings import (
    DEFECT,
    READING,
    WARNING,
    Finding,
)
from remosplat_drake.capture.checks.image_checks import (
    judge_camera,
    judge_depth,
    judge_registration,
    judge_shape,
)
from remosplat_drake.capture.checks.overlap import (
    MIN_AGREEMENT,
    Overlap,
    measure_overlap,
)
from remosplat_drake.capture.checks.pose_checks import (
    judge_overlap,
    judge_path,
)
from remosplat_drake.capture.checks.registration import (
    Registration,
    measure_registration,
)
from remosplat_drake.capture.checks.view_graph import judge_groups
from remosplat_drake.capture.checks.wide_baselines import (
    WideBaselines,
    measure_wide_baselines,
)


@dc.dataclass(frozen=True, eq=False)
class CaptureInspection:
    """Measurements of a capture of n frames, and its problems.

    Attributes:
        frames: Number of frames n.
        size: Height and width of the images [pixels].
        focal: Smallest and largest focal length along x or y of any frame
            [pixels].
        fov_deg: Median horizontal and vertical field of view [deg].
        depth: Percentiles 1, 50 and 99 of the known depths [m]; NaN if there
            are none.
        known: Fraction of the pixels that have a depth.
        hidden: Fraction of the pixels that do not show the scene.
        path_length: Length of the camera's path from frame to frame [m].
        extent: Sides of the box around the camera's positions, shape (3,) [m].
        registration: Registration of colour and depth; None if there is too
            little data.
        overlap: Agreement between the depths of neighbouring frames.
        wide: Disagreement of near and of distant frames on shared surfaces.
        wrong_frames: Indices of the frames that disagree with all frames that
            have a large overlap with them.
        findings: All problems, defects first.
    """

    frames: int
    size: tuple[int, int]
    focal: tuple[float, float]
    fov_deg: tuple[float, float]
    depth: tuple[float, float, float]
    known: float
    hidden: float
    path_length: float
    extent: np.ndarray
    registration: Registration | None
    overlap: Overlap
    wide: WideBaselines
    wrong_frames: np.ndarray
    findings: tuple[Finding, ...]

    @property
    def defects(self) -> tuple[Finding, ...]:
        """Problems that would make a wrong map."""
        return tuple(f for f in self.findings if f.severity == DEFECT)


def inspect_capture(capture: Capture) -> CaptureInspection:
    """Measures a capture, and finds its problems.

    Args:
        capture: A capture of at least one frame.
    """
    height, width = capture.size
    focal = capture.K[:, (0, 1), (0, 1)]
    fov = np.rad2deg(2 * np.arctan2([width, height], 2 * np.median(focal, 0)))
    depths = capture.depth[capture.depth > 0]
    p_WC = capture.X_WC[:, :3, 3]
    path_length = np.linalg.norm(np.diff(p_WC, axis=0), axis=1).sum()
    overlap = measure_overlap(capture)
    wide = measure_wide_baselines(capture)
    wrong = contradicting_frames(wide)
    registration = measure_registration(capture)
    known = float((capture.depth > 0).mean())
    percentiles = (
        np.percentile(depths, (1, 50, 99)) if len(depths) else [np.nan] * 3
    )
    camera_findings = judge_camera(capture, fov)
    exchanged = [] if camera_findings else judge_exchange(capture, wide)
    pose_findings = exchanged or judge_overlap(capture, overlap, wrong)
    if not pose_findings:
        # If poses are wrong, the checks below would only report this problem
        # again.
        pose_findings = _judge_shared_surfaces(capture, overlap, wide)
    mended = any(finding.repair for finding in pose_findings)
    findings = (
        *(Finding(READING, note, WARNING) for note in capture.notes),
        *camera_findings,
        *judge_depth(capture, float(percentiles[1])),
        *judge_path(float(np.ptp(p_WC, axis=0).max())),
        *pose_findings,
        # Depths of another frame do not match the colours, either.
        *(() if mended else judge_registration(capture, registration)),
    )
    return CaptureInspection(
        frames=len(capture),
        size=capture.size,
        focal=(float(focal.min()), float(focal.max())),
        fov_deg=(float(fov[0]), float(fov[1])),
        depth=tuple(float(x) for x in percentiles),  # pyright: ignore
        known=known,
        hidden=0.0 if capture.hidden is None else float(capture.hidden.mean()),
        path_length=float(path_length),
        extent=np.ptp(p_WC, axis=0),
        registration=registration,
        overlap=overlap,
        wide=wide,
        wrong_frames=wrong,
        findings=tuple(sorted(findings, key=lambda f: f.severity != DEFECT)),
    )


def _judge_shared_surfaces(
    capture: Capture, overlap: Overlap, wide: WideBaselines
) -> list[Finding]:
    """Compares the surfaces of views whose poses seem right."""
    agreeing = overlap.pairs[overlap.agreements >= MIN_AGREEMENT]
    pairs = np.concatenate([agreeing, wide.pairs[wide.compared]])
    return [
        *judge_exactness(capture, wide),
        *judge_motion(capture, wide),
        *judge_groups(capture, pairs),
        *judge_shape(capture),
    ]
