"""The stand-in robot as a real process, heard and driven over the wire."""

import math
import time

import numpy as np
import pytest
from robot_process import Client, free_url, robot_process

from remosplat_drake.hardware.drivers.panda_limits import PANDA
from remosplat_drake.hardware.wire.messages.base_status import base_status

MOVE, REFLEX, USER_STOPPED = 2, 4, 5
STILL = 1e-3  # [rad/s]

SLOWLY = np.array([0.1, 0, 0, 0, 0, 0, -0.2])


@pytest.fixture(scope="module")
def url():
    url = free_url()
    with robot_process(url):
        yield url


@pytest.fixture
def client(url):
    """Somebody who hears a robot that stands still and is well."""
    client = Client(url)
    client.wait_for_robot()
    client.inject("recover")
    client.wait_for(
        lambda: (
            client.latest.robot_mode == MOVE
            and client.latest.num_joints == 7
            and not client.latest_base.emergency_stop
            and np.abs(client.latest.joint_velocity).max() < STILL
        )
    )
    client.listen_for(0.03)
    client.arm.clear()
    client.arrivals.clear()
    client.base.clear()
    yield client
    client.inject("recover")


def time_to_zero(client: Client, utime: int) -> float:
    """From a stamp to the last status that moves [s]."""
    moving = [
        status.utime
        for status in client.arm
        if np.abs(status.joint_velocity).max() > STILL
    ]
    return (moving[-1] - utime) / 1e6


def test_a_command_moves_the_joint_and_the_status_says_so(client):
    client.drive(0.4, SLOWLY)
    status, first = client.arm[-1], client.arm[0]
    np.testing.assert_allclose(status.joint_velocity, SLOWLY, atol=2e-3)
    np.testing.assert_allclose(status.joint_velocity_desired, SLOWLY, atol=2e-3)
    moved = np.subtract(status.joint_position, first.joint_position)
    assert 0.02 < moved[0] < 0.045
    assert -0.09 < moved[6] < -0.04
    np.testing.assert_allclose(moved[1:6], 0, atol=1e-3)


def test_the_status_is_filled_as_the_real_driver_does(client):
    client.drive(0.3, SLOWLY)
    status = client.arm[-1]
    assert status.num_joints == 7
    assert (status.robot_mode, status.control_mode) == (MOVE, 0)
    assert status.control_command_success_rate == 1.0
    assert abs(status.utime - client.arrivals[-1]) < 50_000
    utime = np.diff([s.utime for s in client.arm])
    robot_utime = np.diff([s.robot_utime for s in client.arm])
    assert (utime >= 0).all()
    # A status is lost only where this listener was late to fetch it.
    assert (robot_utime % 1000 == 0).all()
    assert np.median(robot_utime) == 1000


def test_the_arm_stops_when_the_commands_do(client):
    client.drive(0.3, SLOWLY)
    last = client.arm[-1].utime
    client.listen_for(0.5)
    # The expiry of 100 ms, then the ramp.
    assert 0.09 < time_to_zero(client, last) < 0.3


@pytest.mark.parametrize("age", [0.15, -0.15])
def test_a_stale_or_future_stamp_moves_nothing(client, age):
    for _ in range(5):
        client.send_arm(SLOWLY, age)
        client.send_base(0.2, 0.0, age)
        client.listen_for(0.01)
    assert np.abs(client.arm_velocities()).max() < STILL
    client.wait_for(lambda: len(client.base) > 5)
    assert max(abs(status.forward) for status in client.base) < STILL


def test_the_arm_keeps_its_limits_whatever_it_is_told(client):
    for sign in (1, -1):
        client.drive(0.1, sign * np.full(7, 3.0))
    client.listen_for(0.5)
    velocity = np.array([s.joint_velocity_desired for s in client.arm])
    acceleration = np.array([s.joint_acceleration_desired for s in client.arm])
    assert (np.abs(velocity) <= PANDA.velocity).all()
    assert (np.abs(acceleration) <= PANDA.acceleration).all()
    assert np.abs(velocity[:, 0]).max() > 0.5


def test_the_base_drives_and_its_watchdog_stops_it(client):
    client.drive(0.5, base=(0.15, 0.3))
    forward = [status.forward for status in client.base]
    assert max(forward) == pytest.approx(0.15, abs=0.02)
    assert client.base[-1].mode == base_status.MOVING
    assert client.base[-1].pose[0] > client.base[0].pose[0]
    client.wait_for(lambda: client.latest_base.mode == base_status.READY, 2.0)
    client.listen_for(0.15)
    assert client.base[-1].forward == pytest.approx(0.0, abs=1e-3)


def test_the_bases_speed_is_older_than_its_pose(client):
    """Poses come at 37 Hz, the speed at 10 Hz."""
    client.drive(0.6, base=(-0.2, -0.3))
    speeds = {status.forward for status in client.base}
    assert 15 <= len(client.base) <= 25
    assert 4 <= len(speeds) <= 8


def test_the_hand_closes(client):
    client.send_hand(0.06, 10.0)
    client.wait_for(lambda: abs(client.hand[-1].actual_position_mm - 60) < 1)
    client.send_hand(0.08, 10.0)
    client.wait_for(lambda: abs(client.hand[-1].actual_position_mm - 80) < 1)


# Faults


