"""Judges the disagreement of views on shared surfaces, and finds its cause."""

import dataclasses as dc

import numpy as np

from remosplat_drake.capture.capture import Capture
from remosplat_drake.capture.checks.findings import (
    INEXACT,
    INTRINSICS,
    POSES,
    WARNING,
    Finding,
    list_frames,
)
from remosplat_drake.capture.checks.frame_shifts import (
    SHIFTS,
    as_colours_tell,
)
from remosplat_drake.capture.checks.image_checks import without
from remosplat_drake.capture.checks.wide_baselines import (
    WideBaselines,
    measure_wide_baselines,
)

_MIN_PAIRS = 3
"""Views are judged only if at least this many pairs of them are compared."""

_FEWER_PAIRS = 60
"""A possible cause is tested with at most this many pairs of views."""

_UNEQUAL = 0.03
"""An exchange of the focal lengths is a serious error if their relative
difference is at least this.
"""

_LEAST_OFFSET = 5e-4
"""The resolution of depth files, whole millimetres, explains disagreements up
to this length [m].
"""

_TIMES_NOISE = 3.0
"""Views disagree by more than noise explains if the ratio of disagreement to
noise exceeds this. In 60 rendered captures with and without noise, the ratio is
at most 1.5 for disagreements above `_LEAST_OFFSET`."""

_FRAME_OFF = 3e-3
"""A pose is wrong if its frame disagrees with all other frames by more than
this [m]."""

_EXPLAINED = 0.5
"""A cause explains a disagreement if, after its correction, at most this
fraction of the disagreement remains.
"""

_LEAST_SCALE = 0.002
"""An error of the depth's scale is detectable from this fraction on. A smaller
error cannot be distinguished from errors of poses.
"""


@dc.dataclass(frozen=True)
class Disagreement:
    """Disagreement of pairs of near and of distant views on shared surfaces.

    Attributes:
        near: Median baseline of the half of the pairs with the shorter
            baselines (the nearer half) [m].
        far: Median baseline of the other, farther half [m].
        near_offset: Median offset of the nearer half [m].
        far_offset: Median offset of the farther half [m].
        worst: Largest offset of a pair [m].
        near_noise: Median offset that noise alone would cause in the nearer
            half [m].
        far_noise: Median offset that noise alone would cause in the farther
            half [m].
        pairs: Number of pairs.
    """

    near: float
    far: float
    near_offset: float
    far_offset: float
    worst: float
    near_noise: float
    far_noise: float
    pairs: int

    @property
    def is_excessive(self) -> bool:
        """Whether views disagree by more than noise explains."""
        return any(
            offset > max(_LEAST_OFFSET, _TIMES_NOISE * noise)
            for offset, noise in (
                (self.near_offset, self.near_noise),
                (self.far_offset, self.far_noise),
            )
        )

    def __str__(self) -> str:
        return (
            f"views {self.near:.1f} m apart disagree by"
            f" {1e3 * self.near_offset:.1f} mm, views {self.far:.1f} m apart by"
            f" {1e3 * self.far_offset:.1f} mm (medians of {self.pairs} pairs;"
            f" at worst {1e3 * self.worst:.0f} mm); noise explains only"
            f" {max(1e3 * self.far_noise, 0.1):.1f} mm"
        )


def disagreement(wide: WideBaselines) -> Disagreement | None:
    """Summarises the disagreement; None if too few pairs share surfaces."""
    compared = np.flatnonzero(wide.compared)
    if len(compared) < _MIN_PAIRS:
        return None
    near, far = np.array_split(compared, 2)
    return Disagreement(
        near=float(np.median(wide.baseline[near])),
        far=float(np.median(wide.baseline[far])),
        near_offset=float(np.median(wide.offset[near])),
        far_offset=float(np.median(wide.offset[far])),
        worst=float(wide.offset[compared].max()),
        near_noise=float(np.median(wide.noise[near])),
        far_noise=float(np.median(wide.noise[far])),
        pairs=len(compared),
    )


