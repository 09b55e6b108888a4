"""Measures memory and timing of a run of several hours on the wire.

`remosplat run --hardware` drives the stand-in robot to and fro between two
targets. Now and then the robot is stopped, by a fault with a reset, and armed
again. Memory is sampled during the run. At the end, the loop's periods and all
stops are compared with the expected ones. Pauses of the computer are recorded
beside the stops, since a robot whose computer pauses is stopped for a reason.
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
from contextlib import closing
from pathlib import Path

import numpy as np
from pydrake.lcm import DrakeLcm

from apps.studies.command_line import (
    output_file,
    output_folder,
    study_main,
)
from apps.studies.computer_pauses import ComputerPauses
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
"""The widest thresholds for real robots, so that late ticks do not stop the
robot."""

_SCENARIO = "to_and_fro.yaml"

_LEG = 1.5
"""At least this much time passes between two targets [s]."""

_FAULT, _FAULT_TIME = "user-stop", 1.0
"""Fault that stops the robot periodically, and its duration [s]."""

_SAMPLE = 5.0
"""Time between two samples of the memory [s]."""

_START = 300.0
"""The robot must move within this time [s], in which kernels may be
compiled."""

_END = 600.0
"""The run must write its files within this time [s]."""

_BEFORE = 0.5
"""A pause of the computer may cause a stop within this time [s]."""

_LINES = 12
"""An error contains this many of the last lines that the program printed."""

MINUTE = 60.0


@dc.dataclass(frozen=True)
class LongRun:
    """Measurements of a long run.

    Attributes:
        minutes: Duration of the run [min].
        growth: Growth of the memory of the controller and its processes after
            the first third of the time [MB/h].
        memory: Memory of the controller and its processes, once a minute [MB].
        caused: Number of caused stops.
        stops: Reasons of all stops, in their order.
        pauses: Longest pause of the computer before each of the stops [s]; 0
            for none.
        ticks: Number of control ticks.
        missed: Number of omitted ticks.
        periods_first: Periods of the first tenth of the ticks, median and
            99th percentile [s].
        periods_last: Periods of the last tenth of the ticks, median and 99th
            percentile [s].
        targets: Number of reached targets.
        exit_code: The program's exit code.
    """

    minutes: float
    growth: float
    memory: tuple[float, ...]
    caused: int
    stops: tuple[str, ...]
    pauses: tuple[float, ...]
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
        minutes: Duration [min].
        stop_every: Time between two caused stops [min]; None for no stops.
        folder: Folder that receives the run's files; None keeps none.
        is_busy: Whether this computer has other load, so that late ticks are
            expected.

    Raises:
        RemoSplatError: The run did not begin, or did not end normally.
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
        closing(ComputerPauses()) as computer,
        processes.robot(url),
        processes.program(*command, said=said) as run,
    ):
        watch = _Watch(url, run, said, computer)
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
        pauses=tuple(round(pause, 3) for pause in watch.pauses),
        ticks=metrics["ticks"],
        missed=metrics["loop"]["missed"],
        periods_first=_spread(periods[:few]),
        periods_last=_spread(periods[-few:]),
        targets=metrics["targets_reached"],
        exit_code=code,
    )


def _write_scenario(path: Path, minutes: float, extra: str) -> None:
    """Writes a scenario with more targets than the run can reach."""
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
    """Arms the robot, stops it periodically, and samples the memory.

    Attributes:
        minutes: Times of the memory samples since the beginning of the motion
            [min].
        memory: Memory of the controller and its processes at these times [MB].
        stops: Reasons of all stops so far.
        pauses: Longest pause of the computer before each of these stops [s].
        caused: Number of caused stops among these.
    """

    def __init__(
        self,
        url: str,
        run: subprocess.Popen,
        said: Path,
        computer: ComputerPauses,
    ):
        self._run, self._said, self._tap = run, said, WireTap(url)
        self._computer = computer
        self._consent = Consent(url, again=True)
        self._operator = Operator(DrakeLcm(url))
        self._mode = ""
        self.minutes: list[float] = []
        self.memory: list[MemoryUse] = []
        self.stops: list[str] = []
        self.pauses: list[float] = []
        self.caused = 0

    def until_moving(self) -> None:
        """Arms the robot and waits until it moves."""
        end = time.monotonic() + _START
        while self._tap.moving_at is None:
            if self._run.poll() is not None or time.monotonic() > end:
                raise RemoSplatError(f"the run has not begun: {self._last()}")
            self._listen()

    def go_on(self, minutes: float, stop_every: float | None) -> None:
        """Waits for some time [min] during the run, and causes stops."""
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
        """Returns the last lines of the program's output."""
        return "; ".join(self._said.read_text().splitlines()[-_LINES:])

    def _listen(self) -> None:
        """Records the supervisor's actions, and arms a robot at rest."""
        self._tap.listen_for(0.05)
        for lease in self._operator.leases():
            runs_no_more = lease.mode in (STOPPING, STOPPED) and self._mode in (
                RUNNING,
                STARTING,
            )
            if runs_no_more:
                now = time.monotonic()
                self.stops.append(lease.reason)
                self.pauses.append(self._computer.longest(now - _BEFORE, now))
            self._mode = lease.mode
        self._consent.give()


def _memory_of_all(pid: int) -> MemoryUse:
    """Returns the total memory of a process and its children."""
    tasks = Path(f"/proc/{pid}/task").glob("*/children")
    children = " ".join(task.read_text() for task in tasks).split()
    uses = [memory_of(number) for number in (pid, *children)]
    return MemoryUse(
        sum(use.own for use in uses), sum(use.files for use in uses)
    )


def main(argv: Sequence[str] | None = None) -> int:
    """Runs for the duration of the flags; prints and writes a `LongRun`."""
    return study_main("hours", __doc__, _add_arguments, _study, argv)


def _add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--minutes",
        type=positive,
        default=120.0,
        metavar="MIN",
        help="duration of the run (default: %(default)s)",
    )
    parser.add_argument(
        "--stop-every",
        type=positive,
        metavar="MIN",
        help="time between two caused stops (default: no stops)",
    )
    parser.add_argument(
        "--busy",
        action="store_true",
        help="this computer has other load: late ticks do not stop the robot",
    )
    parser.add_argument(
        "--folder",
        type=output_folder,
        metavar="DIR",
        help="folder that receives the run's own files",
    )
    parser.add_argument(
        "--output",
        type=output_file,
        metavar="FILE",
        help="JSON file for the measurements",
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
