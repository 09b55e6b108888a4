"""Faults that a base's statuses show over the seconds."""

import dataclasses as dc

import numpy as np
import pytest
from wire_messages import base_message

from remosplat_drake.hardware.client import base_residual_kernel
from remosplat_drake.hardware.client.base_residual import CommandedPath
from remosplat_drake.hardware.client.base_track import (
    BaseTrack,
    compile_kernels,
    track_problem,
    with_base_sample,
    with_localization,
)
from remosplat_drake.hardware.hardware_config import HardwareConfig
from remosplat_drake.hardware.localization_config import LocalizationConfig
from remosplat_drake.hardware.wire.base import (
    decode_base_status,
    extrapolated_pose,
)
from remosplat_drake.hardware.wire.localization import (
    BaseFix,
    encode_localization,
)

ODOMETRY = HardwareConfig()
LOCALIZED = HardwareConfig(localization=LocalizationConfig())
U = np.array([0.2, 0.0, 0.1])
PERIOD = 0.03


class Drive:
    """A base that drives at one speed, and its listener."""

    def __init__(self, config: HardwareConfig = ODOMETRY):
        self.config = config
        self.t = 1000.0
        self.track = BaseTrack()
        self.path = CommandedPath()
        self.pose = np.array([0.0, 0.0, 3.0])  # It turns past pi.
        self.off = np.zeros(3)
        self.late = 0.0
        self.fix_off = np.zeros(3)
        self.localizes = config.localization is not None

    def go_on(self, seconds: float, u: np.ndarray = U) -> str:
        """Drives on; returns what is wrong then."""
        for i in range(round(seconds / PERIOD)):
            self.path.append(self.t, U)
            self.t += PERIOD
            self.pose = extrapolated_pose(self.pose, u, PERIOD)
            self.hear(u)
            if self.localizes and i % 3 == 0:
                self.locate()
        return track_problem(self.track, self.config)

    def hear(self, u: np.ndarray = U) -> None:
        """Hears one status."""
        pose = self.pose + self.off
        pose[2] = (pose[2] + np.pi) % (2 * np.pi) - np.pi
        data = base_message(
            utime=round(1e6 * (self.t - self.late)),
            pose=pose.tolist(),
            forward=u[0],
            left=u[1],
            yaw_rate=u[2],
        )
        self.track = with_base_sample(
            self.track, decode_base_status(data), self.t, self.path, self.config
        )

    def locate(self, **fields) -> None:
        """Hears one fix, in whose map the odometry begins at (1, 0, 0)."""
        pose = self.pose + np.array([1.0, 0.0, 0.0]) + self.fix_off
        covariance = np.diag([1e-6, 1e-6, 1e-6])
        fix = BaseFix(pose, covariance, self.t, "map", "base_link")
        data = encode_localization(dc.replace(fix, **fields))
        self.track = with_localization(self.track, data, self.t)


def test_a_base_that_drives_is_believed():
    drive = Drive()
    assert drive.go_on(10.0) == ""
    np.testing.assert_allclose(drive.track.uncertainty, 0.0, atol=1e-6)
    assert (drive.track.pose(drive.pose) == drive.pose).all()


@pytest.mark.parametrize(
    ("off", "wait"),
    [
        ((0.05, 0, 0), 3.0),
        ((0, -0.3, 0), 3.0),
        # Beyond a moment, to drive elsewhere than ahead is another fault.
        ((0, 0, 0.1), PERIOD),
        ((0, 0, np.pi), PERIOD),
    ],
)
def test_a_jump_of_the_odometry_counts_until_it_is_undone(off, wait):
    drive = Drive()
    drive.go_on(1.0)
    drive.off = np.array(off)
    assert "the base's pose jumped by" in drive.go_on(PERIOD)
    assert "has not come back" in drive.go_on(wait)
    drive.off = np.zeros(3)
    assert drive.go_on(1.0) == ""


def test_a_base_that_stands_though_it_is_told_to_drive():
    drive = Drive()
    drive.go_on(1.0)
    assert "its commands amount to" in drive.go_on(0.3, np.zeros(3))


def test_a_drift_of_the_odometry():
    drive = Drive()
    drive.go_on(2.0)
    for _ in range(70):
        drive.off[0] -= 0.02 * PERIOD
        if "does not move as it should" in drive.go_on(PERIOD):
            break
    assert 0 < np.hypot(*drive.off[:2]) < 0.042


@pytest.mark.parametrize(
    ("late", "words"), [(0.2, "before it comes"), (-0.2, "in the future")]
)
def test_a_clock_that_is_off(late, words):
    drive = Drive()
    drive.go_on(1.0)
    drive.late = late
    problem = drive.go_on(0.3)
    assert problem.startswith("BASE_STATUS: stamped 200 ms")
    assert words in problem
    assert "set the clocks" in problem