def judge_exchange(capture: Capture, wide: WideBaselines) -> list[Finding]:
    """Judges whether f_x and f_y were exchanged.

    Args:
        capture: The capture.
        wide: The comparison of its views.
    """
    f_x, f_y = np.median(capture.K[:, [0, 1], [0, 1]], axis=0)
    found = disagreement(wide)
    if abs(f_x - f_y) < _UNEQUAL * f_y or not (found and found.is_excessive):
        return []
    after = _offset(_exchanged(capture))
    before = float(np.median(wide.offset[wide.compared]))
    if not after < _EXPLAINED * before:
        return []
    problem = (
        f"the focal lengths f_x = {f_x:.0f} and f_y = {f_y:.0f} look"
        f" exchanged: views disagree by {1e3 * before:.1f} mm (median), but by "
        f"{1e3 * after:.1f} mm if they are exchanged"
    )
    remedy = "exchanged f_x and f_y"
    return [Finding(INTRINSICS, problem, remedy=remedy, repair=_exchanged)]


def _exchanged(capture: Capture) -> Capture:
    K = capture.K.copy()
    K[:, [0, 1], [0, 1]] = K[:, [1, 0], [1, 0]]
    return dc.replace(capture, K=K)


def _offset(capture: Capture) -> float:
    """Median disagreement of views [m]; NaN if too few can be compared."""
    offset = measure_wide_baselines(capture, most=_FEWER_PAIRS).offset
    if np.isfinite(offset).sum() < _MIN_PAIRS:
        return np.nan
    return float(np.nanmedian(offset))


def judge_exactness(capture: Capture, wide: WideBaselines) -> list[Finding]:
    """Judges whether views disagree by more than noise explains.

    Args:
        capture: The capture.
        wide: The comparison of its views.
    """
    found = disagreement(wide)
    if found is None:
        return []
    if not found.is_excessive:
        return _judge_frames(capture, wide)
    shift = _find_shift(capture, wide)
    if shift is not None:
        return [shift]
    problem = f"poses or depths are not exact: {found}"
    left = float(np.median(wide.unscaled[wide.compared]))
    before = float(np.median(wide.offset[wide.compared]))
    if left < _EXPLAINED * before and abs(wide.scale) > _LEAST_SCALE:
        too = "long" if wide.scale > 0 else "short"
        problem += (
            f"; relative to the poses, depths look {100 * abs(wide.scale):.2f} "
            f"% too {too}; without this error, {1e3 * left:.1f} mm remain"
        )
    return [Finding(INEXACT, problem, WARNING)]


def _judge_frames(capture: Capture, wide: WideBaselines) -> list[Finding]:
    """Finds single frames with pose errors in a capture of exact poses."""
    compared = wide.compared
    offset = np.full(len(capture), np.inf)
    limit = np.zeros(len(capture))
    pairs = np.zeros(len(capture), int)
    for side in wide.pairs[compared].T:
        np.minimum.at(offset, side, wide.offset[compared])
        np.maximum.at(limit, side, _TIMES_NOISE * wide.noise[compared])
        np.add.at(pairs, side, 1)
    is_off = (pairs >= _MIN_PAIRS) & (offset > np.maximum(limit, _FRAME_OFF))
    if not is_off.any():
        return []
    frames = np.flatnonzero(is_off)
    problem = (
        f"the poses of {len(frames)} frames are off by about"
        f" {1e3 * offset[frames].max():.0f} mm:"
        f" {list_frames(frames, capture)}"
    )
    return [
        Finding(
            INEXACT,
            problem,
            WARNING,
            frames=tuple(frames.tolist()),
            remedy=f"removed {len(frames)} frames whose poses are off",
            repair=lambda capture: without(capture, frames),
        )
    ]


def _find_shift(capture: Capture, wide: WideBaselines) -> Finding | None:
    """Returns the wrong pairing of images that explains most disagreement."""
    before = float(np.median(wide.offset[wide.compared]))
    best, least = None, _EXPLAINED * before
    for shift in SHIFTS:
        if not shift.moves_depth or len(capture) < _MIN_PAIRS:
            continue
        offset = _offset(shift.undo(capture))
        if offset < least:
            best, least = shift, offset
    if best is None:
        return None
    best = as_colours_tell(best, capture)
    problem = (
        f"{best.words}: views disagree by {1e3 * before:.1f} mm (median), but"
        f" by {1e3 * least:.1f} mm after its correction"
    )
    return Finding(POSES, problem, remedy=best.remedy, repair=best.undo)
