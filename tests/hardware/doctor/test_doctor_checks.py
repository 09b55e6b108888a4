"""The doctor's checks on what they read, without a robot."""

import dataclasses as dc
import re
import threading
import time

import numpy as np
import pytest
from drake import lcmt_panda_status
from patience import PATIENCE
from pydrake.lcm import DrakeLcm

from remosplat_drake.acceptance.hardware_processes import free_url
from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.hardware.doctor import drills, host_checks, wire_checks
from remosplat_drake.hardware.doctor.doctor_report import (
    LONGEST_AGE,
    DoctorReport,
    check_doctor,
    needed_checks,
    objection,
    read_report,
    this_host,
)
from remosplat_drake.hardware.doctor.drills import needed_drills
from remosplat_drake.hardware.doctor.finding import (
    ADVICE,
    FAILED,
    PASSED,
    SKIPPED,
    Finding,
)
from remosplat_drake.hardware.hardware_config import HardwareConfig
from remosplat_drake.hardware.wire.multicast import Packet

CONFIG = HardwareConfig(lcm_url="udpm://239.255.76.67:7667?ttl=0")
URL = CONFIG.url

TRACKING = """Reference ID    : C0A80001 (clock)
Stratum         : 3
System time     : 0.000213 seconds slow of NTP time
Leap status     : Normal
"""


def test_chronys_words_are_understood():
    assert host_checks.clock_offset(TRACKING) == -0.000213
    alone = TRACKING.replace("Normal", "Not synchronised")
    assert host_checks.clock_offset(alone) is None
    assert host_checks.clock_offset("506 Cannot talk to daemon") is None


def test_a_clock_is_looked_at_without_chrony_too(monkeypatch):
    monkeypatch.setattr(host_checks.shutil, "which", lambda _: None)
    for follows, result in ((True, PASSED), (False, ADVICE)):
        monkeypatch.setattr(
            host_checks, "kernel_clock_follows", lambda says=follows: says
        )
        assert host_checks.check_clock().result == result
    monkeypatch.undo()
    assert host_checks.kernel_clock_follows() in (True, False)


def test_an_image_wants_a_larger_buffer_than_a_status():
    small = host_checks.check_buffers(has_camera=False)
    large = host_checks.check_buffers(has_camera=True)
    assert int(small.wanted.split()[0]) < int(large.wanted.split()[0])
    assert small.found == large.found


def test_senders_are_told_apart_by_their_addresses():
    url, heard = free_url(), []
    senders = [DrakeLcm(url), DrakeLcm(url)]
    end = time.monotonic() + PATIENCE
    stop = threading.Event()

    def send():
        while not stop.wait(0.01):
            for sender in senders:
                sender.Publish("PROBE", b"x" * 10)

    thread = threading.Thread(target=send)
    thread.start()
    while len({each.sender for each in heard}) < 2:
        assert time.monotonic() < end
        heard += wire_checks.hear_wire(url, 0.05)
    stop.set()
    thread.join()
    assert {(h.channel, h.data) for h in heard} == {("PROBE", b"x" * 10)}


def test_an_own_packet_comes_back():
    assert wire_checks.check_loopback(free_url()).result == PASSED


def packet(channel: str, port: int, data: bytes = b"", at: float = 0.0):
    return Packet(channel, data, f"192.0.2.7:{port}", at)


def results(findings: list[Finding]) -> dict[str, str]:
    return {finding.check: finding.result for finding in findings}


def test_two_drivers_and_a_second_controller_are_found():
    good = [packet("PANDA_STATUS", 1), packet("BASE_STATUS", 2)]
    assert set(
        results(wire_checks.check_publishers(good, CONFIG, True)).values()
    ) == {PASSED}
    bad = [*good, packet("PANDA_STATUS", 3), packet("PANDA_COMMAND", 4)]
    found = wire_checks.check_publishers(bad, CONFIG, True)
    assert results(found) == {
        "senders of PANDA_STATUS": FAILED,
        "senders of PANDA_COMMAND": FAILED,
        "senders of BASE_STATUS": PASSED,
        "senders of BASE_COMMAND": PASSED,
    }
    assert found[0].found == "192.0.2.7:1, 192.0.2.7:3"


def test_a_driver_elsewhere_wants_packets_that_leave():
    heard = [packet("PANDA_STATUS", 1)]
    near = wire_checks.check_reach(heard, CONFIG)
    far = HardwareConfig(lcm_url=URL.replace("ttl=0", "ttl=1"))
    assert near.result == FAILED
    assert wire_checks.check_reach(heard, far).result == PASSED


def statuses(n: int, age: float, mode: int = 1, joints: int = 7):
    for i in range(n):
        message = lcmt_panda_status()
        message.utime = round(1e6 * (100 + 0.001 * i))
        message.num_joints, message.robot_mode = joints, mode
        for name in message.__slots__:
            if name.startswith("joint_"):
                setattr(message, name, [0.0] * joints)
        at = 100 + 0.001 * i + age
        yield packet("PANDA_STATUS", 1, message.encode(), at)


@pytest.mark.parametrize(
    ("heard", "failed"),
    [
        ([*statuses(1000, 0.001)], set()),
        ([*statuses(50, 0.001)], {"statuses of the arm"}),
        ([*statuses(1000, 0.2)], {"clock of the arm"}),
        ([*statuses(1000, -0.1)], {"clock of the arm"}),
        ([*statuses(1000, 0.001, mode=5)], {"mode of the arm"}),
        ([*statuses(1000, 0.001, joints=6)], {"statuses of the arm"}),
        ([], {"statuses of the arm"}),
    ],
)
def test_statuses_are_judged(heard, failed):
    found = wire_checks.check_statuses(heard, CONFIG, 7, False, duration=1.0)
    assert {f.check for f in found if f.result == FAILED} == failed