def test_its_speed_while_nothing_came_is_unknown():
    """It brakes meanwhile: neither its last speed nor its next one is it."""
    drive = Drive()
    drive.go_on(2.0)
    silence, way = 1.0, 0.5 * U
    drive.t += silence
    drive.pose = extrapolated_pose(drive.pose, way, silence)
    drive.path.append(drive.t, U)
    drive.hear(0.0 * U)
    for _ in range(70):
        assert drive.go_on(PERIOD) == ""


@pytest.mark.parametrize("late", [0.2, -0.2])
def test_a_clock_that_is_set_right_is_no_disobedience(late):
    drive = Drive()
    drive.go_on(2.0)
    for drive.late in (late, 0.0):
        for _ in range(70):
            problem = drive.go_on(PERIOD)
            assert problem == "" or "set the clocks" in problem
    assert problem == ""


def test_what_the_stamps_are_late_makes_the_pose_uncertain():
    drive = Drive()
    drive.late = 0.1
    assert drive.go_on(1.0) == ""
    np.testing.assert_allclose(
        drive.track.uncertainty, 0.1 * U[[0, 2]], rtol=1e-3
    )
    drive.t += PERIOD
    drive.hear(np.zeros(3))
    assert (drive.track.uncertainty == 0.0).all()


def test_a_late_stamp_counts_before_the_speed_of_a_start_is_reported():
    drive = Drive()
    drive.late, rest = 0.1, np.zeros(3)
    for _ in range(10):
        drive.t += PERIOD
        drive.hear(rest)
    drive.t += PERIOD
    drive.pose = extrapolated_pose(drive.pose, U, PERIOD)
    drive.hear(rest)
    np.testing.assert_allclose(
        drive.track.uncertainty, 0.1 * U[[0, 2]], rtol=1e-3
    )


def test_a_localisation_says_where_the_base_is():
    drive = Drive(LOCALIZED)
    assert drive.go_on(3.0) == ""
    pose = drive.track.pose(drive.pose)
    np.testing.assert_allclose(pose - drive.pose, [1, 0, 0], atol=1e-3)
    assert (drive.track.uncertainty > 0).all()


def test_a_localisation_that_is_missing():
    drive = Drive(LOCALIZED)
    drive.localizes = False
    problem = "BASE_LOCALIZATION: nothing came yet"
    assert drive.go_on(1.0) == problem
    assert np.isnan(drive.track.pose(drive.pose)).all()
    drive.localizes = True
    assert drive.go_on(1.0) == ""
    drive.localizes = False
    assert drive.go_on(0.9) == ""
    assert "nothing new came for" in drive.go_on(0.3)


def test_a_localisation_that_repeats_itself_is_missing():
    drive = Drive(LOCALIZED)
    drive.go_on(1.0)
    stamp = drive.t
    drive.localizes = False
    for _ in range(50):
        problem = drive.go_on(PERIOD)
        drive.locate(stamp=stamp)
    assert "nothing new came for" in problem


def test_a_localisation_that_jumps_counts_until_it_comes_back():
    drive = Drive(LOCALIZED)
    drive.go_on(3.0)
    drive.fix_off = np.array([0.05, 0, 0])
    assert "BASE_LOCALIZATION: jumped by 5" in drive.go_on(0.2)
    drive.fix_off = np.zeros(3)
    assert drive.go_on(0.2) == ""


def test_a_localisation_in_another_frame_or_broken():
    drive = Drive(LOCALIZED)
    drive.go_on(1.0)
    drive.locate(frame="odom")
    assert "frame_id is 'odom', not 'map'" in track_problem(
        drive.track, LOCALIZED
    )
    drive.locate(covariance=-np.eye(3))
    assert "frame_id" in track_problem(drive.track, LOCALIZED)
    assert drive.go_on(0.2) == ""
    drive.track = with_localization(drive.track, b"rubbish", drive.t)
    assert "is not a whole base_localization" in track_problem(
        drive.track, LOCALIZED
    )


def test_too_uncertain_to_move():
    config = HardwareConfig(
        localization=LocalizationConfig(max_shift=0.03, expiry=60)
    )
    drive = Drive(config)
    assert drive.go_on(2.0) == ""
    drive.localizes = False
    assert "the base's position is uncertain by" in drive.go_on(20.0)


def test_odometry_that_jumps_is_doubted_where_there_is_a_localisation():
    drive = Drive(LOCALIZED)
    drive.go_on(2.0)
    drive.off = np.array([0.3, 0, 0])
    drive.localizes = False
    assert "uncertain by" in drive.go_on(PERIOD)
    drive.localizes = True
    drive.go_on(1.0)
    told = drive.track.pose(drive.pose + drive.off)
    off = np.hypot(*(told - drive.pose - [1, 0, 0])[:2])
    # It is led back slowly, and says how far it still is.
    assert off < drive.track.uncertainty[0]


def test_no_status_waits_for_the_compiler():
    compile_kernels(ODOMETRY)
    compiled = base_residual_kernel.path_residuals.variants
    assert not Drive().go_on(4.0)
    assert base_residual_kernel.path_residuals.variants == compiled
