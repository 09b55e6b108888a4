"""ROS 1: the bridge beside a real master and a real node of rospy."""

import contextlib
import os
import socket
import subprocess
import sys
import threading
from collections.abc import Iterator
from pathlib import Path

import pytest
from patience import PATIENCE
from robot_process import running
from ros1_packages import Unavailable, unpacked
from ros_robot import (
    SENSES,
    Station,
    bridge_to,
    check_bridge,
    check_senses,
)
from runs import assert_one_line, remosplat

from remosplat_drake.acceptance.hardware_processes import free_url

BASE = Path(__file__).with_name("ros1_base.py")
SENSING_BASE = Path(__file__).with_name("ros1_sensing_base.py")


@pytest.fixture(scope="module")
def packages(request) -> Path:
    """Debian's ROS 1 on disk; kept from one run of the tests to the next."""
    try:
        return unpacked(request.config.cache.mkdir("ros1"))
    except Unavailable as reason:
        pytest.skip(f"needs ROS 1 from Debian's packages: {reason}")


@pytest.fixture
def environment(packages, tmp_path) -> dict[str, str]:
    """Of processes that share a ROS master of their own."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    return {
        **os.environ,
        "PYTHONPATH": str(packages),
        "ROS_MASTER_URI": f"http://127.0.0.1:{port}",
        "ROS_IP": "127.0.0.1",
        "ROS_HOME": str(tmp_path),
    }


@contextlib.contextmanager
def process(
    command: list[str], environment: dict[str, str]
) -> Iterator[subprocess.Popen[str]]:
    with subprocess.Popen(
        command,
        env=environment,
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    ) as child:
        try:
            yield child
        finally:
            child.terminate()


@contextlib.contextmanager
def master(environment: dict[str, str]) -> Iterator[None]:
    """The heart of roscore, ready."""
    port = environment["ROS_MASTER_URI"].rpartition(":")[2]
    program = (
        "import sys, rosmaster; sys.argv = ['rosmaster'];"
        f"rosmaster.rosmaster_main(['--core', '-p', '{port}'])"
    )
    with process([sys.executable, "-c", program], environment) as child:
        probe = (
            "import rosgraph, sys; sys.exit(not rosgraph.is_master_online())"
        )
        for _ in range(50):
            assert child.poll() is None, child.communicate()[1]
            answer = subprocess.run(
                [sys.executable, "-c", probe], env=environment
            )
            if answer.returncode == 0:
                break
        yield


@pytest.mark.slow
def test_a_base_is_driven_through_the_bridge(environment):
    url = free_url()
    commands: list[tuple[float, float]] = []
    with (
        master(environment),
        process([sys.executable, str(BASE)], environment) as base,
        running(*bridge_to("Ros1Base", url), environment=environment) as bridge,
    ):

        def listen() -> None:
            assert base.stdout
            for line in base.stdout:
                forward, yaw_rate = map(float, line.split())
                commands.append((forward, yaw_rate))

        listener = threading.Thread(target=listen)
        listener.start()
        check_bridge(bridge, Station(url), commands, lambda x, forward: None)
        bridge.terminate()
        assert bridge.wait(PATIENCE) == 0
        base.terminate()
        listener.join()
    assert set(commands) == {(0.0, 0.0)}


@pytest.mark.slow
def test_stops_and_localisations_go_through_the_bridge(environment):
    url = free_url()
    with (
        master(environment),
        process([sys.executable, str(SENSING_BASE)], environment) as base,
        running(
            *bridge_to("Ros1Base", url, SENSES),
            environment=environment,
        ) as bridge,
    ):
        said: bool | None = None

        def tell(pressed: bool | None) -> None:
            nonlocal said
            if pressed is not said:
                assert base.stdin
                print("pressed" if pressed else "free", file=base.stdin)
                base.stdin.flush()
                said = pressed

        check_senses(bridge, url, tell)
        bridge.terminate()
        assert bridge.wait(PATIENCE) == 0


@pytest.mark.slow
def test_without_a_master_one_line_says_so(environment, monkeypatch):
    for name in ("PYTHONPATH", "ROS_MASTER_URI"):
        monkeypatch.setenv(name, environment[name])
    result = remosplat(*bridge_to("Ros1Base", free_url()))
    assert_one_line(result, "no ROS master", environment["ROS_MASTER_URI"])
