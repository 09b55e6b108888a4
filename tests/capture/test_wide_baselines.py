"""Views far apart determine poses and scale, on rendered views."""

import dataclasses as dc

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from remosplat_drake.capture.checks.contradictions import contradicting_frames
from remosplat_drake.capture.checks.exactness import (
    disagreement,
    judge_exactness,
)
from remosplat_drake.capture.checks.wide_baselines import (
    WideBaselines,
    measure_wide_baselines,
)
from remosplat_drake.capture.rendering.sensor_noise import PRESETS, with_noise
from remosplat_drake.capture.rendering.synthetic import (
    render_capture,
    survey_poses,
)


@pytest.fixture(scope="module")
def capture(scene):
    """More and larger views than the other tests have."""
    return render_capture(scene, survey_poses(scene, n=24), 160, 120)


def offset(wide: WideBaselines) -> float:
    return float(np.nanmedian(wide.offset))


def moved(capture, position: float, rotation: float):
    rng = np.random.default_rng(0)
    X_WC = capture.X_WC.copy()
    n = len(X_WC)
    turn = Rotation.from_rotvec(rotation * rng.standard_normal((n, 3)))
    X_WC[:, :3, :3] = turn.as_matrix() @ X_WC[:, :3, :3]
    X_WC[:, :3, 3] += position * rng.standard_normal((n, 3))
    return dc.replace(capture, X_WC=X_WC)


def scaled(capture, factor: float):
    depth = (factor * capture.depth).astype(np.float32)
    return dc.replace(capture, depth=depth)


@pytest.mark.parametrize("camera", sorted(PRESETS))
def test_exact_and_noisy_views_agree_to_what_noise_explains(capture, camera):
    noisy = with_noise(capture, PRESETS[camera])
    wide = measure_wide_baselines(noisy)
    found = disagreement(wide)
    assert found is not None and not found.is_excessive
    assert judge_exactness(noisy, wide) == []
    assert (np.diff(wide.baseline) >= 0).all()
    assert abs(wide.scale) < 1e-3
    assert contradicting_frames(wide).tolist() == []


@pytest.mark.parametrize(
    "camera", [pytest.param("none", marks=pytest.mark.slow), "kinect"]
)
def test_poses_off_by_millimetres_are_told_in_millimetres(capture, camera):
    bad = with_noise(moved(capture, 0.005, 0.0026), PRESETS[camera])
    wide = measure_wide_baselines(bad)
    assert 0.002 < offset(wide) < 0.015
    (finding,) = judge_exactness(bad, wide)
    assert finding.name == "inexact"
    assert "m apart disagree by" in finding.problem


@pytest.mark.parametrize(
    ("camera", "factor"),
    [
        ("none", 0.99),
        ("kinect", 1.02),
        pytest.param("none", 1.02, marks=pytest.mark.slow),
        pytest.param("kinect", 0.99, marks=pytest.mark.slow),
    ],
)
def test_an_error_of_the_scale_is_told_from_one_of_the_poses(
    capture, camera, factor
):
    bad = with_noise(scaled(capture, factor), PRESETS[camera])
    wide = measure_wide_baselines(bad)
    assert wide.scale == pytest.approx(factor - 1, abs=1e-3)
    (finding,) = judge_exactness(bad, wide)
    too = "long" if factor > 1 else "short"
    assert f"% too {too}; without" in finding.problem


def test_a_smooth_drift_is_told(capture):
    X_WC = capture.X_WC.copy()
    X_WC[:, 2, 3] += np.linspace(0, 0.05, len(X_WC))
    bad = dc.replace(capture, X_WC=X_WC)
    (finding,) = judge_exactness(bad, measure_wide_baselines(bad))
    assert "too long" not in finding.problem


def test_one_frame_off_by_centimetres_is_named(capture):
    X_WC = capture.X_WC.copy()
    X_WC[5, :3, 3] += [0.02, -0.01, 0.01]
    bad = dc.replace(capture, X_WC=X_WC)
    (finding,) = judge_exactness(bad, measure_wide_baselines(bad))
    assert finding.frames == (5,)
    assert "off by about" in finding.problem


def test_a_wrong_frame_without_neighbours_is_found(capture):
    """It looks from another place at a part that no other view shows well."""
    X_WC = capture.X_WC.copy()
    X_WC[5, :3, 3] += [0.3, -0.3, 0.3]
    wide = measure_wide_baselines(dc.replace(capture, X_WC=X_WC))
    assert contradicting_frames(wide).tolist() == [5]


def test_of_two_that_contradict_each_other_the_others_know_the_right_one():
    """Frame 2 contradicts both of its partners, which agree."""
    wide = WideBaselines(
        frames=3,
        pairs=np.array([[0, 1], [0, 2], [1, 2]]),
        baseline=np.ones(3),
        offset=np.full(3, np.nan),
        noise=np.full(3, np.nan),
        scale=0.0,
        unscaled=np.full(3, np.nan),
        judged=np.array([[30, 30], [90, 90], [90, 90]]),
        through=np.array([[0, 0], [80, 80], [80, 80]]),
    )
    assert contradicting_frames(wide).tolist() == [2]


def test_too_few_views_say_nothing(capture):
    wide = measure_wide_baselines(capture.select(np.arange(1)))
    assert len(wide.pairs) == 0 and disagreement(wide) is None
    assert contradicting_frames(wide).tolist() == []