def test_statuses_stop_and_the_arm_goes_on(client):
    client.inject("status-stops")
    client.listen_for(0.05)
    client.arm.clear()
    client.drive(0.1, SLOWLY)
    assert not client.arm
    assert client.base
    client.inject("recover")
    client.drive(0.1, SLOWLY)
    assert np.abs(client.arm[0].joint_velocity).max() > STILL


def test_statuses_freeze_under_fresh_stamps(client):
    client.drive(0.2, SLOWLY)
    client.inject("status-freezes")
    client.listen_for(0.05)
    client.arm.clear()
    client.listen_for(0.2)
    assert len({tuple(s.joint_position) for s in client.arm}) == 1
    assert len({s.robot_utime for s in client.arm}) == 1
    assert client.arm[-1].utime - client.arm[0].utime > 150_000


def test_a_status_holds_what_is_not_a_number(client):
    client.inject("status-nan")
    client.wait_for(lambda: math.isnan(client.latest.joint_position[0]))
    assert np.isfinite(client.latest.joint_position[1:]).all()


def test_a_status_has_the_wrong_number_of_joints(client):
    client.inject("status-joints", 5)
    client.wait_for(lambda: client.latest.num_joints == 5)
    assert len(client.latest.joint_velocity) == 5


def test_the_clock_jumps_and_every_command_is_stale(client):
    client.drive(0.2, SLOWLY)
    client.inject("clock-jump", 2.0)
    client.drive(0.5, SLOWLY)
    ahead = (client.arm[-1].utime - client.arrivals[-1]) / 1e6
    assert ahead == pytest.approx(2.0, abs=0.1)
    assert np.abs(client.arm[-1].joint_velocity).max() < STILL


def test_packets_are_lost(client):
    client.inject("packet-loss", 0.25)
    client.wait_for(lambda: client.latest.control_command_success_rate == 0.75)


@pytest.mark.parametrize(
    ("fault", "mode"),
    [
        ("reflex", REFLEX),
        pytest.param("user-stop", USER_STOPPED, marks=pytest.mark.slow),
    ],
)
def test_a_stopped_arm_ignores_commands_until_it_recovers(client, fault, mode):
    client.drive(0.2, SLOWLY)
    client.inject(fault)
    client.drive(0.3, SLOWLY)
    assert client.arm[-1].robot_mode == mode
    assert client.arm[-1].control_command_success_rate == 0.0
    assert np.abs(client.arm[-1].joint_velocity).max() < STILL
    client.inject("recover")
    client.drive(0.2, SLOWLY)
    assert client.arm[-1].robot_mode == MOVE
    np.testing.assert_allclose(client.arm[-1].joint_velocity, SLOWLY, atol=5e-3)


def test_base_statuses_stop(client):
    client.inject("base-status-stops")
    client.listen_for(0.05)
    client.base.clear()
    client.listen_for(0.2)
    assert not client.base


def test_an_emergency_stop_holds_the_base(client):
    client.drive(0.2, base=(0.1, 0.0))
    client.inject("base-emergency-stop")
    client.drive(0.4, base=(0.1, 0.0))
    status = client.base[-1]
    assert status.emergency_stop
    assert status.mode == base_status.STOPPED
    assert status.forward == pytest.approx(0.0, abs=1e-3)


@pytest.mark.slow
def test_a_protective_stop_ends_by_itself_and_the_base_drives_on(client):
    client.inject("base-protective-stop")
    client.drive(0.3, base=(0.1, 0.0))
    assert client.base[-1].protective_stop
    assert client.base[-1].mode == base_status.STOPPED
    client.drive(2.2, base=(-0.1, 0.0))
    assert not client.base[-1].protective_stop
    assert client.base[-1].forward == pytest.approx(-0.1, abs=0.01)


# The process itself


@pytest.mark.slow
def test_faults_on_a_schedule_and_a_record_of_the_motion(tmp_path):
    url, record = free_url(), tmp_path / "motion.npz"
    with robot_process(
        url, "--fault", "status-stops@0.3+0.2", "--record", str(record)
    ) as process:
        client = Client(url)
        client.wait_for_robot()
        client.drive(1.0, SLOWLY)
        process.terminate()
        assert process.wait(20) == 0
    gaps = np.diff([status.robot_utime for status in client.arm]) / 1e6
    # This listener may lose statuses, too, but has heard some afterwards.
    assert gaps.max() > 0.19
    motion = np.load(record)
    assert motion["q"].shape[1] == 10
    assert motion["u"].shape == (len(motion["q"]), 9)
    assert motion["u"][:, 2].max() == pytest.approx(0.1, abs=0.01)


@pytest.mark.slow
def test_a_message_that_is_no_command_ends_the_process():
    url = free_url()
    with robot_process(url) as process:
        client = Client(url)
        client.wait_for_robot()
        client.send_arm(np.zeros(6))
        assert process.wait(20) == 2
        assert process.stderr
        lines = process.stderr.read().splitlines()
    assert lines[-1] == (
        "remosplat: PANDA_COMMAND: num_joint_velocity: must be 7, got 6"
    )


@pytest.mark.slow
def test_a_killed_robot_comes_back_on_the_same_wire():
    url = free_url()
    client = Client(url)
    for _ in range(2):
        with robot_process(url) as process:
            client.wait_for_robot()
            client.drive(0.2, SLOWLY)
            assert np.abs(client.arm[-1].joint_velocity).max() > STILL
            process.kill()
            process.wait(20)
        time.sleep(0.1)
        client.listen_for(0.05)
        client.arm.clear()
        client.base.clear()
        client.hand.clear()
