"""The stand-in robot, its wire and its clock in one process.

Time passes only while a client listens, a millisecond a step, so that each
duration here is the robot's own.
"""

import math

import numpy as np
import pytest
from pydrake.lcm import DrakeLcm
from robot_process import Client

from remosplat_drake.app.scenario import load_scenario
from remosplat_drake.app.world import World, load_world
from remosplat_drake.base import clock
from remosplat_drake.base.clock import Pacer
from remosplat_drake.hardware.drivers.panda_limits import (
    AT_REST,
    PANDA,
    TICK,
    limit_rate,
)
from remosplat_drake.hardware.stand_in import fci_library
from remosplat_drake.hardware.stand_in.faults import Fault
from remosplat_drake.hardware.stand_in.fci_arm import FciArm
from remosplat_drake.hardware.stand_in.fci_packets import Kind, Request
from remosplat_drake.hardware.stand_in.hardware_sim import HardwareSim
from remosplat_drake.hardware.stand_in.robot_plant import PERIOD, RobotPlant
from remosplat_drake.hardware.wire.messages.base_status import base_status
from remosplat_drake.station.station_config import DynamicStation

MOVE, REFLEX, USER_STOPPED = 2, 4, 5
STILL = 1e-3  # [rad/s]
NOW = 1_700_000_000_000_000

SLOWLY = np.array([0.1, 0, 0, 0, 0, 0, -0.2])


class Lab(Client):
    """A robot and its client, with a common clock.

    Attributes:
        robot: The robot.
        utime: The wall clock [us].
    """

    def __init__(self, plant: RobotPlant, *schedule: Fault):
        wire = DrakeLcm("memq://")
        super().__init__(wire, lambda: self.utime)
        self.utime = NOW
        self.robot = HardwareSim(plant, wire, schedule, lambda: self.utime)

    @property
    def time(self) -> float:
        return self.robot.time

    def listen(self, timeout: float = 0.0) -> None:
        self.utime += 1000
        self.robot.step()
        super().listen(0.0)

    def drive_for(
        self,
        duration: float,
        arm: np.ndarray | None = None,
        base: tuple[float, float] | None = None,
    ) -> None:
        """Repeats a command for some time [s]."""
        end = self.time + duration - 1e-9
        self.drive(lambda: self.time >= end, arm, base)

    def forget(self) -> None:
        """Forgets all statuses so far."""
        for statuses in (self.arm, self.base, self.hand):
            statuses.clear()

    def arm_velocities(self) -> np.ndarray:
        """Measured joint rates of all statuses, shape (n, 7) [rad/s]."""
        return np.array([status.joint_velocity for status in self.arm])


@pytest.fixture(scope="module")
def world() -> World:
    return load_world(load_scenario(), blank=True)


def make_lab(world: World, *schedule: Fault, period: float = PERIOD) -> Lab:
    """A robot that stands still; its bodies are stepped once a period [s]."""
    station = DynamicStation(time_step=period)
    plant = RobotPlant(station, world.robot, world.truth, world.q0)
    return Lab(plant, *schedule)


@pytest.fixture
def lab(world) -> Lab:
    return make_lab(world)


def time_to_zero(lab: Lab, utime: int) -> float:
    """From a stamp to the last status that moves [s]."""
    moving = [
        status.utime
        for status in lab.arm
        if np.abs(status.joint_velocity).max() > STILL
    ]
    return (moving[-1] - utime) / 1e6


def test_a_command_moves_the_joint_and_the_status_says_so(lab):
    lab.drive_for(0.4, SLOWLY)
    status, first = lab.arm[-1], lab.arm[0]
    np.testing.assert_allclose(status.joint_velocity, SLOWLY, atol=2e-3)
    np.testing.assert_allclose(status.joint_velocity_desired, SLOWLY, atol=2e-3)
    moved = np.subtract(status.joint_position, first.joint_position)
    assert 0.035 < moved[0] < 0.04
    assert -0.08 < moved[6] < -0.07
    np.testing.assert_allclose(moved[1:6], 0, atol=1e-3)


def test_the_status_is_filled_as_the_real_driver_does(lab):
    lab.drive_for(0.3, SLOWLY)
    status = lab.arm[-1]
    assert status.num_joints == 7
    assert (status.robot_mode, status.control_mode) == (MOVE, 0)
    assert status.control_command_success_rate == 1.0
    assert status.utime == lab.utime
    assert [s.utime - NOW for s in lab.arm] == [*range(1000, 301_000, 1000)]
    assert [s.robot_utime for s in lab.arm] == [*range(1000, 301_000, 1000)]


