"""Frames of a base whose odometry drifts, and those nothing explains."""

import dataclasses as dc

import numpy as np
import pytest
from drifting_base import DRIFT, DrivenFrames, drive
from laden_table import TOP
from mapped_table import table_world

from remosplat_drake.mapping.frame_choice import contradiction
from remosplat_drake.mapping.localization.frame_aligner import (
    Aligned,
    FrameAligner,
    make_aligner,
)
from remosplat_drake.mapping.localization.keyframe_graph import Drift
from remosplat_drake.mapping.localization.planar_pose import composed
from remosplat_drake.mapping.mapping_config import MappingConfig

EXPECTED = Drift(0.02, 0.002)


@pytest.fixture(scope="module")
def frames() -> DrivenFrames:
    return drive()


def align(
    frames: DrivenFrames, n: int, aligner: FrameAligner | None = None
) -> Aligned:
    """Aligns the first frames of a drive."""
    return (aligner or FrameAligner(EXPECTED)).align(
        frames.keys[:n], frames.capture.select(np.arange(n)), frames.X_OB[:n]
    )


def errors(frames: DrivenFrames, aligned: Aligned) -> np.ndarray:
    """How far cameras are from where they were [m]."""
    n = len(aligned.X_WC)
    return np.linalg.norm(
        aligned.X_WC[:, :3, 3] - frames.X_WC[:n, :3, 3], axis=1
    )


def test_drift_is_found_and_taken_out(frames):
    aligned = align(frames, 12)
    measured = Aligned.as_measured(frames.capture)
    assert errors(frames, measured)[-1] > 0.3
    assert errors(frames, aligned).max() < 0.002
    assert aligned.problems == {}
    assert np.nanmax(aligned.residual) < 0.001
    last = aligned.corrections[-1]
    assert last.time == frames.keys[-1][1]
    np.testing.assert_allclose(last.pose, DRIFT * last.time, atol=0.002)
    X_WB = composed(last.pose, frames.X_OB[-1])
    np.testing.assert_allclose(X_WB, frames.X_WB[-1], atol=0.002)
    deviations = np.sqrt(np.diag(last.covariance))
    assert (deviations > 0).all() and deviations[:2].max() < 0.01


def test_frames_may_come_one_by_one(frames):
    aligner = FrameAligner(EXPECTED)
    for n in range(3, 9):
        aligned = align(frames, n, aligner)
    assert errors(frames, aligned).max() < 0.002


def test_a_frame_that_odometry_cannot_explain_is_refused(frames):
    shift = np.array([0.0, -0.1, 0.0])
    X_WC, X_OB = frames.capture.X_WC.copy(), frames.X_OB.copy()
    X_WC[5, :3, 3] += shift
    X_OB[5] += shift
    capture = dc.replace(frames.capture, X_WC=X_WC).select(np.arange(8))
    careful = FrameAligner(Drift(0.007, 0.001))
    aligned = careful.align(frames.keys[:8], capture, X_OB[:8])
    assert list(aligned.problems) == [5]
    # By the shift, and the drift of two seconds.
    assert "does not fit: 127 mm and 0.1 deg" in aligned.problems[5]
    others = np.setdiff1d(np.arange(8), 5)
    assert errors(frames, aligned)[others].max() < 0.002


def test_who_trusts_the_odometry_aligns_nothing():
    robot = table_world().robot
    assert make_aligner(MappingConfig(), robot) is None
    assert make_aligner(MappingConfig(odometry_turn=0.01), robot) is not None


def test_a_contradiction_says_how_far_surfaces_are_apart():
    assert contradiction(0.0123).endswith("lie 12.3 mm from theirs")
    assert "mm" not in contradiction(np.nan)


def test_a_frame_of_a_bare_floor_does_not_say_where_the_base_was(frames):
    depth = frames.capture.depth.copy()
    # All that stands upright on the table is hidden.
    p_C = unproject(frames.capture, 4)
    upright = (frames.X_WC[4] @ p_C)[..., 2, 0] > TOP + 0.01
    depth[4][upright] = 0
    # So are the table's own sides.
    depth[4][(frames.X_WC[4] @ p_C)[..., 2, 0] < TOP - 0.01] = 0
    capture = dc.replace(frames.capture, depth=depth).select(np.arange(6))
    aligned = FrameAligner(EXPECTED).align(
        frames.keys[:6], capture, frames.X_OB[:6]
    )
    assert list(aligned.problems) == [4]
    assert "too little that stands upright" in aligned.problems[4]
    assert errors(frames, aligned)[[0, 1, 2, 3, 5]].max() < 0.002


def unproject(capture, view: int) -> np.ndarray:
    """Points of a view's pixels in its camera, shape (h, w, 4, 1) [m]."""
    depth, K = capture.depth[view], capture.K[view]
    v, u = np.mgrid[: depth.shape[0], : depth.shape[1]] + 0.5
    x, y = (u - K[0, 2]) / K[0, 0], (v - K[1, 2]) / K[1, 1]
    p = np.stack([x * depth, y * depth, depth, np.ones_like(depth)], axis=-1)
    return p[..., None]
