"""Numbers of a rendered capture, and a warning for each thing broken."""

import dataclasses as dc
import re

import numpy as np
import pytest

from remosplat_drake.capture.checks.findings import INTRINSICS, list_frames
from remosplat_drake.capture.checks.inspection import inspect_capture
from remosplat_drake.capture.checks.repair import repair
from remosplat_drake.capture.formats import read_capture


def warnings_of(capture, **changes) -> str:
    findings = inspect_capture(dc.replace(capture, **changes)).findings
    return " | ".join(finding.problem for finding in findings)


def test_a_good_capture(scene_capture):
    inspection = inspect_capture(scene_capture)
    assert inspection.findings == ()
    assert inspection.frames == 12
    assert inspection.size == (90, 120)
    # Rendered with a vertical field of view of 1 rad.
    np.testing.assert_allclose(inspection.fov_deg[1], np.rad2deg(1), rtol=1e-6)
    low, median, high = inspection.depth
    assert 0.1 < low < median < high < 10
    assert inspection.overlap.agreement > 0.99
    p_WC = scene_capture.X_WC[:, :3, 3]
    np.testing.assert_allclose(inspection.extent, np.ptp(p_WC, axis=0))
    assert inspection.path_length > inspection.extent.max()


@pytest.mark.parametrize(
    ("factor", "words"),
    [(1e3, "millimetres read as metres"), (1e-3, "metres read as milli")],
)
def test_a_wrong_unit_of_depth_is_named(scene_capture, factor, words):
    depth = (scene_capture.depth * factor).astype(np.float32)
    assert f"looks like {words}" in warnings_of(scene_capture, depth=depth)


def test_missing_depth_is_told(scene_capture):
    none = np.zeros_like(scene_capture.depth)
    text = warnings_of(scene_capture, depth=none)
    assert text == "only 0.0 % of the pixels have a depth"


@pytest.mark.parametrize("scale", [8.0, 1 / 3])
def test_intrinsics_of_another_size(scene_capture, scale):
    """One line says it, and about how much smaller or larger those are."""
    K = scene_capture.K.copy()
    K[:, :2] *= scale
    wrong = dc.replace(scene_capture, K=K)
    found = [f for f in inspect_capture(wrong).defects if f.name == INTRINSICS]
    assert len(found) == 1
    (factor,) = re.findall(r"about ([\d.]+) times", found[0].problem)
    assert float(factor) == pytest.approx(scale, rel=0.02)
    assert "give the intrinsics for the images' own size" in found[0].problem


def test_intrinsics_of_turned_images(scene_capture):
    K = scene_capture.K.copy()
    K[:, [0, 1], 2] = K[:, [1, 0], 2]
    text = warnings_of(scene_capture, K=K)
    assert "images turned by 90 degrees: exchange c_x" in text


def test_a_principal_point_that_nothing_explains(scene_capture):
    K = scene_capture.K.copy()
    K[:, 0, 2] += 30
    text = warnings_of(scene_capture, K=K)
    assert "lies 25 % of the image's size away from its centre: give" in text


@pytest.mark.parametrize("axis", [0, 1])
def test_focal_lengths_that_differ_as_the_sides_do(scene_capture, axis):
    """Of 120 x 90 images one is 4 / 3 of the other."""
    K = scene_capture.K.copy()
    K[:, axis, axis] *= 4 / 3
    text = warnings_of(scene_capture, K=K)
    assert "the ratio of the images' sides (120 x 90)" in text
    assert "correct f_x and f_y" in text
    # Half of that is no such mistake.
    K[:, axis, axis] *= (3 / 4) ** 0.5
    text = warnings_of(scene_capture, K=K)
    assert "the ratio of the images' sides" not in text


def test_focal_lengths_that_are_exchanged_are_exchanged_back(scene_capture):
    """Images whose pixels are twice as wide as they are high."""
    K = scene_capture.K.copy()
    K[:, 0] /= 2
    wide = dc.replace(
        scene_capture,
        K=K,
        rgb=np.ascontiguousarray(scene_capture.rgb[:, :, ::2]),
        depth=np.ascontiguousarray(scene_capture.depth[:, :, ::2]),
    )
    assert "look exchanged" not in warnings_of(wide)
    f_x, f_y = K[0, 0, 0], K[0, 1, 1]
    K = K.copy()
    K[:, 0, 0], K[:, 1, 1] = f_y, f_x
    wrong = dc.replace(wide, K=K)
    inspection = inspect_capture(wrong)
    (found,) = inspection.defects
    assert found.name == "intrinsics"
    assert f"f_x = {f_y:.0f} and f_y = {f_x:.0f} look exchanged" in str(found)
    repaired = repair(wrong, inspection)
    np.testing.assert_array_equal(repaired.capture.K, wide.K)
    assert not repaired.inspection.defects


def test_focal_lengths_of_another_size(scene_capture):
    K = scene_capture.K.copy()
    K[:, [0, 1], [0, 1]] *= 8
    assert "fields of view" in warnings_of(scene_capture, K=K)


def test_a_wrong_frame_and_wrong_poses_are_told(scene_capture):
    X_WC = scene_capture.X_WC.copy()
    X_WC[3, :3, 3] += [0.15, -0.1, 0.1]
    text = warnings_of(scene_capture, X_WC=X_WC)
    assert "the poses of 1 of 12 frames disagree" in text
    assert text.endswith(": 3")
    inverse = np.linalg.inv(scene_capture.X_WC)
    text = warnings_of(scene_capture, X_WC=inverse)
    assert text.startswith("poses look like world-to-camera")
    assert "after its correction" in text


def test_shifted_colours_are_told(scene_capture):
    rgb = np.roll(scene_capture.rgb, 9, axis=2)
    text = warnings_of(scene_capture, rgb=rgb)
    assert "colour and depth are not registered" in text


def test_one_frame_has_one_side(scene_capture):
    inspection = inspect_capture(scene_capture.select(np.arange(1)))
    assert len(inspection.findings) == 1
    assert "everything from one side" in inspection.findings[0].problem


def test_many_frames_are_abbreviated():
    assert list_frames(np.arange(3)) == "0, 1, 2"
    assert list_frames(np.arange(12)).endswith("9 and 2 more")


@pytest.mark.slow
def test_a_real_capture_passes(shared_data):
    """A kitchen: depths agree to a centimetre over 2 m, and no better."""
    pytest.importorskip("PIL")
    capture = read_capture(shared_data / "redkitchen" / "capture", stride=2)
    inspection = inspect_capture(capture)
    assert [finding.name for finding in inspection.findings] == ["inexact"]
    assert inspection.overlap.agreement > 0.9
    assert inspection.overlap.median < 0.015
    inverse = np.linalg.inv(capture.X_WC)
    assert warnings_of(capture, X_WC=inverse).startswith(
        "poses look like world-to-camera"
    )
