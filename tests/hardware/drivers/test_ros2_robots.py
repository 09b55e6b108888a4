"""Whole robots on ROS 2: controller, drivers and robot are processes.

Scenario and drivers are those of the guide: its YAML, and the programs that its
launch files start. The stand-in replaces the robot's own nodes.
"""

import contextlib
import os
import re
import signal
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest
from effort import effort
from model_sources import ridgeback_ur5e, tiago
from patience import PATIENCE
from robot_process import Client, running
from ros2_guide import SECTIONS
from runs import PATIENT

from remosplat_drake.acceptance.consent import Consent
from remosplat_drake.acceptance.hardware_processes import free_url
from remosplat_drake.base.clock import wall_utime
from remosplat_drake.hardware.drivers.ros2_node import Ros2Node
from remosplat_drake.hardware.wire.packets import from_utime

pytest.importorskip("cyclonedds", reason="needs the extra ros2")

from remosplat_drake.hardware.drivers import ros2_messages as ros
from remosplat_drake.hardware.stand_in.ros2_robot import FAULTS_TOPIC

DOMAIN = 87

BUSY = """
hardware: {connect_timeout: 300, base_status_expiry: 0.5, base_latency: 0.5,
  base_delay: 0.5, base_share: 0.5, frozen_after: 1}
supervisor: {max_status_age: 0.5, max_tick_age: 0.5, max_overrun: 0.5,
  follow_dwell: 2, max_tracking_error: 10}
"""
"""A busy computer may be late; only the arm's statuses must not be old."""

TARGETS = {
    "Universal": ([0.5, 0.3, 0.4], [0.5, -0.3, 0.6]),
    "TIAGo": ([0.9, 0.5, 0.9], [1.0, 0.2, 0.95]),
    "Fetch": ([1.15, 0.0, 0.66], [1.0, 0.0, 0.9]),
    "UR5e": ([0.95, 0.6, 0.8], [1.15, 0.0, 0.66]),
}
"""Two targets of each robot, between which it goes to and fro."""

SCENE = """
scene:
  splat: package://remosplat_drake/models/scenes/table/splat.ply
  truth: package://remosplat_drake/models/scenes/table/scene.json
"""
"""A scene whose unseen space is known, as a real robot requires."""

LATE = 0.1
"""How late statuses come [s]."""

STALE = 0.08
"""Age beyond all limits on that of a status, and below that of a late one [s]:
the stand-in makes up for stalls with stamps that are some milliseconds off."""

slow_robots = pytest.mark.parametrize(
    "name", effort(["Fetch", "UR5e"], list(TARGETS))
)


@pytest.fixture(scope="module")
def models(tmp_path_factory) -> Callable[[str], str]:
    """The description of each robot; that of an imported one is made once."""
    made: dict[str, str] = {"Universal": "ur5e", "Fetch": "fetch"}
    imports = {"UR5e": ridgeback_ur5e, "TIAGo": tiago}

    def model(name: str) -> str:
        if name not in made:
            made[name] = str(imports[name](tmp_path_factory.mktemp(name)))
        return made[name]

    return model


def write_lab(folder: Path, name: str, model: str, url: str, laps: int) -> None:
    """Writes a robot's scenario, of which the guide is a part."""
    poses = [
        f"{{translation: {p_W}, rpy_deg: [180, 0, 0]}}" for p_W in TARGETS[name]
    ]
    text = (
        f"{SCENE}robot: {{model: {model}}}\n"
        f"targets: [{', '.join(poses * laps)}]\ntime_limit: 100000\n"
        f"{SECTIONS[name].hardware}  lcm_url: {url}\n"
    )
    indented = re.sub("^(?=.)", "  ", text, flags=re.M)
    (folder / "lab.yaml").write_text(f"Lab:\n{indented}")


@contextlib.contextmanager
def launched(folder: Path, name: str) -> Iterator[None]:
    """The robot of a folder's scenario, and the drivers of its launch file."""
    own = dict(os.environ, ROS_DOMAIN_ID=str(DOMAIN))
    lines = [["hardware-sim", "lab.yaml", "--ros2"]]
    for program, *line in SECTIONS[name].commands:
        assert program == "remosplat"
        lines.append(line)
    with contextlib.ExitStack() as programs:
        for line in lines:
            program = running(*line, environment=own, folder=folder)
            programs.enter_context(program)
        yield


def run_line(url: str, text: str) -> list[str]:
    """The controller's arguments, with overrides of its scenario."""
    return [
        *("run", "lab.yaml", "--hardware", "--without-doctor", "--headless"),
        *("--lcm-url", url, "--scenario-text", text),
    ]


@pytest.mark.slow
@slow_robots
def test_a_robot_reaches_its_targets_through_ros_2(
    name, models, lone_robot, tmp_path
):
    url = free_url()
    write_lab(tmp_path, name, models(name), url, laps=1)
    line = run_line(url, PATIENT)
    with launched(tmp_path, name), running(*line, folder=tmp_path) as run:
        client, operator = Client(url), Consent(url, again=True)
        moved = np.zeros(1)

        def ends() -> bool:
            nonlocal moved
            operator.give()
            if client.arm:
                q = np.array([s.joint_position for s in client.arm])
                moved = np.maximum(np.ptp(q, axis=0), moved)
                del client.arm[1:]
            return run.poll() is not None

        client.wait_for(ends)
        summary, said = run.communicate()
    assert run.returncode == 0, summary + said
    assert "reached all 2" in summary
    assert (moved > 1e-3).all(), moved


@pytest.mark.slow
@slow_robots
def test_statuses_that_come_late_stop_a_robot(
    name, models, lone_robot, tmp_path
):
    """It rests as long as they are late, also if its operator arms it."""
    url = free_url()
    write_lab(tmp_path, name, models(name), url, laps=100)
    line = run_line(url, BUSY)
    fault = Ros2Node(DOMAIN, "a test").writer(FAULTS_TOPIC, ros.String)
    with launched(tmp_path, name), running(*line, folder=tmp_path) as run:
        client, operator = Client(url), Consent(url, again=True)
        client.wait_for(lambda: bool(client.arm))
        ages: list[float] = []

        def go_on(done: Callable[[], bool], request: str = "") -> None:
            """Lets the operator arm the robot until something is so."""
            heard = len(client.arm)

            def asked() -> bool:
                nonlocal heard
                assert run.poll() is None, run.communicate()
                operator.give()
                if request:
                    fault.write(ros.String(request))
                if len(client.arm) > heard:
                    heard = len(client.arm)
                    age = wall_utime() - client.latest.utime
                    ages.append(from_utime(age))
                return done()

            client.wait_for(asked)

        def speed() -> float:
            return float(np.abs(client.latest.joint_velocity).max())

        def is_late() -> bool:
            """Whether the last ten statuses were."""
            return len(ages) > 10 and min(ages[-10:]) > STALE

        go_on(lambda: speed() > 0.05)
        ages.clear()
        go_on(is_late, f"status-delay={LATE}")
        go_on(lambda: speed() < 1e-3)
        ages.clear()
        end = client.time + 1.0
        go_on(lambda: client.time > end or speed() > 1e-3)
        assert speed() < 1e-3
        assert min(ages) > STALE
        go_on(lambda: speed() > 0.05, "recover")
        run.send_signal(signal.SIGINT)
        _, said = run.communicate(timeout=PATIENCE)
    assert run.returncode == 130, said
    late = r"(its stamps jumped by -\d+ ms|stamped \d+ ms ago)"
    assert re.search(f"PANDA_STATUS: {late}", said), said
