"""Hours on end: what a long run on the wire costs, and how it goes on.

`remosplat run --hardware` drives the stand-in robot to and fro between two
targets. Now and then the robot is stopped, by a fault with a reset, and armed
again. Memory is sampled all the while; at the end the loop's periods and all
stops are compared with what was asked for.
"""

import argparse
import dataclasses as dc
import json
import math
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from pydrake.lcm import DrakeLcm

from apps.studies.command_line import study_main
from apps.studies.live_map.memory_use import MemoryUse, memory_of, trend
from remosplat_drake.acceptance import hardware_processes as processes
from remosplat_drake.acceptance.consent import Consent
from remosplat_drake.acceptance.wire_tap import WireTap
from remosplat_drake.app.run_files import METRICS, TRAJECTORY
from remosplat_drake.base.atomic_file import write_atomically
from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.commands.number_flags import positive
from remosplat_drake.hardware.client.operator import Operator
from remosplat_drake.hardware.stand_in.faults import RECOVER
from remosplat_drake.recording.trajectory import load_trajectory
from remosplat_drake.signals.supervisor_state import (
    RUNNING,
    STARTING,
    STOPPED,
    STOPPING,
)

_TO_AND_FRO = (
    "{translation: [0.95, 0.45, 0.95], rpy_deg: [180, 0, 0]}",
    "{translation: [0.9, -0.45, 0.9], rpy_deg: [180, 0, 0]}",
)
"""The two targets, beside the table of TableReach."""

_BUSY = """
  hardware: {arm_status_expiry: 0.5, base_status_expiry: 0.5, base_latency: 0.5,
    base_delay: 0.5, base_share: 0.5, frozen_after: 1}
  supervisor: {max_status_age: 0.5, max_tick_age: 0.5, max_overrun: 0.5,
    follow_dwell: 2, max_tracking_error: 10}
"""
"""Thresholds as wide as a real robot allows: late ticks stop nothing then."""

_SCENARIO = "to_and_fro.yaml"

_LEG = 1.5
"""Time that a leg takes at least [s]."""

_FAULT, _FAULT_TIME = "user-stop", 1.0
"""What stops the robot now and then, and for how long [s]."""

_SAMPLE = 5.0
"""Time between two looks at the memory [s]."""

_START = 300.0
"""Longest time until the robot moves: kernels may have to compile [s]."""

_END = 600.0
"""Longest time for the run to write its files [s]."""

_LINES = 12
"""Number of the program's last lines that an error has."""

MINUTE = 60.0


@dc.dataclass(frozen=True)
class LongRun:
    """What a long run has cost, and how it went.

    Attributes:
        minutes: How long the robot was driven [min].
        growth: By how much the memory of the controller and its processes
            grew, after a third of the time [MB an hour].
        memory: That memory, once a minute [MB].
        caused: How many stops were caused.
        stops: Reasons of all stops, in their order.
        ticks: Number of control ticks.
        missed: Number of ticks that were left out.
        periods_first: Periods of the first tenth of the ticks, median and
            99th percentile [s].
        periods_last: The same of the last tenth.
        targets: How many targets were reached.
        exit_code: The program's exit code.
    """

    minutes: float
    growth: float
    memory: tuple[float, ...]
    caused: int
    stops: tuple[str, ...]
    ticks: int
    missed: int
    periods_first: tuple[float, float]
    periods_last: tuple[float, float]
    targets: int
    exit_code: int


def drive_for(
    minutes: float,
    stop_every: float | None = None,
    folder: Path | None = None,
    *,
    is_busy: bool = False,
) -> LongRun:
    """Drives the stand-in for some time, and measures.

    Args:
        minutes: How long [min].
        stop_every: Time between two stops that are caused [min]; None for
            none.
        folder: Folder that receives the run's files; None keeps none.
        is_busy: Whether this computer has other work, so that late ticks are
            no news.

    Raises:
        RemoSplatError: The run did not begin, or did not end in order.
    """
    with tempfile.TemporaryDirectory() as temporary:
        there = folder or Path(temporary)
        extra = _BUSY if is_busy else ""
        _write_scenario(there / _SCENARIO, minutes, extra)
        return _driven(minutes, stop_every, there)


