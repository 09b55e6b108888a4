"""Whole robots on ROS 2: controller, drivers and robot are processes."""

import contextlib
import os
import re
import signal
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest
from effort import effort
from patience import PATIENCE
from robot_process import Client, running

from remosplat_drake.acceptance.consent import Consent
from remosplat_drake.acceptance.hardware_processes import free_url
from remosplat_drake.base.clock import wall_utime
from remosplat_drake.hardware.drivers.ros2_node import Ros2Node
from remosplat_drake.hardware.wire.packets import from_utime

pytest.importorskip("cyclonedds", reason="needs the extra ros2")

from remosplat_drake.hardware.drivers import ros2_messages as ros
from remosplat_drake.hardware.stand_in.ros2_robot import FAULTS_TOPIC

DOMAIN = 87
ROBOTS = Path(__file__).parents[3] / "apps" / "examples" / "robots.yaml"

BUSY = """
hardware: {connect_timeout: 300, base_status_expiry: 0.5, base_latency: 0.5,
  base_delay: 0.5, base_share: 0.5, frozen_after: 1}
supervisor: {max_status_age: 0.5, max_tick_age: 0.5, max_overrun: 0.5,
  follow_dwell: 2, max_tracking_error: 10}
"""
"""A busy computer may be late; only the arm's statuses must not be old."""

TARGETS = {
    "Ur5e": ([0.5, 0.3, 0.4], [0.5, -0.3, 0.6]),
    "Fetch": ([1.15, 0.0, 0.66], [1.0, 0.0, 0.9]),
    "Ridgeback": ([0.95, 0.6, 0.8], [1.15, 0.0, 0.66]),
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


def scenario_text(name: str) -> str:
    """Overrides of a scenario that does not come to its end."""
    poses = [
        f"{{translation: {p_W}, rpy_deg: [180, 0, 0]}}" for p_W in TARGETS[name]
    ]
    targets = ", ".join(poses * 100)
    return f"{BUSY}\n{SCENE}\ntargets: [{targets}]\ntime_limit: 100000"


@contextlib.contextmanager
def drivers(name: str, url: str) -> Iterator[None]:
    """A robot on ROS 2 and its drivers."""
    own = dict(os.environ, ROS_DOMAIN_ID=str(DOMAIN))
    scenario = f"{ROBOTS}:{name}"
    with contextlib.ExitStack() as programs:
        line = ["hardware-sim", scenario, "--ros2"]
        programs.enter_context(running(*line, environment=own))
        kinds = ["arm-driver", *(["base-driver"] if name != "Ur5e" else [])]
        for kind in kinds:
            line = [kind, scenario, "--lcm-url", url]
            programs.enter_context(running(*line, environment=own))
        yield


@pytest.mark.slow
@pytest.mark.parametrize("name", effort(["Fetch"], list(TARGETS)))
def test_statuses_that_come_late_stop_a_robot(name, lone_robot):
    """It rests as long as they are late, also if its operator arms it."""
    url = free_url()
    line = [
        *("run", f"{ROBOTS}:{name}", "--hardware", "--without-doctor"),
        *("--headless", "--lcm-url", url),
        *("--scenario-text", scenario_text(name)),
    ]
    fault = Ros2Node(DOMAIN, "a test").writer(FAULTS_TOPIC, ros.String)
    with drivers(name, url), running(*line) as run:
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
