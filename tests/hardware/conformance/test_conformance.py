"""The kit passes a good driver at every rate, and fails each bad one."""

import dataclasses as dc

import numpy as np
import pytest
from drake import lcmt_panda_command, lcmt_panda_status
from effort import effort

from remosplat_drake.hardware.conformance.checks import Seen, judge
from remosplat_drake.hardware.conformance.robot_record import (
    gather,
    restarted_drivers,
)
from remosplat_drake.hardware.doctor.finding import FAILED, PASSED, SKIPPED
from remosplat_drake.hardware.hardware_config import HardwareConfig
from remosplat_drake.hardware.wire.channels import (
    BASE_COMMAND,
    BASE_STATUS,
    PANDA_COMMAND,
    PANDA_STATUS,
)
from remosplat_drake.hardware.wire.lease import (
    DRIVER_REPORT,
    Identity,
    Report,
    encode_report,
)
from remosplat_drake.hardware.wire.messages.base_command import base_command
from remosplat_drake.hardware.wire.messages.base_status import base_status
from remosplat_drake.hardware.wire.multicast import Packet
from remosplat_drake.hardware.wire.packets import to_utime
from remosplat_drake.robot.robot_model import RobotModel, load_robot

START = 1_700_000_000.0
PERIOD = 0.01
STEP = 0.001


@pytest.fixture(scope="module")
def ur5e() -> RobotModel:
    return load_robot("ur5e")


