"""Frames of a base whose odometry drifts, and those nothing explains."""

import dataclasses as dc

import numpy as np
import pytest
from drifting_base import DRIFT, DrivenFrames, drive
from mapped_table import table_world

from remosplat_drake.capture.capture import Capture
from remosplat_drake.mapping.frame_choice import contradiction
from remosplat_drake.mapping.localization.frame_aligner import (
    FrameAligner,
    Tracked,
    make_aligner,
)
from remosplat_drake.mapping.mapping_config import MappingConfig
from remosplat_drake.robot.planar_pose import (
    matrix,
    relative,
)
from remosplat_drake.signals.base_estimate import Drift

EXPECTED = Drift(0.02, 0.002)


@pytest.fixture(scope="module")
def frames() -> DrivenFrames:
    return drive()


def follow(
    frames: DrivenFrames, aligner: FrameAligner, indices: range
) -> list[Tracked]:
    """Tracks frames of a drive; every fourth one may be in a map."""
    return [
        aligner.track(
            frames.frame(i),
            None if i % 4 else (f"frame {i}", float(frames.time[i])),
        )
        for i in indices
    ]


def error(frames: DrivenFrames, i: int, X_WB: np.ndarray) -> float:
    """How far a base is from where it was at a frame [m]."""
    return float(np.hypot(*relative(frames.X_WB[i], X_WB)[:2]))


def test_drift_and_its_rate_are_found(frames):
    aligner = FrameAligner(EXPECTED)
    tracked = follow(frames, aligner, range(24))
    assert np.hypot(*(DRIFT * frames.time[-1])[:2]) > 0.2
    errors = [error(frames, i, t.estimate.X_WB) for i, t in enumerate(tracked)]
    assert max(errors) < 0.002
    assert all(each.problem == "" for each in tracked)
    last = tracked[-1].estimate
    np.testing.assert_allclose(last.rate, -DRIFT, atol=2e-3)
    assert 0 < last.deviations[:2].max() < 0.004
    # What follows from it a second later, before there is a frame.
    later, P = aligner.correction.base_at(last.time + 1, last.X_OB + DRIFT)
    np.testing.assert_allclose(later, last.X_WB, atol=3e-3)
    assert (np.diag(P) > np.diag(last.covariance)[:3]).all()


def test_over_a_bare_floor_the_rate_carries_on(frames):
    aligner = FrameAligner(EXPECTED)
    follow(frames, aligner, range(12))
    blind = np.zeros_like(frames.capture.depth[12])
    for i in (12, 13):
        tracked = aligner.track(frames.frame(i, blind))
        assert "shares no surface" in tracked.problem
        assert error(frames, i, tracked.estimate.X_WB) < 0.006
    again = aligner.track(frames.frame(14))
    assert again.problem == ""
    assert error(frames, 14, again.estimate.X_WB) < 0.002


def test_a_map_moves_its_keyframes_and_the_base_together(frames):
    aligner = FrameAligner(EXPECTED)
    follow(frames, aligner, range(16))
    graph = aligner.align()
    keys = [(f"frame {i}", float(frames.time[i])) for i in (0, 4, 8, 12)]
    rows = graph.rows(keys)
    for i, row in zip((0, 4, 8, 12), rows, strict=True):
        assert error(frames, i, graph.X_WB[row]) < 0.002
    assert np.nanmax(graph.residual) < 0.001
    turned = dc.replace(graph, X_WB=graph.X_WB + np.array([0.1, 0, 0]))
    before = aligner.correction.pose
    poses = aligner.adopt(turned)
    assert sorted(poses) == ["frame 0", "frame 12", "frame 4", "frame 8"]
    shift = aligner.correction.pose - before
    np.testing.assert_allclose(shift, [0.1, 0, 0], atol=3e-3)


def test_another_process_goes_on_where_one_has_ended(frames):
    first = FrameAligner(EXPECTED)
    follow(frames, first, range(9))
    poses = first.adopt(first.align())
    second = FrameAligner(EXPECTED)
    for i in (0, 4, 8):
        key = f"frame {i}", float(frames.time[i])
        second.resume(frames.frame(i), key, poses[key[0]])
    assert second.knows(key) and not second.knows(("frame 1", 0.5))
    tracked = follow(frames, second, range(9, 12))
    assert error(frames, 11, tracked[-1].estimate.X_WB) < 0.002


def test_a_frame_that_odometry_cannot_explain_is_refused(frames):
    aligner = FrameAligner(Drift(0.002, 0.0002))
    steady = dc.replace(frames, X_OB=frames.X_WB, capture=true_capture(frames))
    follow(steady, aligner, range(8))
    shift = np.array([0.0, -0.03, 0.0])
    X_WC, X_OB = steady.capture.X_WC.copy(), steady.X_OB.copy()
    X_WC[8, :3, 3] += shift
    X_OB[8] += shift
    capture = dc.replace(steady.capture, X_WC=X_WC)
    jumped = dc.replace(steady, capture=capture, X_OB=X_OB)
    tracked = aligner.track(jumped.frame(8))
    assert "does not fit: its surfaces lie" in tracked.problem
    assert (
        "at every pose within 3 mm and 0.1 deg of odometry" in tracked.problem
    )


def true_capture(frames: DrivenFrames) -> Capture:
    """The frames where they were taken."""
    X_BC = np.linalg.inv(matrix(frames.X_OB)) @ frames.capture.X_WC
    return dc.replace(frames.capture, X_WC=matrix(frames.X_WB) @ X_BC)


def test_who_trusts_the_odometry_aligns_nothing():
    robot = table_world().robot
    trusting = MappingConfig(odometry_drift=0, odometry_turn=0)
    assert make_aligner(trusting, robot) is None
    assert make_aligner(MappingConfig(odometry_turn=0.01), robot) is not None


def test_a_contradiction_says_how_far_surfaces_are_apart():
    assert contradiction(0.0123).endswith("lie 12.3 mm from theirs")
    assert "mm" not in contradiction(np.nan)


def test_a_bare_floor_does_not_say_where_the_world_is(frames):
    bare = np.where(frames.capture.depth[0] > 0, 1.0, 0).astype(np.float32)
    aligner = FrameAligner(EXPECTED)
    # A flat wall across the view has sides in one direction only.
    tracked = aligner.track(frames.frame(0, bare))
    assert "too few upright surfaces" in tracked.problem
    assert aligner.track(frames.frame(1)).problem == ""
