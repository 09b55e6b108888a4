"""The fusion of odometry and fixes: by hand, and by chance."""

import dataclasses as dc

import numpy as np
import pytest

from remosplat_drake.hardware.client.base_filter import (
    BaseFilter,
    doubted,
    with_fix,
    with_odometry,
)
from remosplat_drake.hardware.localization_config import LocalizationConfig
from remosplat_drake.hardware.wire.base import extrapolated_pose
from remosplat_drake.hardware.wire.localization import BaseFix
from remosplat_drake.robot.planar_pose import composed, relative

CONFIG = LocalizationConfig()
X_WO = np.array([2.0, -1.0, 0.7])
U = np.array([0.4, 0.0, 0.3])
PERIOD = 0.03
COVARIANCE = np.diag(np.square([0.002, 0.002, 0.001]))


def odometry_at(t: float) -> np.ndarray:
    return extrapolated_pose(np.zeros(3), U, t)


def fix_at(t: float, off=(0.0, 0.0, 0.0), **fields) -> BaseFix:
    pose = composed(X_WO, odometry_at(t)) + off
    fix = BaseFix(pose, COVARIANCE, t, "map", "base_link")
    return dc.replace(fix, **fields)


def driven(known: BaseFilter, start: float, end: float) -> BaseFilter:
    """After the odometry of some time."""
    for t in np.arange(start, end - 1e-9, PERIOD):
        known = with_odometry(known, t, odometry_at(t))
    return known


def located(end: float = 3.0, delay: float = 0.2) -> BaseFilter:
    """After some time with fixes that come late."""
    known = BaseFilter(CONFIG)
    for i, t in enumerate(np.arange(0.0, end - 1e-9, PERIOD)):
        known = with_odometry(known, t, odometry_at(t))
        if i % 4 == 0 and t > delay:
            known = with_fix(known, fix_at(t - delay))
    return known


def test_nothing_is_known_before_the_first_fix():
    known = driven(BaseFilter(CONFIG), 0.0, 1.0)
    assert np.isnan(known.pose(odometry_at(1.0))).all()
    assert (known.uncertainty == np.inf).all()


@pytest.mark.parametrize("delay", [0.0, 0.2, 1.0])
def test_a_late_fix_meets_the_odometry_of_its_time(delay):
    known = with_fix(driven(BaseFilter(CONFIG), 0.0, 2.0), fix_at(2.0 - delay))
    np.testing.assert_allclose(known.X_WO, X_WO, atol=1e-4)


def test_the_frame_of_the_odometry_may_be_located_instead():
    known = driven(BaseFilter(CONFIG), 0.0, 2.0)
    fix = fix_at(1.7, pose=X_WO, child_frame="/odom")
    np.testing.assert_allclose(with_fix(known, fix).X_WO, X_WO, atol=1e-12)


def test_uncertainty_grows_with_the_way_and_shrinks_with_fixes():
    known = located()
    far = driven(known, 3.0, 6.0)
    assert (far.uncertainty > 1.5 * known.uncertainty).all()
    near = with_fix(far, fix_at(5.9))
    assert (near.uncertainty < far.uncertainty).all()


def test_many_fixes_are_no_better_than_the_localiser():
    least = CONFIG.sigmas * np.array([CONFIG.least_shift, CONFIG.least_turn])
    assert (located(6.0).uncertainty > least).all()


def test_a_step_within_the_covariance_moves_the_pose_slowly():
    known = located()
    told = known.pose(odometry_at(3.0))
    known = with_fix(known, fix_at(2.95, (0.008, 0.0, 0.0)))
    assert not known.refusal
    # What is told stays; what is still to come counts as uncertain.
    np.testing.assert_allclose(known.pose(odometry_at(3.0)), told, atol=1e-12)
    after = with_odometry(known, 3.03, odometry_at(3.03))
    moved = relative(told, after.pose(odometry_at(3.0)))
    most = CONFIG.correction_speed * 0.061
    assert 0 < np.hypot(*moved[:2]) < most


@pytest.mark.parametrize(
    "off", [(0.05, 0, 0), (0, -0.3, 0), (0, 0, 0.1), (0, np.nan, 0)]
)
def test_a_jump_is_refused_and_changes_nothing(off):
    known = located()
    after = with_fix(known, fix_at(2.95, off))
    assert "jumped by" in after.refusal
    np.testing.assert_array_equal(after.X_WO, known.X_WO)
    assert not with_fix(after, fix_at(2.97)).refusal


def test_a_drift_of_the_localisation_is_found_out():
    """At 2 cm/s, before it has led the robot farther than it knows."""
    known = located()
    for i, t in enumerate(np.arange(3.0, 8.0, PERIOD)):
        known = with_odometry(known, t, odometry_at(t))
        if i % 4 == 0:
            known = with_fix(known, fix_at(t, (-0.02 * (t - 3.0), 0, 0)))
        if known.refusal:
            break
    assert "jumped by" in known.refusal
    truth = composed(X_WO, odometry_at(t))
    off = relative(known.pose(odometry_at(t)), truth)
    assert np.hypot(*off[:2]) < known.uncertainty[0]


@pytest.mark.parametrize(
    ("fields", "problem"),
    [
        ({"frame": "odom"}, "frame_id is 'odom', not 'map'"),
        ({"child_frame": "camera"}, "child_frame_id is 'camera'"),
    ],
)
def test_frames_are_checked(fields, problem):
    assert problem in with_fix(located(), fix_at(2.9, **fields)).refusal


def test_old_and_repeated_fixes_tell_nothing():
    known = located()
    assert with_fix(known, fix_at(known.fixed)) is known
    assert with_fix(known, fix_at(-5.0)) is known


def test_odometry_that_jumped_is_doubted_until_the_next_fix():
    known = doubted(located(), 0.3, 0.1)
    assert known.uncertainty[0] > CONFIG.max_shift
    known = with_fix(known, fix_at(2.99))
    assert known.uncertainty[0] < CONFIG.max_shift


def test_errors_stay_within_their_bounds():
    """Random drives, noisy wheels and fixes: nearly never beyond 3 sigma."""
    random = np.random.default_rng(1)
    beyond = n = 0
    for _ in range(20):
        X_OB = X_WB = np.zeros(3)
        known = BaseFilter(CONFIG)
        u = U * random.normal(size=3)
        for i in range(200):
            t = i * PERIOD
            X_WB = extrapolated_pose(X_WB, u, PERIOD)
            wheels = u * (1 + 0.02 * random.normal(size=3))
            X_OB = extrapolated_pose(X_OB, wheels, PERIOD)
            known = with_odometry(known, t, X_OB)
            if i % 10 == 0:
                noise = [0.002, 0.002, 0.001] * random.normal(size=3)
                known = with_fix(known, fix_at(t, pose=X_WB + noise))
            off = relative(known.pose(X_OB), X_WB)
            size = np.array([np.hypot(*off[:2]), abs(off[2])])
            beyond += (size > known.uncertainty).any()
            n += 1
    assert beyond / n < 0.01