def _driven(minutes: float, stop_every: float | None, folder: Path) -> LongRun:
    url, said = processes.free_url(), folder / "said.txt"
    command = [
        *("run", str(folder / _SCENARIO), "--hardware", "--without-doctor"),
        *("--headless", "--lcm-url", url, "--output", str(folder)),
    ]
    with (
        processes.robot(url),
        processes.program(*command, said=said) as run,
    ):
        watch = _Watch(url, run, said)
        watch.until_moving()
        watch.go_on(minutes, stop_every)
        run.send_signal(signal.SIGINT)
        code = run.wait(_END)
    if not (folder / METRICS).exists():
        raise RemoSplatError(f"the run wrote no {METRICS}; see {said}")
    metrics = json.loads((folder / METRICS).read_text())
    periods = np.diff(load_trajectory(folder / TRAJECTORY).time)
    few = max(len(periods) // 10, 1)
    memory = trend(watch.minutes, watch.memory)
    return LongRun(
        minutes=watch.minutes[-1],
        growth=MINUTE * memory.own_slope,
        memory=tuple(round(use.own, 1) for use in watch.memory[::12]),
        caused=watch.caused,
        stops=tuple(watch.stops),
        ticks=metrics["ticks"],
        missed=metrics["loop"]["missed"],
        periods_first=_spread(periods[:few]),
        periods_last=_spread(periods[-few:]),
        targets=metrics["targets_reached"],
        exit_code=code,
    )


def _write_scenario(path: Path, minutes: float, extra: str) -> None:
    """Writes a scenario whose targets do not come to an end."""
    legs = math.ceil(minutes * MINUTE / _LEG)
    targets = [f"  - {_TO_AND_FRO[k % 2]}\n" for k in range(legs)]
    path.write_text(
        "ToAndFro:\n"
        "  scene:\n"
        "    splat: package://remosplat_drake/models/scenes/table/splat.ply\n"
        f"  time_limit: {2 * MINUTE * minutes + _START}\n"
        f"  targets:\n{''.join(targets)}{extra}"
    )


def _spread(periods: np.ndarray) -> tuple[float, float]:
    """The median and the 99th percentile [s]."""
    p50, p99 = np.percentile(periods, [50, 99])
    return float(p50), float(p99)


class _Watch:
    """Arms the robot, stops it now and then, and looks at the memory.

    Attributes:
        minutes: When the memory was looked at, since the motion began [min].
        memory: What it was, of the controller and its processes.
        stops: Reasons of all stops so far.
        caused: How many of these were caused.
    """

    def __init__(self, url: str, run: subprocess.Popen, said: Path):
        self._run, self._said, self._tap = run, said, WireTap(url)
        self._consent = Consent(url, again=True)
        self._operator = Operator(DrakeLcm(url))
        self._mode = ""
        self.minutes: list[float] = []
        self.memory: list[MemoryUse] = []
        self.stops: list[str] = []
        self.caused = 0

    def until_moving(self) -> None:
        """Arms the robot and waits until it moves."""
        end = time.monotonic() + _START
        while self._tap.moving_at is None:
            if self._run.poll() is not None or time.monotonic() > end:
                raise RemoSplatError(f"the run has not begun: {self._last()}")
            self._listen()

    def go_on(self, minutes: float, stop_every: float | None) -> None:
        """Lets the run go on for some time, and causes stops [min]."""
        start = time.monotonic()
        due = stop_every or math.inf
        while (now := (time.monotonic() - start) / MINUTE) < minutes:
            if self._run.poll() is not None:
                raise RemoSplatError(
                    f"the run ended by itself after {now:.1f} min:"
                    f" {self._last()}"
                )
            if now >= due:
                due, self.caused = due + (stop_every or 0.0), self.caused + 1
                self._tap.inject(_FAULT)
                self._tap.listen_for(_FAULT_TIME)
                self._tap.inject(RECOVER)
            if now >= _SAMPLE / MINUTE * len(self.memory):
                self.minutes.append(now)
                self.memory.append(_memory_of_all(self._run.pid))
            self._listen()

    def _last(self) -> str:
        """What the program has said last."""
        return "; ".join(self._said.read_text().splitlines()[-_LINES:])

    def _listen(self) -> None:
        """Notes what the supervisor does, and arms the robot once it stands."""
        self._tap.listen_for(0.05)
        for lease in self._operator.leases():
            runs_no_more = lease.mode in (STOPPING, STOPPED) and self._mode in (
                RUNNING,
                STARTING,
            )
            if runs_no_more:
                self.stops.append(lease.reason)
            self._mode = lease.mode
        self._consent.give()


def _memory_of_all(pid: int) -> MemoryUse:
    """What a process and its children have, together."""
    tasks = Path(f"/proc/{pid}/task").glob("*/children")
    children = " ".join(task.read_text() for task in tasks).split()
    uses = [memory_of(number) for number in (pid, *children)]
    return MemoryUse(
        sum(use.own for use in uses), sum(use.files for use in uses)
    )


def main(argv: Sequence[str] | None = None) -> int:
    """Drives for as long as the flags say; prints and writes a LongRun."""
    return study_main("hours", __doc__, _add_arguments, _study, argv)


def _add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--minutes",
        type=positive,
        default=120.0,
        metavar="MIN",
        help="how long to drive (default: %(default)s)",
    )
    parser.add_argument(
        "--stop-every",
        type=positive,
        metavar="MIN",
        help="time between two stops that are caused (default: none)",
    )
    parser.add_argument(
        "--busy",
        action="store_true",
        help="this computer has other work: late ticks stop nothing",
    )
    parser.add_argument(
        "--folder",
        type=Path,
        metavar="DIR",
        help="existing folder that receives the run's own files",
    )
    parser.add_argument(
        "--output",
        type=Path,
        metavar="FILE",
        help="JSON file for what was measured",
    )


def _study(arguments: argparse.Namespace) -> int:
    run = drive_for(
        arguments.minutes,
        arguments.stop_every,
        arguments.folder,
        is_busy=arguments.busy,
    )
    text = json.dumps(dc.asdict(run), indent=2)
    print(text)
    if arguments.output:
        write_atomically(arguments.output, text + "\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
