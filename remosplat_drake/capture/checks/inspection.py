"""Checks of a capture: does it mean what its reader thinks it means?"""

import dataclasses as dc

import numpy as np

from remosplat_drake.capture.capture import MIN_DEPTH_FRACTION, Capture
from remosplat_drake.capture.checks.overlap import (
    MIN_AGREEMENT,
    Overlap,
    measure_overlap,
    wrong_frames,
)
from remosplat_drake.capture.checks.pose_conventions import (
    GOOD_AGREEMENT,
    find_mistake,
)
from remosplat_drake.capture.checks.registration import (
    Registration,
    measure_registration,
)

_FOV_RANGE = (20.0, 130.0)
"""Fields of view of RGB-D cameras and phones, with some room [deg]."""

_DEPTH_RANGE = (0.1, 10.0)
"""Median depths of what a robot works in [m]."""

_MIN_SUPPORTED = 0.05
"""Views that support fewer of each other's points show different places."""

_MIN_PATH = 0.05
"""A camera that moved less has seen everything from one side [m]."""

_UNITS = (
    (1e3, "millimetres read as metres"),
    (1e-3, "metres read as millimetres"),
    (5.0, "1 / 5000 m read as millimetres"),
    (0.2, "millimetres read as 1 / 5000 m"),
)
"""How many times too large depths are, and the mistake that does it."""


@dc.dataclass(frozen=True, eq=False)
class CaptureInspection:
    """Measurements of a capture of n frames, and what is wrong with it.

    Attributes:
        frames: Number of frames n.
        size: Height and width of the images [pixels].
        focal: Smallest and largest focal length, x and y alike [pixels].
        fov_deg: Median horizontal and vertical field of view [deg].
        depth: Median, and percentiles 1 and 99, of the known depths [m]:
            (p1, median, p99); NaN without any.
        known: Fraction of the pixels that have a depth.
        hidden: Fraction of the pixels that do not show the scene.
        path_length: Length of the camera's path from frame to frame [m].
        extent: Sides of the box around the camera's positions, shape (3,) [m].
        registration: Registration of colour and depth; None if there is too
            little to tell.
        overlap: Agreement of neighbouring frames about depth.
        wrong_frames: Indices of the frames that disagree with all of their
            neighbours.
        warnings: One sentence with numbers for each thing that is wrong.
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
    wrong_frames: np.ndarray
    warnings: tuple[str, ...]


def inspect_capture(capture: Capture) -> CaptureInspection:
    """Measures and judges a capture.

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
    wrong = wrong_frames(overlap)
    registration = measure_registration(capture)
    known = float((capture.depth > 0).mean())
    percentiles = (
        np.percentile(depths, (1, 50, 99)) if len(depths) else [np.nan] * 3
    )
    warnings = (
        *_judge_camera(capture, fov),
        *_judge_depth(known, float(percentiles[1])),
        *_judge_path(float(np.ptp(p_WC, axis=0).max())),
        *_judge_registration(registration),
        *_judge_overlap(capture, overlap, wrong),
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
        wrong_frames=wrong,
        warnings=warnings,
    )


def _judge_camera(capture: Capture, fov_deg: np.ndarray) -> list[str]:
    warnings = []
    low, high = _FOV_RANGE
    if not (low < fov_deg.min() and fov_deg.max() < high):
        warnings.append(
            f"fields of view of {fov_deg[0]:.0f} x {fov_deg[1]:.0f} degrees"
            f" are implausible ({low:.0f} to {high:.0f} are usual): are the"
            " intrinsics those of images of another size?"
        )
    height, width = capture.size
    off = np.median(capture.K[:, :2, 2], axis=0) / (width, height) - 0.5
    if np.abs(off).max() > 0.15:
        warnings.append(
            f"the principal point lies {100 * np.abs(off).max():.0f} % of the"
            " image's size off its centre: are the intrinsics those of images"
            " of another size?"
        )
    return warnings


def _judge_depth(known: float, median: float) -> list[str]:
    if known < MIN_DEPTH_FRACTION:
        return [f"only {100 * known:.1f} % of the pixels have a depth"]
    low, high = _DEPTH_RANGE
    if low <= median <= high:
        return []
    guesses = [w for factor, w in _UNITS if low <= median / factor <= high]
    guess = f": looks like {guesses[0]}" if guesses else ""
    return [
        f"a median depth of {median:.4g} m is implausible ({low} to {high:.0f}"
        f" m are usual){guess}"
    ]


def _judge_path(extent: float) -> list[str]:
    if extent >= _MIN_PATH:
        return []
    return [
        f"the camera moved only {1e3 * extent:.0f} mm: it has seen"
        " everything from one side"
    ]


def _judge_registration(registration: Registration | None) -> list[str]:
    if registration is None or not registration.is_off:
        return []
    right, down = registration.shift
    return [
        "colour and depth are not registered: their edges match best with"
        f" the colours moved {right:+d} columns and {down:+d} rows"
        f" (correlation {registration.correlation:.2f}; as they are"
        f" {registration.unshifted:.2f})"
    ]


def _judge_overlap(
    capture: Capture, overlap: Overlap, wrong: np.ndarray
) -> list[str]:
    agreement = overlap.agreement
    supported = overlap.supported >= _MIN_SUPPORTED
    is_good = agreement >= GOOD_AGREEMENT and supported
    if (capture.depth > 0).mean() < MIN_DEPTH_FRACTION or len(capture) < 2:
        return []
    facts = (
        f"neighbouring frames agree about {100 * agreement:.0f} % of what they"
        " share"
        if np.isfinite(agreement)
        else "no two frames show the same surface"
    )
    found = None if is_good else find_mistake(capture, overlap)
    if found is not None:
        mistake, mended = found
        return [
            f"{mistake.words}: {facts}, but {100 * mended.agreement:.0f} %"
            " with that undone"
        ]
    if agreement >= MIN_AGREEMENT and supported and len(wrong):
        return [
            f"the poses of {len(wrong)} of {len(capture)} frames disagree with"
            f" all of their neighbours': {list_frames(wrong)}"
        ]
    if is_good:
        return []
    return [f"{facts}, and no usual mistake about poses explains it"]


def list_frames(frames: np.ndarray, most: int = 10) -> str:
    """Words a list of frame indices, such as "3, 7, 9 and more".

    Args:
        frames: Indices of the frames.
        most: Largest number of indices that are listed.
    """
    names = ", ".join(str(i) for i in frames[:most])
    return names if len(frames) <= most else f"{names} and more"
