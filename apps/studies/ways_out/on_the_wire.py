"""Starts with real processes: `run --hardware` and a stand-in robot.

Runs are sequential, since all stand-in robots of a computer use the same LCM
URL.

The stand-in's arm and base have lag, noise and their own rules for commands.
The positions that they measured are evaluated, tick by tick.
"""

import dataclasses as dc
import json
import os
import pty
import re
import signal
import tempfile
import time
from collections.abc import Iterator, Sequence
from itertools import count as count_from
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np

from apps.studies.ways_out.start import (
    Start,
    draw,
    has_unseen_space,
    place_of,
)
from remosplat_drake.acceptance import hardware_processes as processes
from remosplat_drake.acceptance.consent import Consent
from remosplat_drake.acceptance.wire_tap import WireTap
from remosplat_drake.app.run_files import TRAJECTORY
from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.hardware.hardware_config import REHEARSAL_URL
from remosplat_drake.recording.trajectory import load_trajectory
from remosplat_drake.safety.gates import START_BEYOND_LIMITS, START_TOO_NEAR

TIME = 10.0
"""A robot must get out within this time after its first motion [s]."""

ACCURACY = 1e-3
"""Tolerance of stopping distances at the end [m], since a robot does not follow
its commands exactly."""

_ACCEPTED = START_TOO_NEAR, START_BEYOND_LIMITS
"""Gates that are shut for these starts."""

_QUESTION = re.compile(r"type (\S+) to move the robot anyway")
"""Text that requests a person's confirmation of a gate."""

DEEPEST = 0.008
"""Largest violation of a stopping distance at the start [m]: a robot in contact
cannot be armed."""

_START, _END = 120.0, 60.0
"""The robot must move within the first of these times, and the run must write
its files within the second [s]."""

_LATE_HARDWARE = {
    "arm_status_expiry": 0.5,
    "base_status_expiry": 0.5,
    "base_latency": 0.5,
    "base_delay": 0.5,
    "base_share": 0.5,
    "frozen_after": 1.0,
}
_LATE_SUPERVISOR = {
    "max_status_age": 0.5,
    "max_tick_age": 0.5,
    "max_overrun": 0.5,
    "follow_dwell": 2.0,
    "max_tracking_error": 10.0,
}
"""The widest thresholds for real robots, so that a busy computer's late ticks
do not stop the robot."""


@dc.dataclass(frozen=True)
class WireResult:
    """The result of a start on the wire.

    Attributes:
        key: Name of the start.
        depth: Largest measured violation of a stopping distance at the start
            [m].
        out_after: Time from the first motion until every pair was within
            `ACCURACY` of its stopping distance [s]; None if it never was.
        left: Largest violation at the end [m].
        nearer: Largest decrease of a distance, below its initial value and its
            stopping distance, at ticks [m].
        error: Reason why there is no result; empty if there is one.
    """

    key: str
    depth: float = float("nan")
    out_after: float | None = None
    left: float = float("nan")
    nearer: float = float("nan")
    error: str = ""


def starts(robots: Sequence[str], first: int, count: int) -> list[Start]:
    """Chooses starts at which a real robot may be armed.

    Args:
        robots: Names of robots. Those with maps without seen space are left
            out, since a person would have to confirm them.
        first: First seed of the starts.
        count: Number of starts of each robot.
    """
    return [
        start
        for robot in filter(has_unseen_space, robots)
        for start in islice(_gentle(robot, first), count)
    ]


def _gentle(robot: str, first: int) -> Iterator[Start]:
    """Yields starts without contacts, from a seed on."""
    for seed in count_from(first):
        start = Start(robot, seed)
        posture = draw(start)
        if place_of(robot).margins(posture.q, posture.movers).min() > -DEEPEST:
            yield start


def failed(start: Start, error: str) -> WireResult:
    """Makes the result of a start that failed."""
    return WireResult(start.key, error=error)


def restored(fields: dict[str, Any]) -> WireResult:
    """Restores a result from a file's line."""
    return WireResult(**fields)


