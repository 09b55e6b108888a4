"""The simulated arm and base, without a plant and without a wire."""

import time

import numpy as np
import pytest
from drake import lcmt_panda_command

from remosplat_drake.base.clock import Pacer
from remosplat_drake.hardware.drivers.panda_limits import (
    POSITION_LOWER,
    POSITION_UPPER,
)
from remosplat_drake.hardware.stand_in.simulated_arm import (
    ArmMeasurement,
    RobotMode,
    violates,
)
from remosplat_drake.hardware.stand_in.simulated_base import SimulatedBase
from remosplat_drake.hardware.stand_in.simulated_panda import (
    LIMITS,
    SimulatedPanda,
)
from remosplat_drake.hardware.wire.messages.base_command import base_command

NOW = 1_700_000_000_000_000
MIDDLE = (POSITION_LOWER + POSITION_UPPER) / 2
SLOW = 0.1


def measured(position=MIDDLE, external: float = 0.0) -> ArmMeasurement:
    zeros = np.zeros(7)
    return ArmMeasurement(position, zeros, zeros, np.full(7, external))


def arm_command(utime: int = NOW) -> bytes:
    message = lcmt_panda_command()
    message.utime = utime
    message.control_mode_expected = 2
    message.num_joint_velocity = 7
    message.joint_velocity = [SLOW] * 7
    return message.encode()


def driven_arm() -> SimulatedPanda:
    arm = SimulatedPanda()
    arm.commands.receive(arm_command())
    for _ in range(100):
        arm.step(NOW, measured())
    return arm


# The arm


def test_an_arm_follows_its_command():
    arm = driven_arm()
    np.testing.assert_allclose(arm.step(NOW, measured()), SLOW, atol=1e-5)
    assert arm.mode == RobotMode.MOVE


@pytest.mark.parametrize("torque", [21.0, -21.0])
def test_a_collision_is_a_reflex(torque):
    arm = driven_arm()
    arm.step(NOW, measured(external=torque))
    for _ in range(100):
        velocity = arm.step(NOW, measured())
    assert arm.mode == RobotMode.REFLEX
    assert np.abs(velocity).max() < 1e-5
    status = arm.status(NOW, measured())
    assert status.robot_mode == 4
    assert status.control_command_success_rate == 0.0
    arm.recover()
    for _ in range(100):
        velocity = arm.step(NOW, measured())
    np.testing.assert_allclose(velocity, SLOW, atol=1e-5)


@pytest.mark.parametrize("torque", [19.0, -19.0])
def test_a_touch_is_none(torque):
    assert not violates(measured(external=torque), np.zeros(7), LIMITS)


def test_a_joint_beyond_its_end_may_only_move_back():
    beyond = MIDDLE.copy()
    beyond[3] = POSITION_UPPER[3] + 0.01
    further, back = np.zeros(7), np.zeros(7)
    further[3], back[3] = 0.1, -0.1
    assert violates(measured(beyond), further, LIMITS)
    assert not violates(measured(beyond), back, LIMITS)
    assert not violates(measured(beyond), np.zeros(7), LIMITS)
    assert violates(measured(POSITION_LOWER - 0.01), -np.ones(7), LIMITS)


def test_the_desired_position_is_the_next_ticks():
    status = driven_arm().status(NOW, measured())
    ahead = np.subtract(status.joint_position_desired, status.joint_position)
    np.testing.assert_allclose(ahead, SLOW * 1e-3, atol=1e-8)
    assert status.robot_utime == 100_000


# The base

GOES = [0.2, 0.0, 0.4]
"""The velocity that `driven` commands [m/s, m/s, rad/s]."""


def base_message(forward: float, yaw_rate: float) -> bytes:
    message = base_command()
    message.utime, message.forward, message.yaw_rate = NOW, forward, yaw_rate
    return message.encode()


def driven(base: SimulatedBase, t: float, duration: float) -> np.ndarray:
    """The speed after driving from time t, with a command each 10 ms."""
    velocity = np.zeros(3)
    for i in range(round(duration / 0.001)):
        if i % 10 == 0:
            base.commands.receive(base_message(0.2, 0.4), t)
        velocity = base.step(NOW, t, 0.001)
        t += 0.001
    return velocity


def test_the_base_accelerates_as_it_can():
    """1 m/s^2 for 0.1 s."""
    assert driven(SimulatedBase(), 0.0, 0.1)[0] == pytest.approx(0.1)
    np.testing.assert_allclose(driven(SimulatedBase(), 0.0, 0.5), GOES)


def test_a_protective_stop_ends_after_two_seconds():
    base = SimulatedBase()
    driven(base, 0.0, 0.3)
    base.protective_stop(1.0)
    assert not driven(base, 1.0, 1.99).any()
    np.testing.assert_allclose(driven(base, 3.0, 0.3), GOES)


def test_an_emergency_stop_lasts():
    base = SimulatedBase()
    base.emergency_stop = True
    assert not driven(base, 0.0, 3.0).any()
    base.recover()
    assert driven(base, 3.0, 0.1).any()


def test_statuses_come_at_the_pace_of_the_odometry():
    """In a second: 37 poses, 27 ms apart, and 10 speeds."""
    base = SimulatedBase()
    statuses = [
        base.status(NOW, 1e-3 * i, np.zeros(3), np.array([i, 0.0, 0.0]))
        for i in range(1000)
    ]
    heard = [status for status in statuses if status is not None]
    assert 37 <= len(heard) <= 38
    assert 9 <= len({status.forward for status in heard}) <= 11


# The pace


def test_a_loop_that_stalls_forgets_the_backlog():
    pacer = Pacer(period=1e-3, patience=5e-3)
    pacer.wait()
    time.sleep(0.05)
    pacer.wait()
    assert pacer.missed >= 48
    assert pacer.worst >= 0.048


def test_a_sleep_that_lasts_too_long_is_a_delay(monkeypatch):
    pacer, sleep = Pacer(period=5e-3, patience=10.0), time.sleep
    pacer.wait()
    monkeypatch.setattr(time, "sleep", lambda t: sleep(t + 0.05))
    pacer.wait()
    assert pacer.late >= 0.05
    assert pacer.worst == pacer.late


def test_a_loop_is_not_faster_than_its_period():
    pacer = Pacer(period=1e-3)
    start = time.monotonic()
    for _ in range(21):
        pacer.wait()
    assert time.monotonic() - start >= 0.02
    assert pacer.ticks == 21
