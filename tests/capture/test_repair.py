"""Findings of an inspection are undone, one mistake after the other."""

import dataclasses as dc

import numpy as np
import pytest

from remosplat_drake.capture.checks.inspection import inspect_capture
from remosplat_drake.capture.checks.repair import repair


def repaired(capture, **changes):
    wrong = dc.replace(capture, **changes)
    return repair(wrong, inspect_capture(wrong))


def test_a_good_capture_stays_as_it_is(scene_capture):
    result = repaired(scene_capture)
    assert result.undone == ()
    assert result.capture.X_WC is scene_capture.X_WC


@pytest.mark.parametrize(("depth", "poses"), [(1e3, 1), (1e3, 1e3), (1, 1e3)])
def test_units_of_depths_and_of_poses_come_right(scene_capture, depth, poses):
    X_WC = scene_capture.X_WC.copy()
    X_WC[:, :3, 3] *= poses
    z = (scene_capture.depth * depth).astype(np.float32)
    result = repaired(scene_capture, X_WC=X_WC, depth=z)
    assert result.inspection.findings == ()
    np.testing.assert_allclose(result.capture.X_WC, scene_capture.X_WC)
    np.testing.assert_allclose(
        result.capture.depth, scene_capture.depth, rtol=1e-6
    )


def test_wrong_and_empty_frames_are_left_out(scene_capture):
    X_WC, depth = scene_capture.X_WC.copy(), scene_capture.depth.copy()
    X_WC[3, :3, 3] += [0.15, -0.1, 0.1]
    empty = [5, 8, 10]
    depth[empty] = 0
    result = repaired(scene_capture, X_WC=X_WC, depth=depth)
    assert [(f.name, f.frames) for f in result.undone] == [
        ("wrong-frames", (3,)),
        # Frame 3 is out: those that follow move up.
        ("empty-depth", (4, 7, 9)),
    ]
    kept = np.setdiff1d(np.arange(12), [3, *empty])
    np.testing.assert_array_equal(
        result.capture.depth, scene_capture.depth[kept]
    )


def test_what_has_no_remedy_stays(scene_capture):
    rgb = np.roll(scene_capture.rgb, 9, axis=2)
    result = repaired(scene_capture, rgb=rgb)
    assert result.undone == ()
    assert [f.name for f in result.inspection.findings] == ["colours"]
