"""A scenario on the robot, which is a process of its own behind the wire.

The machine that runs this may be busy, so the thresholds of time are wide:
what a late tick does is the supervisor's business and tested there.
"""

import signal
import subprocess
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np
import pytest
from drake import lcmt_panda_command
from pydrake.lcm import DrakeLcm
from robot_process import Client, free_url, robot_process
from runs import assert_one_line, command_line, remosplat

from remosplat_drake.diagram import MakeDiagram
from remosplat_drake.drivers.inbox import Inbox
from remosplat_drake.hardware_run import (
    HardwareLoop,
    bring_to_rest,
    run_on_hardware,
)
from remosplat_drake.messages import channels
from remosplat_drake.messages.base_command import base_command
from remosplat_drake.safety.braking import braking_steps
from remosplat_drake.scenario import LoadScenario
from remosplat_drake.simulation import REACHED
from remosplat_drake.station.hardware.config import HardwareConfig
from remosplat_drake.station.hardware.robot_link import RobotLink
from remosplat_drake.world import load_world

STILL = 1e-3  # [rad/s]

PATIENT = """{
  time_limit: 60,
  hardware: {
    connect_timeout: 60, arm_status_expiry: 2, base_status_expiry: 2,
    frozen_after: 2},
  supervisor: {
    max_status_age: 2, max_tick_age: 2, max_overrun: 2, follow_dwell: 5},
}"""


def make_application(url: str):
    scenario = LoadScenario("TableReach", PATIENT)
    scenario.hardware.lcm_url = url
    return MakeDiagram(scenario, load_world(scenario), hardware=True)


@pytest.fixture
def robot() -> Iterator[tuple[str, Client]]:
    """The wire to a robot at the start of the scenario, and a listener."""
    url = free_url()
    with robot_process(url, "TableReach"):
        client = Client(url)
        client.wait_for_robot()
        yield url, client


def moves(client: Client) -> bool:
    return bool(np.abs(client.latest.joint_velocity).max() > 0.05)


def assert_stays_still(client: Client) -> None:
    """From now on, with nobody who commands it."""
    client.listen_for(0.2)
    q = np.array(client.latest.joint_position)
    pose = np.array(client.latest_base.pose)
    client.listen_for(0.3)
    assert np.abs(client.latest.joint_velocity).max() < STILL
    np.testing.assert_allclose(client.latest.joint_position, q, atol=1e-4)
    np.testing.assert_allclose(client.latest_base.pose, pose, atol=1e-4)


@contextmanager
def commands_heard(url: str) -> Iterator[list[np.ndarray]]:
    """Everything that is commanded in the meantime, each of shape (9,)."""
    inbox = Inbox(
        DrakeLcm(url), [channels.PANDA_COMMAND, channels.BASE_COMMAND]
    )
    heard: list[np.ndarray] = []
    done = threading.Event()

    def listen():
        arm = np.zeros(7)
        while not done.is_set():
            for channel, data in inbox.fetch(0.001):
                if channel == channels.PANDA_COMMAND:
                    arm = lcmt_panda_command.decode(data).joint_velocity
                else:
                    base = base_command.decode(data)
                    heard.append(np.array([base.forward, base.yaw_rate, *arm]))

    thread = threading.Thread(target=listen)
    thread.start()
    try:
        yield heard
    finally:
        time.sleep(0.05)
        done.set()
        thread.join()


def test_coming_to_rest_is_a_straight_ramp_and_zeros(frankie):
    url, period = free_url(), 0.02
    link = RobotLink(HardwareConfig(lcm_url=url), frankie)
    u = np.array([0.2, -0.3, 0.5, 0, 0, 0, 0, 0, -1.0])
    limit = frankie.acceleration_limit
    with commands_heard(url) as heard:
        link.send(u)
        bring_to_rest(link, limit, period)
    ramp = np.array(heard)
    np.testing.assert_allclose(ramp[0], u)
    moving = ramp[np.abs(ramp).max(axis=1) > 1e-12]
    assert len(moving) == pytest.approx(braking_steps(u, limit, period))
    np.testing.assert_allclose(
        moving, np.outer(moving[:, 0] / u[0], u), atol=1e-12
    )
    assert (np.abs(np.diff(ramp, axis=0)) <= limit * period + 1e-9).all()
    assert not ramp[-4:].any()
    assert not link.u.any()


def test_a_rehearsal_sends_nothing(robot):
    url, _ = robot
    with commands_heard(url) as heard:
        loop = HardwareLoop(make_application(url))
        loop.rehearse()
        assert not heard
        loop.start()
    assert heard
    assert not np.any(heard)


def test_the_table_scenario_reaches_its_target_through_the_wire(robot):
    url, client = robot
    done = run_on_hardware(make_application(url))
    assert done.run.outcome == REACHED
    assert done.run.metrics.truth_clearance_min > 0
    assert done.loop.ticks == len(done.run.trajectory)
    assert_stays_still(client)


def test_an_exception_leaves_the_robot_at_rest(robot):
    url, client = robot
    application = make_application(url)

    def explode(t, error, report):
        if np.abs(application.station.link.u).max() > 0.2:
            raise ZeroDivisionError

    with commands_heard(url) as heard, pytest.raises(ZeroDivisionError):
        run_on_hardware(application, on_progress=explode)
    fastest = max(np.abs(u).max() for u in heard)
    assert fastest > 0.2
    assert not heard[-1].any()
    assert_stays_still(client)


def test_ctrl_c_leaves_the_robot_at_rest(robot):
    url, client = robot
    with subprocess.Popen(
        command_line(
            *("run", "TableReach", "--hardware", "--headless"),
            *("--lcm-url", url, "--scenario-text", PATIENT),
        ),
        stderr=subprocess.PIPE,
        text=True,
    ) as process:
        try:
            client.wait_for(lambda: moves(client), limit=60.0)
            with commands_heard(url) as heard:
                process.send_signal(signal.SIGINT)
                _, errors = process.communicate(timeout=60)
        finally:
            process.kill()
    assert process.returncode == 130, errors
    assert "interrupted" in errors
    assert np.abs(heard[0]).max() > 0
    assert not heard[-1].any()
    assert_stays_still(client)


def test_a_silent_robot_is_named():
    url = free_url()
    result = remosplat(
        *("run", "--hardware", "--headless", "--lcm-url", url),
        *("--scenario-text", "{hardware: {connect_timeout: 0.2}}"),
    )
    assert_one_line(result, "PANDA_STATUS", "BASE_STATUS", url, "0.2 s")


@pytest.mark.parametrize(
    ("arguments", "mention"),
    [
        (["--lcm-url", "udpm://239.255.76.67:7667?ttl=0"], "--hardware"),
        (["--hardware", "--lcm-url", "nowhere"], "'nowhere'"),
        (["--hardware", "--realtime-rate", "2"], "--realtime-rate"),
        (
            ["--hardware", "--scenario-text", "{hardware: {frozen_after: 0}}"],
            "hardware.frozen_after",
        ),
        (
            ["--hardware", "--scenario-text", "{supervisor: {enabled: false}}"],
            "supervisor.enabled",
        ),
    ],
)
def test_bad_flags_are_named(arguments, mention):
    assert_one_line(remosplat("run", *arguments), mention)
