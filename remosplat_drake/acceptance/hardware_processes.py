"""Robot, network and controller as processes of their own, on one computer."""

import contextlib
import os
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

from pydrake.lcm import DrakeLcm

from remosplat_drake.acceptance.network_relay import READY
from remosplat_drake.base.child_process import ONE_THREAD

GROUP = "239.255.76.67"
"""LCM's usual multicast address."""

_COMMAND = """
import sys
from remosplat_drake.commands.main import main
sys.exit(main())
"""

_FIRST = -10
"""Niceness: a robot's computers are not shared with anything else."""

_PATIENCE = 10.0
"""A process gets so long to end by itself [s]."""


def free_url() -> str:
    """A wire within this computer that nobody else uses now."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind(("", 0))
        return f"udpm://{GROUP}:{probe.getsockname()[1]}?ttl=0"


def wire_works(patience: float = 1.0) -> bool:
    """Whether messages get from one end of a wire to another here.

    Without a route for multicast nothing is heard.

    Args:
        patience: How long to try [s].
    """
    url, heard = free_url(), []
    try:
        sender, receiver = DrakeLcm(url), DrakeLcm(url)
    except RuntimeError:
        return False
    receiver.Subscribe("PROBE", heard.append)
    end = time.monotonic() + patience
    while not heard and time.monotonic() < end:
        sender.Publish("PROBE", b"x")
        receiver.HandleSubscriptions(20)
    return bool(heard)


@contextlib.contextmanager
def robot(url: str, *arguments: str) -> Iterator[subprocess.Popen]:
    """`remosplat hardware-sim` on a wire."""
    line = [sys.executable, "-c", _COMMAND, "hardware-sim", "--lcm-url", url]
    with _running([*line, *arguments], subprocess.DEVNULL) as process:
        yield process


@contextlib.contextmanager
def relay(
    a: str, b: str, *, delay: float, loss: float
) -> Iterator[subprocess.Popen]:
    """A network between two wires that SIGUSR1 turns bad, and good again.

    Args:
        a: The controller's wire.
        b: The robot's wire.
        delay: Of every message [s].
        loss: Share of the messages.
    """
    line = [sys.executable, "-m", "remosplat_drake.acceptance.network_relay"]
    numbers = ["--delay", str(delay), "--loss", str(loss)]
    with _running([*line, a, b, *numbers], subprocess.PIPE) as process:
        assert process.stdout
        assert process.stdout.readline() == f"{READY}\n".encode()
        yield process


@contextlib.contextmanager
def controller(
    url: str, log: Path, *arguments: str
) -> Iterator[subprocess.Popen]:
    """A `fault_controller` on a wire, which writes its log to a file."""
    line = [sys.executable, "-m", "remosplat_drake.acceptance.fault_controller"]
    with (
        log.open("wb") as file,
        _running([*line, url, *arguments], file) as process,
    ):
        yield process


@contextlib.contextmanager
def _running(line: list[str], stdout) -> Iterator[subprocess.Popen]:
    """A process that goes first, where that is allowed; ended by SIGTERM."""
    with subprocess.Popen(
        line,
        stdout=stdout,
        stderr=subprocess.DEVNULL,
        env=os.environ | ONE_THREAD,
    ) as process:
        with contextlib.suppress(PermissionError, ProcessLookupError):
            os.setpriority(os.PRIO_PROCESS, process.pid, _FIRST)
        try:
            yield process
        finally:
            end(process)


def end(process: subprocess.Popen) -> None:
    """Asks a process to end and waits until it has."""
    with contextlib.suppress(ProcessLookupError):
        process.send_signal(signal.SIGTERM)
    try:
        process.wait(_PATIENCE)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()
