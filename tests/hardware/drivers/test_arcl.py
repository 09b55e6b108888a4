"""ARCL: lines by hand, and a server of the protocol in another process."""

import contextlib
import socket
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest
from patience import wait_for

from remosplat_drake.base.errors import FieldError
from remosplat_drake.hardware.drivers.arcl_monitor import (
    PORT,
    ArclMonitor,
    split_address,
)
from remosplat_drake.hardware.drivers.arcl_text import ArclState, with_line
from remosplat_drake.hardware.drivers.base_stops import BaseStops

SERVER = Path(__file__).with_name("arcl_server.py")


@pytest.mark.parametrize(
    ("line", "stops"),
    [
        ("Motors enabled", BaseStops()),
        ("Motors disabled", BaseStops(motors_off=True)),
        ("EStop pressed", BaseStops(emergency=True)),
        (
            "EStop relieved but motors still disabled",
            BaseStops(emergency=True),
        ),
        ("  estop PRESSED \r", BaseStops(emergency=True)),
    ],
)
def test_what_the_robot_says_of_its_motors(line, stops):
    state = with_line(ArclState(), line, 7.0)
    assert (state.stops, state.heard) == (stops, 7.0)


@pytest.mark.parametrize(
    "line",
    ["", "Status: Going to goal", "Unknown command foo", "\x00\xff", "Motors"],
)
def test_other_lines_say_nothing(line):
    state = with_line(ArclState(), "EStop pressed", 7.0)
    assert with_line(state, line, 8.0) == state


def test_the_state_of_charge_is_kept():
    state = with_line(ArclState(), "StateOfCharge: 86.0", 7.0)
    assert with_line(state, "Motors enabled", 8.0).stops.battery == 0.86
    state = with_line(state, "StateOfCharge: full", 9.0)
    assert state.stops.battery == -1.0


def test_an_old_answer_is_none():
    state = with_line(ArclState(), "Motors enabled", 7.0)
    assert not state.stops_at(7.5, 0.5).is_unknown
    assert state.stops_at(7.6, 0.5).is_unknown
    assert ArclState().stops_at(0.0, 0.5).is_unknown


def test_addresses():
    assert split_address("10.0.0.5") == ("10.0.0.5", PORT)
    assert split_address("ld60:7272") == ("ld60", 7272)
    for text in ("ld60:", ":7171", "ld60:99999", "ld60:x"):
        with pytest.raises(FieldError, match="HOST:PORT"):
            split_address(text)


class Server:
    """A stand-in of the robot."""

    def __init__(self, process: subprocess.Popen[str], port: int):
        self.port = port
        self._process = process

    def say(self, answer: str) -> None:
        """Sets what it answers from now on."""
        assert self._process.stdin
        print(answer, file=self._process.stdin, flush=True)


@contextlib.contextmanager
def serving(port: int) -> Iterator[Server]:
    with subprocess.Popen(
        [sys.executable, str(SERVER), str(port), "secret"],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    ) as process:
        assert process.stdout and process.stdout.readline() == "ready\n"
        try:
            yield Server(process, port)
        finally:
            process.kill()


def free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


@contextlib.contextmanager
def monitoring(port: int, password: str = "secret") -> Iterator[tuple]:
    said: list[str] = []
    monitor = ArclMonitor("127.0.0.1", port, password, said.append)
    try:
        yield monitor, said
    finally:
        monitor.close()


def test_a_robot_is_asked_again_and_again():
    with serving(free_port()) as server, monitoring(server.port) as (m, _):

        def stops() -> BaseStops:
            return m.stops(time.monotonic())

        wait_for(lambda: stops() == BaseStops(battery=0.86))
        server.say("EStop pressed")
        wait_for(lambda: stops().emergency)
        server.say("EStop relieved but motors still disabled")
        wait_for(lambda: stops().emergency)
        server.say("Motors disabled")
        wait_for(lambda: stops().motors_off)
        server.say("Motors enabled")
        wait_for(lambda: stops() == BaseStops(battery=0.86))
        # A query without an answer leaves it unknown, and so does garbage.
        for trouble in ("mute", "garbage"):
            server.say(trouble)
            wait_for(lambda: stops().is_unknown)
            server.say("Motors enabled")
            wait_for(lambda: not stops().is_unknown)


def test_it_connects_anew():
    port = free_port()
    with monitoring(port) as (monitor, said):

        def is_unknown() -> bool:
            return monitor.stops(time.monotonic()).is_unknown

        wait_for(lambda: bool(said))
        assert "refused" in said[0]
        with serving(port) as server:
            wait_for(lambda: not is_unknown())
            server.say("hang up")
            wait_for(is_unknown)
            wait_for(lambda: not is_unknown())
        wait_for(is_unknown)
        assert any("closed the connection" in text for text in said)


def test_a_wrong_password_is_told():
    with (
        serving(free_port()) as server,
        monitoring(server.port, "wrong") as (monitor, said),
    ):
        wait_for(lambda: bool(said))
        assert "no welcome after the password" in said[0]
        assert monitor.stops(time.monotonic()).is_unknown
