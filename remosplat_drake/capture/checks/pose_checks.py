"""Checks a capture's poses by comparing its views."""

import numpy as np

from remosplat_drake.capture.capture import (
    MIN_DEPTH_FRACTION,
    MIN_VIEWS,
    Capture,
)
from remosplat_drake.capture.checks.findings import (
    CONTRADICTION,
    NO_OVERLAP,
    ONE_SIDE,
    POSES,
    WRONG_FRAMES,
    Finding,
    list_frames,
)
from remosplat_drake.capture.checks.frame_shifts import (
    SHIFTS,
    FrameShift,
    as_colours_tell,
)
from remosplat_drake.capture.checks.image_checks import without
from remosplat_drake.capture.checks.overlap import (
    MIN_AGREEMENT,
    Overlap,
    measure_overlap,
)
from remosplat_drake.capture.checks.pose_conventions import (
    GOOD_AGREEMENT,
    Mistake,
    find_mistake,
)

_ROUGHLY = 0.08
"""Depths agree roughly if they differ by at most this fraction. If views agree
within this tolerance, the refinement of poses may correct the remaining errors.
"""

_MIN_SUPPORTED = 0.05
"""The views show different parts of the scene if other views confirm less than
this fraction of their points.
"""

_MIN_PATH = 0.05
"""A camera sees objects from different sides only if it moves at least this far
[m]."""


def judge_path(extent: float) -> list[Finding]:
    """Judges whether the camera moved.

    Args:
        extent: Longest side of the box around its positions [m].
    """
    if extent >= _MIN_PATH:
        return []
    problem = (
        f"the camera moved only {1e3 * extent:.0f} mm: it has seen"
        " everything from one side"
    )
    return [Finding(ONE_SIDE, problem)]


def judge_overlap(
    capture: Capture, overlap: Overlap, wrong: np.ndarray
) -> list[Finding]:
    """Judges whether neighbouring views agree; finds the cause if they do not.

    Args:
        capture: The capture.
        overlap: Agreement of its neighbouring views.
        wrong: Indices of the frames that disagree with all their neighbours.
    """
    agreement = overlap.agreement
    roughly = measure_overlap(capture, tolerance=_ROUGHLY).agreement
    supported = overlap.supported >= _MIN_SUPPORTED
    is_good = agreement >= GOOD_AGREEMENT and supported
    if (capture.depth > 0).mean() < MIN_DEPTH_FRACTION or len(capture) < 2:
        return []
    facts = (
        f"neighbouring frames agree at {100 * agreement:.0f} % of their common "
        "points"
        if np.isfinite(agreement)
        else "no two frames show the same surface"
    )
    found = None if is_good else _find_mistake(capture, overlap)
    if found is not None:
        mistake, mended = found
        problem = (
            f"{mistake.words}: {facts}, but at {100 * mended.agreement:.0f} % "
            "after its correction"
        )
        return [
            Finding(POSES, problem, remedy=mistake.remedy, repair=mistake.undo)
        ]
    if roughly >= MIN_AGREEMENT and supported and len(wrong):
        return [_wrong_frames(capture, wrong)]
    if supported and roughly >= GOOD_AGREEMENT:
        return []
    problem = f"{facts}, and no common mistake about poses explains it"
    return [Finding(CONTRADICTION if supported else NO_OVERLAP, problem)]


def _find_mistake(
    capture: Capture, overlap: Overlap
) -> tuple[Mistake | FrameShift, Overlap] | None:
    """Returns the cause of the disagreement, and the corrected overlap."""
    found = find_mistake(capture, overlap)
    for shift in SHIFTS if found is None else ():
        if shift.moves_depth and len(capture) > MIN_VIEWS:
            undone = measure_overlap(shift.undo(capture))
            if undone.agreement >= GOOD_AGREEMENT:
                return as_colours_tell(shift, capture), undone
    return found


def _wrong_frames(capture: Capture, wrong: np.ndarray) -> Finding:
    return Finding(
        WRONG_FRAMES,
        f"the poses of {len(wrong)} of {len(capture)} frames disagree with"
        f" all of their neighbours': {list_frames(wrong, capture)}",
        frames=tuple(wrong.tolist()),
        remedy=f"removed {len(wrong)} frames that contradict all others",
        repair=lambda capture: without(capture, wrong),
    )