def test_a_step_is_evaluated():
    times = np.arange(0, 2.5, 0.02)
    late = np.interp(times, [0.2, 0.4, 1.3, 1.4], [0, 0.1, 0.1, 0])
    response = drills.step_response(times, late)
    assert response.rise == pytest.approx(0.3, abs=0.03)
    assert response.fall == pytest.approx(0.35, abs=0.03)
    assert response.speed == pytest.approx(0.1)
    assert response.rest == 0
    dead = drills.step_response(times, 0 * times)
    assert np.isinf(dead.rise)


def test_thresholds_come_from_the_drivers_command_line(tmp_path):
    assert drills.check_thresholds(tmp_path).result == SKIPPED
    process = tmp_path / "123"
    process.mkdir()
    line = ["/opt/franka_driver_v4", "--control_mode=velocity"]
    (process / "cmdline").write_text("\0".join(line))
    finding = drills.check_thresholds(tmp_path)
    assert finding.result == ADVICE
    assert finding.found == "100 N m, 100 N"
    line += ["--joint_torque_limit=20", "--cartesian_force_limit", "30"]
    (process / "cmdline").write_text("\0".join(line))
    finding = drills.check_thresholds(tmp_path)
    assert (finding.result, finding.found) == (PASSED, "20 N m, 30 N")


def test_axes_that_were_not_measured_are_told(frankie):
    finding = drills.check_actuators(frankie)
    assert (finding.result, finding.found) == (ADVICE, "cautious defaults")
    assert finding.source == "actuators in frankie.yaml"


@pytest.mark.parametrize(
    ("line", "limits"),
    [
        ("python remosplat panda-driver 172.16.0.2", (20, 20)),
        ("remosplat panda-driver a --joint-torque-limit 50", (50, 20)),
        ("remosplat panda-driver a --hand", None),
        ("/usr/bin/vi franka_driver_v4.cc", None),
    ],
)
def test_a_drivers_defaults_are_known(line, limits):
    assert drills.driver_limits(line.split()) == limits


REPORT = DoctorReport(
    this_host(),
    URL,
    1000.0,
    (
        Finding("a", PASSED, "x", "y", "z"),
        Finding("b", ADVICE, "x", "y", "z", "do"),
    ),
)


def test_a_report_is_what_was_saved(tmp_path):
    path = tmp_path / "reports" / "doctor.json"
    REPORT.save(path)
    assert read_report(path) == REPORT
    check_doctor(path, URL, 2000.0, ["a"])


@pytest.mark.parametrize(
    ("host", "url", "now", "problem"),
    [
        (this_host(), URL, 1001.0, ""),
        ("elsewhere", URL, 1001.0, "was made on another computer"),
        (this_host(), URL + "1", 1001.0, "is about another LCM URL"),
        (this_host(), URL, 1001.0 + LONGEST_AGE, "is 12.0 hours old"),
        (this_host(), URL, 500.0, "is -0.1 hours old"),
    ],
)
def test_a_report_holds_for_its_place_and_day(host, url, now, problem):
    said = objection(REPORT, host=host, url=url, now=now, needed=["a"])
    assert said.startswith(problem) and bool(said) == bool(problem)


def test_what_is_needed_must_have_been_looked_at(tmp_path):
    """Advice may be left alone; what was skipped or never done may not."""
    skipped = Finding("c", SKIPPED, "not agreed", "y", "z")
    report = dc.replace(REPORT, findings=(*REPORT.findings, skipped))
    report.save(tmp_path / "doctor.json")
    check_doctor(tmp_path / "doctor.json", URL, 1000.0, ["a"])
    lacking = re.escape("lacks checks: c (not agreed), d (not done);")
    with pytest.raises(RemoSplatError, match=lacking):
        check_doctor(
            tmp_path / "doctor.json", URL, 1000.0, ["a", "b", "c", "d"]
        )


def test_no_needed_check_may_be_skipped():
    """Each of them alone keeps the gate shut."""
    needed = needed_checks(has_base=True)
    assert {"clock", "clock of the arm", "clock of the base"} < set(needed)
    assert set(needed) > set(needed_drills(True))
    assert set(needed_checks(has_base=False)) < set(needed)
    passed = {name: Finding(name, PASSED, "x", "y", "z") for name in needed}
    for name in needed:
        found = passed | {name: Finding(name, SKIPPED, "--skip", "y", "z")}
        report = dc.replace(REPORT, findings=tuple(found.values()))
        assert report.lacking(needed) == [f"{name} (--skip)"]


def test_a_failure_is_named(tmp_path):
    ill = Finding("clock of the arm", FAILED, "90 ms", "20 ms", "s", "m")
    report = DoctorReport(this_host(), URL, 1000.0, (ill,))
    report.save(tmp_path / "doctor.json")
    with pytest.raises(RemoSplatError, match="clock of the arm: 90 ms; want"):
        check_doctor(tmp_path / "doctor.json", URL, 1000.0, [])


def test_no_report_and_another_file_are_told(tmp_path):
    path = tmp_path / "doctor.json"
    with pytest.raises(RemoSplatError, match="no report about the robot"):
        check_doctor(path, URL, 0.0, [])
    path.write_text("{}")
    with pytest.raises(RemoSplatError, match="is not a report"):
        check_doctor(path, URL, 0.0, [])