def test_the_arm_stops_when_the_commands_do(lab):
    lab.drive_for(0.3, SLOWLY)
    last = lab.arm[-1].utime
    lab.listen_for(0.5)
    # The expiry of 100 ms, less those since the last command; then the ramp.
    assert 0.09 < time_to_zero(lab, last) < 0.3


def test_after_a_stall_commands_are_heard_when_they_were_sent(lab):
    """The computer stalls for 20 ms; the arm is told to stop in the middle."""
    lab.drive_for(0.2, SLOWLY)
    began = lab.utime
    lab.forget()
    lab.utime += 10_000
    lab.send_arm(np.zeros(7))
    lab.utime += 10_000
    for late in range(19, -1, -1):
        lab.robot.step(1e-3 * late)
        Client.listen(lab, 0.0)
    told = {
        status.utime - began: status.joint_velocity_desired[0]
        for status in lab.arm
    }
    assert told.keys() >= {8000, 20000}
    for time, velocity in told.items():
        is_slower = velocity < SLOWLY[0] - 1e-3
        assert is_slower == (time >= 10_000), told


class VirtualTime:
    """Stands in for the module `time`; its next sleep takes longer by `stall`.

    Attributes:
        now: The time [s].
        stall: Excess duration of the next sleep [s].
    """

    def __init__(self):
        self.now = self.stall = 0.0

    def monotonic(self) -> float:
        return self.now

    def sleep(self, duration: float) -> None:
        self.now += duration + self.stall
        self.stall = 0.0


def test_positions_keep_their_stamps_if_a_sleep_lasts_too_long(
    world, monkeypatch
):
    """As if the system had stopped robot and controller for 60 ms."""
    lab, virtual = make_lab(world), VirtualTime()
    monkeypatch.setattr(clock, "time", virtual)
    pacer, sent = Pacer(TICK, patience=0.1), -1.0
    for k in range(700):
        virtual.stall = 0.06 * (k == 500)
        pacer.wait()
        lab.utime = NOW + round(1e6 * virtual.now)
        if virtual.now - sent > 0.01:
            sent = virtual.now
            lab.send_arm(SLOWLY)
        lab.robot.step(pacer.late)
        Client.listen(lab, 0.0)
    assert pacer.missed == 0
    moving = [status for status in lab.arm if status.utime > NOW + 400_000]
    t = np.array([1e-6 * (status.utime - NOW) for status in moving])
    q = np.array([status.joint_position for status in moving])
    expected = q[0] + (t - t[0])[:, None] * SLOWLY
    np.testing.assert_allclose(q, expected, atol=1e-3)


@pytest.mark.parametrize("age", [0.15, -0.15])
def test_a_stale_or_future_stamp_moves_nothing(lab, age):
    for _ in range(5):
        lab.send_arm(SLOWLY, age)
        lab.send_base((0.2, 0.0), age)
        lab.listen_for(0.03)
    assert np.abs(lab.arm_velocities()).max() < STILL
    assert len(lab.base) > 5
    assert max(abs(status.forward) for status in lab.base) < STILL


def test_the_arm_keeps_its_limits_whatever_it_is_told(lab):
    for sign in (1, -1):
        lab.drive_for(0.1, sign * np.full(7, 3.0))
    lab.listen_for(0.5)
    velocity = np.array([s.joint_velocity_desired for s in lab.arm])
    acceleration = np.array([s.joint_acceleration_desired for s in lab.arm])
    assert (np.abs(velocity) <= PANDA.velocity).all()
    assert (np.abs(acceleration) <= PANDA.acceleration).all()
    assert np.abs(velocity[:, 0]).max() > 0.5


def test_the_base_drives_and_its_watchdog_stops_it(lab):
    lab.drive_for(0.5, base=(0.15, 0.3))
    forward = [status.forward for status in lab.base]
    assert max(forward) == pytest.approx(0.15, abs=0.02)
    assert lab.base[-1].mode == base_status.MOVING
    assert lab.base[-1].pose[0] > lab.base[0].pose[0]
    # The expiry, the ramp down from 0.15 m/s, and a measurement of the speed.
    lab.listen_for(0.4)
    assert lab.base[-1].mode == base_status.READY
    assert lab.base[-1].forward == pytest.approx(0.0, abs=1e-3)


def test_the_bases_speed_is_older_than_its_pose(lab):
    """Poses come at 37 Hz, the speed at 10 Hz."""
    lab.drive_for(0.6, base=(-0.2, -0.3))
    speeds = {status.forward for status in lab.base}
    assert 22 <= len(lab.base) <= 23
    assert 6 <= len(speeds) <= 7


