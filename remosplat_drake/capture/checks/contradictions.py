"""Finds points that other views look through: wrong frames and motion."""

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
"""A frame is wrong if other frames look through at least this fraction of its
points."""

_MOVING = 0.08
"""Least such fraction of a frame with motion, or least fraction of other
frames' points that this frame looks through. In rendered captures of static
rooms, noisy or with pose errors up to 30 mm, it is at most 0.03."""

_MOVED = 0.005
"""An object has moved in the capture if frames look through at least this
fraction of all frames' points."""

_MIN_JUDGED = 30
"""Least number of points for a decision about a frame."""


def contradicting_frames(wide: WideBaselines) -> np.ndarray:
    """Finds frames with most points in space that others see as empty.

    The frame that contradicts the most others is removed first, with its
    contradictions: of two frames that contradict each other, the others decide
    which one is right.

    Returns:
        Their indices, ascending.
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
    """Judges whether something in front of the cameras has moved.

    It reports frames with surfaces that others look through; if there are none,
    those that look through others' surfaces. A mirror or a pane that few frames
    see through is a small part of each of the others.

    Args:
        capture: The capture.
        wide: The comparison of its views.
    """
    looking = dc.replace(wide, pairs=wide.pairs[:, ::-1])
    for sides, words in (
        (wide, "other views look through up to {} % of what {} frames show"),
        (
            looking,
            "up to {} % of what others show is looked through by {} frames",
        ),
    ):
        judged, through = _counts(sides, [])
        rate = _rates(judged, through)
        frames = np.flatnonzero(rate > _MOVING)
        if not len(frames) or through.sum() <= _MOVED * judged.sum():
            continue
        problem = (
            f"{words.format(f'{100 * rate.max():.0f}', len(frames))}: something"
            " has moved, or is a mirror or glass:"
            f" {list_frames(frames, capture)}"
        )
        return [
            Finding(MOVING, problem, WARNING, frames=tuple(frames.tolist()))
        ]
    return []


def _counts(
    wide: WideBaselines, without: list[int]
) -> tuple[np.ndarray, np.ndarray]:
    """Judged points of each frame, and those looked through, both (n,)."""
    kept = ~np.isin(wide.pairs, without).any(axis=1)
    judged, through = np.zeros((2, wide.frames), int)
    np.add.at(judged, wide.pairs[kept], wide.judged[kept])
    np.add.at(through, wide.pairs[kept], wide.through[kept])
    return judged, through


def _contradicted(wide: WideBaselines, without: list[int]) -> np.ndarray:
    """Number of others that contradict each frame, shape (n,)."""
    kept = ~np.isin(wide.pairs, without).any(axis=1)
    rate = _rates(wide.judged[kept], wide.through[kept])
    contradicts = (rate > _WRONG).any(axis=1)
    return np.bincount(
        wide.pairs[kept][contradicts].ravel(), minlength=wide.frames
    )


def _rates(judged: np.ndarray, through: np.ndarray) -> np.ndarray:
    """Returns fractions of points that are looked through; 0 for too few."""
    enough = judged >= _MIN_JUDGED
    return np.where(enough, through / np.maximum(judged, 1), 0.0)