def drive(start: Start) -> WireResult:
    """Drives the stand-in out of a start.

    Args:
        start: The start, too near to itself or to the scene.

    Raises:
        RemoSplatError: The run did not begin, or wrote no trajectory.
    """
    with tempfile.TemporaryDirectory() as folder:
        scenario = Path(folder) / "start.yaml"
        scenario.write_text(_scenario(start))
        _run(scenario, Path(folder))
        return _judged(start, Path(folder) / TRAJECTORY)


def _scenario(start: Start) -> str:
    """Writes a scenario that begins at a start."""
    place, q = place_of(start.robot), draw(start).q.tolist()
    robot = place.world.robot
    at_start = {"model": start.robot, "arm": q[-len(robot.home) :]}
    if robot.n_base:
        at_start["base_pose"] = q[:3]
    scene = place.scenario.scene
    return json.dumps(
        {
            "Start": {
                "scene": {"splat": scene.splat, "truth": scene.truth},
                "robot": at_start,
                "hardware": _LATE_HARDWARE,
                "supervisor": _LATE_SUPERVISOR,
                "time_limit": 120.0,
            }
        }
    )


def _run(scenario: Path, folder: Path) -> None:
    said = folder / "said.txt"
    accepted = [part for gate in _ACCEPTED for part in ("--accept", gate)]
    command = [
        *("run", str(scenario), "--hardware", "--rehearsal", "--headless"),
        *("--without-doctor", *accepted, "--output", str(folder)),
    ]
    with (
        processes.robot(REHEARSAL_URL, str(scenario)),
        _Person(said) as person,
        processes.program(*command, said=said, terminal=person.terminal) as run,
    ):
        tap = WireTap(REHEARSAL_URL)
        consent = Consent(REHEARSAL_URL, again=True)
        end = time.monotonic() + _START
        while tap.moving_at is None or time.time() < tap.moving_at + TIME:
            if run.poll() is not None:
                break  # It has reached its target.
            if time.monotonic() > end:
                raise RemoSplatError(f"no motion: {_last(said)}")
            tap.listen_for(0.05)
            person.confirm()
            consent.give()
        if run.poll() is None:
            run.send_signal(signal.SIGINT)
        run.wait(_END)
    if not (folder / TRAJECTORY).exists():
        raise RemoSplatError(f"no trajectory: {_last(said)}")


class _Person:
    """Confirms at a terminal that a robot may start too near.

    Attributes:
        terminal: File descriptor of the terminal.
    """

    def __init__(self, said: Path):
        self._said, self._answers = said, 0
        self._keyboard, self.terminal = pty.openpty()

    def __enter__(self) -> "_Person":
        return self

    def __exit__(self, *_) -> None:
        os.close(self._keyboard)
        os.close(self.terminal)

    def confirm(self) -> None:
        """Types the names of gates that the program requests."""
        asked = _QUESTION.findall(self._said.read_text())
        for gate in asked[self._answers :]:
            os.write(self._keyboard, f"{gate}\n".encode())
        self._answers = len(asked)


def _last(said: Path) -> str:
    return "; ".join(said.read_text().splitlines()[-3:])


def _judged(start: Start, path: Path) -> WireResult:
    """Measures the distances along a trajectory."""
    place, trajectory = place_of(start.robot), load_trajectory(path)
    nothing = draw(start).movers
    margins = np.array([place.margins(q, nothing) for q in trajectory.q[:-1]])
    first = int(np.argmax(np.any(trajectory.u != 0.0, axis=1)))
    since = trajectory.time - trajectory.time[first]
    level = np.minimum(margins[0], 0.0)
    out = np.flatnonzero(margins.min(axis=1) >= -ACCURACY)
    in_time = out[since[out] <= TIME] if len(out) else out
    return WireResult(
        start.key,
        depth=float(-margins[0].min()),
        out_after=float(since[in_time[0]]) if len(in_time) else None,
        left=float(max(-margins[-1].min(), 0.0)),
        nearer=float((level - margins).max()),
    )