def test_the_hand_closes(lab):
    lab.send_hand(0.06, 10.0)
    lab.wait_for(
        lambda: lab.hand and abs(lab.hand[-1].actual_position_mm - 60) < 1
    )
    lab.send_hand(0.08, 10.0)
    lab.wait_for(lambda: abs(lab.hand[-1].actual_position_mm - 80) < 1)


# Faults


def test_statuses_stop_and_the_arm_goes_on(lab):
    lab.inject("status-stops")
    lab.drive_for(0.1, SLOWLY)
    assert not lab.arm
    assert lab.base
    lab.inject("recover")
    lab.listen()
    assert np.abs(lab.arm[0].joint_velocity).max() > STILL


def test_statuses_freeze_under_fresh_stamps(lab):
    lab.drive_for(0.2, SLOWLY)
    lab.inject("status-freezes")
    lab.forget()
    lab.listen_for(0.2)
    assert len({tuple(s.joint_position) for s in lab.arm}) == 1
    assert len({s.robot_utime for s in lab.arm}) == 1
    assert len({s.utime for s in lab.arm}) == len(lab.arm) >= 200


def test_a_status_holds_what_is_not_a_number(lab):
    lab.inject("status-nan")
    lab.listen()
    assert math.isnan(lab.latest.joint_position[0])
    assert np.isfinite(lab.latest.joint_position[1:]).all()


def test_a_status_has_the_wrong_number_of_joints(lab):
    lab.inject("status-joints", 5)
    lab.listen()
    assert lab.latest.num_joints == 5
    assert len(lab.latest.joint_velocity) == 5


def test_the_clock_jumps_and_every_command_is_stale(lab):
    lab.drive_for(0.2, SLOWLY)
    lab.inject("clock-jump", 2.0)
    lab.drive_for(0.5, SLOWLY)
    assert lab.latest.utime - lab.utime == 2_000_000
    assert np.abs(lab.latest.joint_velocity).max() < STILL


def test_packets_are_lost(lab):
    lab.inject("packet-loss", 0.25)
    lab.listen()
    assert lab.latest.control_command_success_rate == 0.75


@pytest.mark.parametrize(
    ("fault", "mode"), [("reflex", REFLEX), ("user-stop", USER_STOPPED)]
)
def test_a_stopped_arm_ignores_commands_until_it_recovers(lab, fault, mode):
    lab.drive_for(0.2, SLOWLY)
    lab.inject(fault)
    lab.drive_for(0.3, SLOWLY)
    assert lab.latest.robot_mode == mode
    assert lab.latest.control_command_success_rate == 0.0
    assert np.abs(lab.latest.joint_velocity).max() < STILL
    lab.inject("recover")
    lab.drive_for(0.2, SLOWLY)
    assert lab.latest.robot_mode == MOVE
    np.testing.assert_allclose(lab.latest.joint_velocity, SLOWLY, atol=5e-3)


def test_base_statuses_stop(lab):
    lab.inject("base-status-stops")
    lab.listen_for(0.2)
    assert lab.arm
    assert not lab.base


def test_an_emergency_stop_holds_the_base(lab):
    lab.drive_for(0.2, base=(0.1, 0.0))
    lab.inject("base-emergency-stop")
    lab.drive_for(0.4, base=(0.1, 0.0))
    status = lab.base[-1]
    assert status.emergency_stop
    assert status.mode == base_status.STOPPED
    assert status.forward == pytest.approx(0.0, abs=1e-3)


def test_a_protective_stop_ends_by_itself_and_the_base_drives_on(lab):
    lab.inject("base-protective-stop")
    lab.drive_for(0.3, base=(0.1, 0.0))
    assert lab.base[-1].protective_stop
    assert lab.base[-1].mode == base_status.STOPPED
    lab.drive_for(2.1, base=(-0.1, 0.0))
    assert not lab.base[-1].protective_stop
    assert lab.base[-1].forward == pytest.approx(-0.1, abs=0.01)


def test_a_fault_on_a_schedule_counts_from_the_first_command(world):
    lab = make_lab(world, Fault("status-stops", 0.0, start=0.1, end=0.3))
    lab.listen_for(0.05)
    start = lab.latest.robot_utime
    lab.drive_for(0.5, SLOWLY)
    utime = np.array([status.robot_utime for status in lab.arm])
    (gap,) = np.flatnonzero(np.diff(utime) > 1000)
    assert utime[gap] == pytest.approx(start + 100_000, abs=2000)
    assert utime[gap + 1] == pytest.approx(start + 300_000, abs=2000)


