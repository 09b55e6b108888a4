"""`remosplat doctor` with the stand-in robot, as processes of their own."""

import json
import subprocess
import time

import pytest
from drake import lcmt_drake_signal
from patience import PATIENCE
from pydrake.lcm import DrakeLcm
from robot_process import Client, robot_process
from runs import command_line, complaint, remosplat

from remosplat_drake.acceptance.hardware_processes import free_url
from remosplat_drake.hardware.doctor.drills import DRILLS
from remosplat_drake.hardware.stand_in import faults


def inject(lcm: DrakeLcm, name: str) -> None:
    message = lcmt_drake_signal()
    message.dim, message.coord, message.val = 1, [name], [0.0]
    lcm.Publish(faults.CHANNEL, message.encode())


def read(path):
    report = json.loads(path.read_text())
    return {f["check"]: f for f in report["findings"]}


def test_a_silent_wire_fails(tmp_path):
    path, url = tmp_path / "doctor.json", free_url()
    flags = ("--lcm-url", url, "--report", path, "--yes", "--json")
    done = remosplat("doctor", *flags)
    assert done.returncode == 1, done.stderr
    found = read(path)
    assert found["senders of PANDA_STATUS"]["found"] == "none"
    assert found["multicast"]["result"] == "passed"
    assert found["base-step"]["result"] == "skipped"
    assert "remedy: start the driver" in done.stderr
    assert json.loads(done.stdout) == json.loads(path.read_text())


def test_an_unknown_drill_is_told(capsys):
    line = complaint(capsys, "doctor", "--skip", "dance")
    assert "--skip: unknown drill 'dance'" in line


@pytest.mark.slow
def test_all_drills_pass_with_the_stand_in(lone_robot, tmp_path):
    """A person presses each button when told to, and resets it."""
    path, url = tmp_path / "doctor.json", free_url()
    with robot_process(url, "TableReach"):
        Client(url).wait_for_robot()
        line = command_line(
            *("doctor", "TableReach", "--lcm-url", url),
            *("--report", path, "--yes", "--patience", str(PATIENCE)),
        )
        with subprocess.Popen(
            line, stdout=subprocess.PIPE, text=True
        ) as doctor:
            person = DrakeLcm(url)
            assert doctor.stdout is not None
            said = []
            for words in doctor.stdout:
                said.append(words)
                if "press the user stop" in words:
                    inject(person, "user-stop")
                elif "press the emergency stop" in words:
                    inject(person, "base-emergency-stop")
                elif "now reset it" in words:
                    time.sleep(0.5)
                    inject(person, faults.RECOVER)
        found = read(path)
    for drill in DRILLS:
        assert found[drill]["result"] == "passed", "".join(said)
    assert "mode user_stopped" in found["user-stop"]["found"]
    assert found["senders of BASE_STATUS"]["result"] == "passed"


@pytest.mark.slow
def test_a_doctor_that_skips_drills_opens_no_run(lone_robot, tmp_path):
    path, url = tmp_path / "doctor.json", free_url()
    lacking = "base-step (--skip), user-stop (--skip), emergency-stop (--skip)"
    with robot_process(url, "TableReach"):
        Client(url).wait_for_robot()
        flags = ("--lcm-url", url, "--report", path, "--skip", "all")
        done = remosplat("doctor", "TableReach", *flags)
        assert done.returncode == 0, done.stderr
        assert lacking in done.stdout
        flags = ("--lcm-url", url, "--doctor", path, "--headless")
        done = remosplat("run", "TableReach", "--hardware", *flags)
    assert done.returncode == 2
    assert lacking in done.stderr
