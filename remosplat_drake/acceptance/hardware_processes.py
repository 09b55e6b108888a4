"""Runs robot, network and controller as separate processes on one computer."""

import contextlib
import os
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from pydrake.lcm import DrakeLcm

from remosplat_drake.acceptance.network_relay import READY
from remosplat_drake.base.child_process import ONE_THREAD

GROUP = "239.255.76.67"
"""Multicast address that LCM uses by default."""

_COMMAND = """
import signal
import sys
signal.signal(signal.SIGINT, signal.default_int_handler)
from remosplat_drake.commands.main import main
sys.exit(main())
"""
# A shell starts jobs in the background with SIGINT ignored, and their children
# inherit this. Studies end a run by SIGINT.

STAND_IN = (sys.executable, "-c", _COMMAND, "hardware-sim")
"""Command line of the stand-in, without arguments."""

START_UP = 600.0
"""Longest time until processes have started [s]. On a busy computer, they take
minutes if they compile kernels."""

_FIRST = -10
"""Niceness of the processes. They have priority, since computers of real robots
have no other load.
"""

_PATIENCE = 10.0
"""Longest time until a process ends after SIGTERM [s]."""


def free_url() -> str:
    """Returns an unused LCM URL for processes on this computer."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind(("", 0))
        return f"udpm://{GROUP}:{probe.getsockname()[1]}?ttl=0"


def free_port() -> int:
    """Returns an unused UDP port of this computer."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


def wire_works(patience: float = 1.0) -> bool:
    """Returns whether this computer receives its own LCM messages.

    If the computer has no route for multicast, no message arrives.

    Args:
        patience: Longest time to try [s].
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
def robot(
    url: str, *arguments: str, stand_in: Sequence[str] = STAND_IN
) -> Iterator[subprocess.Popen]:
    """Runs a simulated robot at an LCM URL until the context ends.

    Args:
        url: The LCM URL.
        arguments: Further arguments of `hardware-sim`.
        stand_in: Command line of the robot, which takes the same arguments.
    """
    line = [*stand_in, *arguments, "--lcm-url", url]
    with _running(line, subprocess.DEVNULL) as process:
        yield process


@contextlib.contextmanager
def program(
    *line: str, said: Path | None = None, terminal: int | None = None
) -> Iterator[subprocess.Popen]:
    """Runs `remosplat` until the context ends.

    Args:
        line: The command of `remosplat`, and the command's arguments.
        said: File that receives the output; None discards the output.
        terminal: File descriptor of a terminal for the process's input; None if
            there is none.
    """
    whole = [sys.executable, "-c", _COMMAND, *line]
    with (
        Path(os.devnull if said is None else said).open("wb") as file,
        _running(whole, file, file, terminal) as process,
    ):
        yield process


@contextlib.contextmanager
def second_controller(url: str) -> Iterator[subprocess.Popen]:
    """Runs a second `remosplat run --hardware` at the same LCM URL."""
    flags = ["--hardware", "--without-doctor", "--headless", "--lcm-url", url]
    with program("run", "TableReach", *flags) as process:
        yield process


@contextlib.contextmanager
def stranger(url: str, what: str) -> Iterator[subprocess.Popen]:
    """Runs `stranger` at an LCM URL until the context ends.

    Args:
        url: The LCM URL.
        what: A key of `stranger.STRANGERS`.
    """
    line = [sys.executable, "-m", "remosplat_drake.acceptance.stranger"]
    with _running([*line, url, what], subprocess.DEVNULL) as process:
        yield process


@contextlib.contextmanager
def arm_driver(url: str, port: int) -> Iterator[subprocess.Popen]:
    """Runs `remosplat panda-driver` between LCM and the simulated arm.

    Args:
        url: The LCM URL.
        port: The PORT of `hardware-sim --fci PORT`, which must already answer.
    """
    options = ["--simulated", "--lcm-url", url]
    with program("panda-driver", str(port), *options) as process:
        yield process


@contextlib.contextmanager
def ros2_drivers(url: str, text: str) -> Iterator[None]:
    """Runs the drivers of a robot on ROS 2 until the context ends.

    Args:
        url: LCM URL of the controller.
        text: YAML that overrides fields of the default scenario.
    """
    flags = ["TableReach", "--scenario-text", text, "--lcm-url", url]
    with program("arm-driver", *flags), program("base-driver", *flags):
        yield


def callback_of(driver: subprocess.Popen) -> int:
    """Returns the process number of an arm driver's 1 kHz callback.

    The driver's other child process is Python's resource tracker.
    """
    tasks = Path(f"/proc/{driver.pid}/task").glob("*/children")
    children = " ".join(task.read_text() for task in tasks).split()
    (callback,) = (n for n in children if b"resource_tracker" not in _line(n))
    return int(callback)


def _line(process: str) -> bytes:
    return Path(f"/proc/{process}/cmdline").read_bytes()


@contextlib.contextmanager
def relay(
    a: str, b: str, *, delay: float, loss: float
) -> Iterator[subprocess.Popen]:
    """Runs a relay between two LCM URLs; SIGUSR1 starts and ends its faults.

    Args:
        a: LCM URL of the controller.
        b: LCM URL of the robot.
        delay: Delay of every message during the fault [s].
        loss: Fraction of messages that are lost during the fault, in [0, 1].
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
    """Runs `fault_controller` at an LCM URL until the context ends.

    Args:
        url: The LCM URL.
        log: File that receives the process's log.
        arguments: Further arguments of the process.
    """
    line = [sys.executable, "-m", "remosplat_drake.acceptance.fault_controller"]
    with (
        log.open("wb") as file,
        _running([*line, url, *arguments], file) as process,
    ):
        yield process


@contextlib.contextmanager
def _running(
    line: list[str],
    stdout: Any,
    stderr: Any = subprocess.DEVNULL,
    stdin: int | None = None,
) -> Iterator[subprocess.Popen]:
    """Runs a process, with higher priority if permitted; ends it by SIGTERM."""
    with subprocess.Popen(
        line,
        stdin=stdin,
        stdout=stdout,
        stderr=stderr,
        env=os.environ | ONE_THREAD,
    ) as process:
        with contextlib.suppress(PermissionError, ProcessLookupError):
            os.setpriority(os.PRIO_PROCESS, process.pid, _FIRST)
        try:
            yield process
        finally:
            end(process)


def end(process: subprocess.Popen) -> None:
    """Sends SIGTERM to a process, and waits until it has ended."""
    with contextlib.suppress(ProcessLookupError):
        process.send_signal(signal.SIGTERM)
    try:
        process.wait(_PATIENCE)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()