def test_the_arm_may_obey_a_driver_of_its_own(world):
    """By `--fci`: the wire neither moves it nor hears of it."""
    plant = RobotPlant(DynamicStation(), world.robot, world.truth, world.q0)
    arm = FciArm()
    wire = DrakeLcm("memq://")
    robot, client = HardwareSim(plant, wire, fci=arm), Client(wire)
    start = plant.q.copy()
    library = fci_library.Robot(str(arm.port))
    library._send(Request(Kind.BEGIN))
    command = AT_REST
    for _ in range(200):
        client.send_arm(-SLOWLY)
        robot.step()
        client.listen(0.0)
        number = library._latest().number
        command = limit_rate(SLOWLY, command)
        answer = Request(Kind.COMMAND, number, tuple(command.velocity))
        library._send(answer)
    assert not client.arm
    assert client.base
    moved = plant.q[3:] - start[3:]
    np.testing.assert_allclose(moved, 0.19 * SLOWLY, atol=2e-3)
    arm.close()


def test_fewer_steps_of_the_bodies_tell_the_same(world):
    """Between them every status goes on by the velocity that it tells."""
    fine, coarse = make_lab(world, period=0.001), make_lab(world)
    for lab in (fine, coarse):
        lab.drive_for(0.4, SLOWLY, (0.1, 0.2))
    exact, q = (
        np.array([status.joint_position for status in lab.arm])
        for lab in (fine, coarse)
    )
    np.testing.assert_allclose(q, exact, atol=0.2 * PERIOD)
    np.testing.assert_allclose(
        coarse.base[-1].pose, fine.base[-1].pose, atol=0.2 * PERIOD
    )
    np.testing.assert_allclose(
        np.diff(q, axis=0)[-50:],
        1e-3 * coarse.arm_velocities()[-50:],
        atol=1e-7,
    )
    np.testing.assert_allclose(coarse.arm_velocities()[-1], SLOWLY, atol=1e-4)


def test_a_computer_that_stalls_does_not_hold_the_robot_up(world):
    steady, stalled = make_lab(world), make_lab(world)
    for lab in (steady, stalled):
        lab.drive_for(0.2, SLOWLY, (0.1, 0.2))
        lab.forget()
    for _ in range(100):
        steady.listen()
    stalled.utime += 100_000
    for k in range(1, 101):
        stalled.robot.step(late=(100 - k) * 1e-3)
        Client.listen(stalled, 0.0)
    assert stalled.time == steady.time
    np.testing.assert_allclose(
        stalled.arm[-1].joint_position, steady.arm[-1].joint_position
    )
    # Everything is stamped with when it was so; of the arm's there are less.
    told = {status.utime: status.pose for status in steady.base}
    assert {status.utime: status.pose for status in stalled.base} == told
    stamps = [status.utime for status in stalled.arm]
    assert 25 <= len(stamps) < 30
    assert set(stamps) <= {status.utime for status in steady.arm}


@pytest.mark.parametrize(
    ("name", "base", "hand"),
    [("Ur5eReach", False, False), ("FetchReach", True, True)],
)
def test_another_robot_obeys_with_what_it_has(name, base, hand):
    world = load_world(load_scenario(name), blank=True)
    lab = make_lab(world)
    rates = np.zeros(len(world.robot.home))
    rates[[0, -1]] = 0.05, -0.2
    lab.drive_for(0.4, rates, (0.2, 0.0) if base else None)
    moved = np.subtract(lab.arm[-1].joint_position, lab.arm[0].joint_position)
    np.testing.assert_allclose(moved[[0, -1]], [0.02, -0.08], atol=0.008)
    np.testing.assert_allclose(moved[1:-1], 0, atol=2e-3)
    assert (bool(lab.base), bool(lab.hand)) == (base, hand)
    if base:
        assert lab.base[-1].pose[0] > world.q0[0] + 0.02
    lab.inject("user-stop")
    lab.drive_for(0.3, rates)
    assert lab.latest.robot_mode == USER_STOPPED
    assert np.abs(lab.latest.joint_velocity).max() < STILL


def test_an_omnidirectional_base_goes_aside():
    world = load_world(load_scenario("RidgebackReach"), blank=True)
    lab = make_lab(world)
    lab.wait_for_robot()
    start = lab.base[-1].pose
    end = lab.time + 0.5
    lab.drive(lambda: lab.time >= end, base=(0.0, 0.2, 0.0))
    assert lab.base[-1].left == pytest.approx(0.2, abs=0.02)
    x, y, _ = np.subtract(lab.base[-1].pose, start)
    # 0.2 m/s after a ramp of 0.2 s.
    assert (x, y) == pytest.approx((0.0, 0.08), abs=0.015)
