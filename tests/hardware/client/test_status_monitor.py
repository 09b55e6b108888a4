"""Messages of the station about a robot in every state."""

import math

import numpy as np
import pytest
from drake import lcmt_panda_status
from wire_messages import arm_message, base_message

from remosplat_drake.hardware.client.measurement import (
    Measurement,
    with_arm_status,
    with_base_status,
    with_hand_status,
)
from remosplat_drake.hardware.client.status_monitor import station_status
from remosplat_drake.hardware.hardware_config import HardwareConfig
from remosplat_drake.hardware.wire.messages.base_status import base_status
from remosplat_drake.signals.station_status import RUNNING, STOPPED

CONFIG = HardwareConfig()
T = 1000.0


AT_REST = {"forward": 0.0, "left": 0.0, "yaw_rate": 0.0}


def stamped(time: float) -> dict:
    return {"utime": round(time * 1e6)}


def heard(
    arm: dict | None = None, base: dict | None = None, end: float = T
) -> Measurement:
    """A second of good messages; the last ones have some fields replaced."""
    measurement = Measurement()
    for i in range(101):
        t = end - 1 + 0.01 * i
        last = i == 100
        fields = {**stamped(t), "robot_utime": 10_000 * i + 1}
        measurement = with_arm_status(
            measurement,
            arm_message(**fields, **((arm or {}) if last else {})),
            t,
            7,
            CONFIG,
        )
        measurement = with_base_status(
            measurement,
            base_message(
                **(AT_REST | stamped(t)),
                **((base or {}) if last else {}),
            ),
            t,
            CONFIG,
        )
    return measurement


def status(measurement: Measurement, now: float = T + 0.002):
    return station_status(measurement, CONFIG, True, now)


def test_all_is_well():
    s = status(heard())
    assert (s.mode, s.stop_reason) == (RUNNING, "")
    assert s.age == pytest.approx(0.002)
    assert (s.robot_mode, s.success_rate) == ("move", 0.98)
    assert not s.protective_stop


def test_before_anything_was_heard():
    s = status(Measurement())
    assert (s.mode, s.age) == (STOPPED, math.inf)
    assert s.stop_reason == "PANDA_STATUS: nothing came yet"


def test_an_arm_without_its_base():
    measurement = with_arm_status(
        Measurement(), arm_message(**stamped(T)), T, 7, CONFIG
    )
    assert status(measurement).stop_reason == "BASE_STATUS: nothing came yet"
    alone = station_status(measurement, CONFIG, False, T)
    assert alone.mode == RUNNING


@pytest.mark.parametrize(
    ("arm", "base", "reason"),
    [
        (
            {"joint_position": [np.nan] * 7},
            {},
            "PANDA_STATUS: joint_position[0] is nan",
        ),
        (
            {"num_joints": 6},
            {},
            "PANDA_STATUS: has 6 joints, not 7",
        ),
        (
            {"robot_mode": lcmt_panda_status.kReflex},
            {},
            "the arm is in mode reflex",
        ),
        (
            {"robot_mode": lcmt_panda_status.kUserStopped},
            {},
            "the arm is in mode user_stopped",
        ),
        ({}, {"protective_stop": 1}, "protective stop of the base"),
        ({}, {"emergency_stop": 1}, "emergency stop of the base"),
        ({}, {"mode": base_status.FAULT}, "the base is at fault"),
        ({}, {"pose": [np.nan] * 3}, "BASE_STATUS: pose[0] is nan"),
    ],
)
def test_a_robot_that_will_not_move_says_why(arm, base, reason):
    s = status(heard(arm, base))
    assert (s.mode, s.stop_reason) == (STOPPED, reason)


def test_a_broken_message_leaves_the_state_before_it():
    measurement = heard({"joint_position": [np.nan] * 7})
    assert measurement.arm is not None
    assert np.isfinite(measurement.arm.q).all()
    assert status(measurement).age == pytest.approx(0.012)


def test_the_arm_is_stale_before_the_base_is():
    measurement = heard()
    assert status(measurement, T + 0.04).mode == RUNNING
    assert "PANDA_STATUS: nothing" in status(measurement, T + 0.06).stop_reason
    fresh = with_arm_status(
        measurement, arm_message(**stamped(T + 0.2)), T + 0.2, 7, CONFIG
    )
    assert status(fresh, T + 0.201).mode == RUNNING
    fresh = with_arm_status(
        measurement, arm_message(**stamped(T + 0.3)), T + 0.3, 7, CONFIG
    )
    assert "BASE_STATUS: nothing" in status(fresh, T + 0.301).stop_reason


@pytest.mark.parametrize(
    ("robot_clock", "told_to_move", "frozen"),
    [(7, False, True), (7, True, True), (0, True, True), (0, False, False)],
)
def test_a_frozen_arm_with_fresh_stamps(robot_clock, told_to_move, frozen):
    """Its own clock gives it away; without one, that it does not move."""
    measurement = Measurement(moving_since=T - 1 if told_to_move else math.inf)
    for i in range(101):
        t = T - 1 + 0.01 * i
        message = arm_message(**stamped(t), robot_utime=robot_clock)
        measurement = with_arm_status(measurement, message, t, 7, CONFIG)
    reason = station_status(measurement, CONFIG, False, T).stop_reason
    assert ("frozen for 1 s" in reason) == frozen


def test_a_broken_gripper_stops_nothing():
    measurement = with_hand_status(heard(), b"rubbish")
    assert measurement.hand is None
    assert status(measurement).mode == RUNNING


def test_a_base_whose_pose_jumped_is_lost():
    s = status(heard(base={"pose": [1.0, 0.0, 0.0]}))
    assert s.mode == STOPPED and "jumped" in s.stop_reason
    assert s.is_lost
    assert not status(heard(base={"protective_stop": 1})).is_lost
    assert not status(heard()).is_lost