@dc.dataclass
class Driver:
    """A robot that follows at once, and what its driver makes of it."""

    rate: float = 500.0
    delay: float = 0.005
    old: float = 0.0
    hides_age: bool = False
    constant_mode: bool = False
    has_velocities: bool = True
    order: tuple[int, ...] = (0, 1, 2, 3, 4, 5)
    factor: float = 1.0
    still: tuple[int, ...] = ()

    def heard(self, n: int = 6) -> list[Packet]:
        """What is on the wire while each axis moves forth and back.

        The stop is pressed in the last half second, in which nothing moves.
        """
        random = np.random.default_rng(0)
        times = np.arange(0.0, n + 1.0, STEP)
        u = np.zeros((len(times), n))
        for axis in range(n):
            if axis not in self.still:
                on = (times >= axis) & (times < axis + 1)
                u[on, axis] = 0.4 * np.sin(2 * np.pi * times[on])
        # Commands are held until the next one.
        u = u[(np.arange(len(times)) // 10) * 10]
        late = round(self.delay / STEP)
        v = np.vstack([np.zeros((late, n)), u[: len(u) - late]])
        q = np.cumsum(v, axis=0) * STEP
        packets = []
        for k in range(0, len(times), round(PERIOD / STEP)):
            packets.append(_command(times[k], u[k]))
        every = round(1 / (self.rate * STEP))
        for k in range(0, len(times), every):
            order = list(self.order)[:n]
            status = lcmt_panda_status()
            status.num_joints = n
            status.joint_position = (self.factor * q[k, order]).tolist()
            rates = self.factor * v[k, order] * self.has_velocities
            status.joint_velocity = rates.tolist()
            for name in status.__slots__:
                if name.startswith("joint_") and not getattr(status, name):
                    setattr(status, name, [0.0] * n)
            pressed = times[k] > n + 0.5 and not self.constant_mode
            status.robot_mode = 5 if pressed else 2
            comes = times[k] + self.old + 0.001 * random.random()
            stamp = comes if self.hides_age else times[k]
            status.utime = to_utime(START + stamp)
            packets.append(
                Packet(PANDA_STATUS, status.encode(), "a:1", START + comes)
            )
        return packets


def _command(t: float, u: np.ndarray) -> Packet:
    message = lcmt_panda_command()
    message.utime = to_utime(START + t)
    message.num_joint_velocity = len(u)
    message.joint_velocity = u.tolist()
    message.control_mode_expected = 2
    return Packet(PANDA_COMMAND, message.encode(), "b:1", START + t)


def results(driver: Driver, robot: RobotModel) -> dict[str, str]:
    config = HardwareConfig(arm_status_rate=driver.rate)
    record = gather(driver.heard(), config, robot, 7.0)
    findings = judge(record, config, robot.assumed_actuators)
    return {finding.check: finding.result for finding in findings}


@pytest.mark.parametrize(
    "rate", effort([20.0, 1000.0], [20.0, 50.0, 125.0, 500.0, 1000.0])
)
def test_a_good_driver_passes(rate, ur5e):
    found = results(Driver(rate), ur5e)
    assert found.pop("restart") == SKIPPED
    assert set(found.values()) == {PASSED}, found
    assert len(found) == 5 + 3 * 6


@pytest.mark.parametrize(
    ("driver", "wrong"),
    [
        (Driver(old=0.1), {"age of measurements"}),
        (Driver(old=0.1, hides_age=True), {"latency"}),
        (Driver(constant_mode=True), {"mode and emergency stop"}),
        (Driver(has_velocities=False), {"velocity"}),
        (Driver(delay=0.045), {"latency"}),
        (Driver(order=(0, 2, 1, 3, 4, 5)), {"axis"}),
        (Driver(factor=-1.0), {"axis"}),
        (Driver(factor=180 / np.pi), {"axis"}),
    ],
    ids=lambda value: str(value) if isinstance(value, set) else "",
)
def test_each_bad_driver_fails(driver, wrong, ur5e):
    joints = [f"arm: {joint}" for joint in ur5e.description.arm.joints]
    failed = {
        "axis" if check in joints else check.rpartition(": ")[2]
        for check, result in results(driver, ur5e).items()
        if result == FAILED
    }
    assert failed >= wrong
    # An axis that follows another's commands has no latency of its own.
    assert failed <= wrong | ({"latency"} if "axis" in wrong else set())


def test_an_axis_that_was_not_moved_is_not_judged(ur5e):
    found = results(Driver(still=(3,)), ur5e)
    assert found["arm: wrist_1_joint"] == SKIPPED
    assert found["arm: elbow_joint"] == PASSED


def test_statuses_that_are_broken_or_absent_are_told(ur5e):
    config = HardwareConfig()
    packets = Driver().heard()
    spoilt = [
        p._replace(data=p.data[:-9]) if p.channel == PANDA_STATUS else p
        for p in packets
    ]
    record = gather(spoilt, config, ur5e, 7.0)
    (finding, _) = judge(record, config, ur5e.assumed_actuators)
    assert (finding.check, finding.result) == ("arm: statuses", FAILED)
    assert "not a whole lcmt_panda_status" in finding.found


def test_what_is_still_to_be_seen_is_said(ur5e):
    config, seen = HardwareConfig(), Seen()
    packets = Driver(still=(3,)).heard()
    seen.add(gather(packets[:10], config, ur5e, 1.0))
    axes, stop, _ = seen.missing(stop=True, restart=True)
    assert axes.startswith("motion of shoulder_pan_joint"), "0.01 rad so far"
    assert stop == "a stop of the arm"
    seen.add(gather(packets[:20], config, ur5e, 1.0))
    axes, _, _ = seen.missing(stop=True, restart=True)
    assert axes.startswith("motion of shoulder_lift_joint")
    seen.add(gather(packets, config, ur5e, 1.0))
    still = ["motion of wrist_1_joint"]
    assert seen.missing(stop=True, restart=False) == still
    assert seen.missing(True, True) == [*still, "a restart of a driver"]
    seen.add(gather([report(1, "arm-driver", 0.0)], config, ur5e, 1.0))
    seen.add(gather([report(1, "arm-driver", 2.0)], config, ur5e, 1.0))
    assert seen.missing(True, True) == [*still, "a restart of a driver"]
    seen.add(gather([report(2, "arm-driver", 3.0)], config, ur5e, 1.0))
    assert seen.missing(True, True) == still


def report(session: int, name: str, t: float) -> Packet:
    """A driver's report that arrives at a time [s]."""
    identity = Identity(session, 1, "host", name)
    data = encode_report(Report(identity))
    return Packet(DRIVER_REPORT, data, "a:1", START + t)


@pytest.mark.parametrize(
    ("reports", "names"),
    [
        ([(1, "arm", 0.0), (2, "arm", 1.0)], ["arm"]),
        ([(1, "arm", 0.0), (2, "hand", 1.0), (3, "base", 2.0)], []),
        # Two arms of one robot.
        ([(1, "arm", 0.0), (2, "arm", 0.1), (1, "arm", 0.2)], []),
    ],
)
def test_a_restart_is_a_session_that_follows_another(reports, names, ur5e):
    packets = [report(*told) for told in reports]
    record = gather(packets, HardwareConfig(), ur5e, 7.0)
    assert restarted_drivers(record.drivers.values()) == names


def test_an_omnidirectional_base_is_judged_by_its_own_axes():
    robot = load_robot("ridgeback_panda")
    config, packets = HardwareConfig(), []
    x = y = 0.0
    for k in range(400):
        t = 0.01 * k
        forward, left = (0.3, 0.0) if k < 150 else (0.0, 0.2)
        if k >= 300:
            forward = left = 0.0
        command = base_command()
        command.utime = to_utime(START + t)
        command.forward, command.left = forward, left
        packets.append(Packet(BASE_COMMAND, command.encode(), "b:1", START + t))
        status = base_status()
        status.utime = to_utime(START + t)
        status.pose = [x, y, 0.0]
        status.forward, status.left = forward, left
        status.mode = base_status.STOPPED if k > 350 else base_status.MOVING
        packets.append(Packet(BASE_STATUS, status.encode(), "a:1", START + t))
        x, y = x + 0.01 * forward, y + 0.01 * left
    record = gather(packets, config, robot, 4.0)
    findings = judge(record, config, robot.assumed_actuators)
    found = {finding.check: finding.result for finding in findings}
    assert found["base: forward"] == found["base: left"] == PASSED
    assert found["base: yaw"] == SKIPPED
    assert found["base: mode and emergency stop"] == PASSED
