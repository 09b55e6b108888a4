"""Finds wrong poses and motion from surfaces in other views' free space."""

import dataclasses as dc

import numpy as np

from remosplat_drake.capture.capture import Capture
from remosplat_drake.capture.checks.findings import (
    MOVING,
    WARNING,
    Finding,
    list_frames,
)
from remosplat_drake.capture.checks.wide_baselines import WideBaselines

_WRONG = 0.5
"""A frame is wrong if other frames show free space at this fraction of its
points or at more of them.
"""

_MOVING = 0.08
"""A frame shows motion if at least this fraction of its points is in other
frames' free space, or if at least this fraction of other frames' points is in
its own free space. In rendered captures of static rooms, with noise or with
pose errors of up to 30 mm, these fractions are at most 0.03.
"""

_MOVED = 0.005
"""An object has moved in the capture if at least this fraction of all points is
in other frames' free space."""

_MIN_JUDGED = 30
"""A frame is judged only by comparisons of at least this many points."""


def contradicting_frames(wide: WideBaselines) -> np.ndarray:
    """Finds frames with most of their points in other frames' free space.

    If two frames contradict each other, either may be wrong. So the frame that
    contradicts the most other frames is removed first. The search is then
    repeated without the contradictions of this frame.

    Returns:
        Indices of these frames, ascending.
    """
    wrong: list[int] = []
    while True:
        judged, through = _counts(wide, wrong)
        rate = _rates(judged, through)
        if not (rate > _WRONG).any():
            return np.array(sorted(wrong), int)
        contradicted = _contradicted(wide, wrong)
        wrong.append(int(np.where(rate > _WRONG, contradicted, -1).argmax()))


def judge_motion(capture: Capture, wide: WideBaselines) -> list[Finding]:
    """Judges whether an object in front of the cameras has moved.

    It reports frames with surfaces in other frames' free space. If there are
    none, it reports frames whose own free space contains other frames'
    surfaces. The second test finds a mirror or a pane of glass through which
    few frames show free space: in each of the other frames, the mirror or pane
    is only a small part of the image.

    Args:
        capture: The capture.
        wide: The comparison of its views.
    """
    looking = dc.replace(wide, pairs=wide.pairs[:, ::-1])
    for sides, words in (
        (
            wide,
            "in {1} frames, up to {0} % of the points are in space that other"
            " frames show as free",
        ),
        (
            looking,
            "{1} frames show free space at up to {0} % of the points of other"
            " frames",
        ),
    ):
        judged, through = _counts(sides, [])
        rate = _rates(judged, through)
        frames = np.flatnonzero(rate > _MOVING)
        if not len(frames) or through.sum() <= _MOVED * judged.sum():
            continue
        problem = (
            f"{words.format(f'{100 * rate.max():.0f}', len(frames))}: an "
            "object has moved, or there is a mirror or glass: "
            f"{list_frames(frames, capture)}"
        )
        return [
            Finding(MOVING, problem, WARNING, frames=tuple(frames.tolist()))
        ]
    return []


def _counts(
    wide: WideBaselines, without: list[int]
) -> tuple[np.ndarray, np.ndarray]:
    """Numbers of compared points, and of those in free space, both (n,)."""
    kept = ~np.isin(wide.pairs, without).any(axis=1)
    judged, through = np.zeros((2, wide.frames), int)
    np.add.at(judged, wide.pairs[kept], wide.judged[kept])
    np.add.at(through, wide.pairs[kept], wide.through[kept])
    return judged, through


def _contradicted(wide: WideBaselines, without: list[int]) -> np.ndarray:
    """Number of other frames that contradict each frame, shape (n,)."""
    kept = ~np.isin(wide.pairs, without).any(axis=1)
    rate = _rates(wide.judged[kept], wide.through[kept])
    contradicts = (rate > _WRONG).any(axis=1)
    return np.bincount(
        wide.pairs[kept][contradicts].ravel(), minlength=wide.frames
    )


def _rates(judged: np.ndarray, through: np.ndarray) -> np.ndarray:
    """Returns fractions of points in free space; 0 for too few points."""
    enough = judged >= _MIN_JUDGED
    return np.where(enough, through / np.maximum(judged, 1), 0.0)
