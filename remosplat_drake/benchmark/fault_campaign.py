"""The fault campaign: what a robot on a wire does when something goes wrong.

Robot and controller are processes of their own, a wire apart, as they are in
a lab. While the robot moves, one thing goes wrong; then the fault is taken
back, and nothing may move for all that until somebody releases the stop. The
judge is the simulated robot's true motion.
"""

import contextlib
import dataclasses as dc
import json
import math
import signal
import subprocess
import tempfile
import time
from pathlib import Path

from remosplat_drake.benchmark import hardware_processes as processes
from remosplat_drake.benchmark.fault_cases import (
    DRIVER_STOPS,
    GOES_ON,
    STOPS,
    FaultCase,
    Part,
)
from remosplat_drake.benchmark.motion_judge import (
    StopQuality,
    TrueRun,
    judge_stop,
    true_clearance,
)
from remosplat_drake.benchmark.wire_tap import WireTap
from remosplat_drake.drivers import faults
from remosplat_drake.safety.supervision import LATCHED, STOPPED
from remosplat_drake.world import World

_START_UP = 60.0
"""Two processes load, and kernels may have to be compiled [s]."""

_UNDER_WAY = 0.7
"""Something goes wrong so long after the robot has begun to move [s]."""

_STOP_LIMIT = 4.0
"""A stop that takes longer is none [s]."""

_PRESENT = 0.3
"""A fault is taken back so long after the robot stands [s]."""

_ATTEMPTS = 5
"""A run that was disturbed before its fault is repeated."""


@dc.dataclass(frozen=True)
class FaultResult:
    """What came of a fault.

    Attributes:
        case: The fault.
        reason: Why the robot was stopped, as a person reads it.
        time_to_zero: From the fault to a standstill [s]; NaN if there was
            none.
        moved_after: How far any part of the robot moved after that, with
            nobody releasing it [m]; NaN without a standstill.
        clearance: Smallest true distance from the scene of the whole run [m].
        problem: What is not as it should be; empty if all is.
    """

    case: FaultCase
    reason: str
    time_to_zero: float
    moved_after: float
    clearance: float
    problem: str


def run_case(case: FaultCase, world: World) -> FaultResult:
    """Runs robot and controller, lets one thing go wrong, and judges.

    Args:
        case: What goes wrong.
        world: Of the default scenario, with its true geometry.
    """
    problem = ""
    for _ in range(_ATTEMPTS):
        with tempfile.TemporaryDirectory() as folder:
            run = _FaultRun(case, Path(folder))
            problem = run.carry_out()
            if not problem:
                return run.judged(world)
    return FaultResult(case, problem, math.nan, math.nan, math.nan, "not tried")


class _FaultRun:
    """One run of a case; what it leaves lies in a folder."""

    def __init__(self, case: FaultCase, folder: Path):
        self._case = case
        self._log, self._motion = folder / "log.jsonl", folder / "motion.npz"
        self._near = processes.free_url()
        self._networked = case.part is Part.NETWORK
        self._far = processes.free_url() if self._networked else self._near
        self._tap = WireTap(self._far)
        self._began = math.nan

    def carry_out(self) -> str:
        """Runs it; returns what disturbed it before the fault."""
        case, record = self._case, ("--record", str(self._motion))
        arguments = ["--scenario-text", case.text]
        if case.part is Part.CONTROLLER:
            arguments += ["--fault", case.fault]
        with contextlib.ExitStack() as stack:
            network = None
            if self._networked:
                network = stack.enter_context(
                    processes.relay(
                        self._near,
                        self._far,
                        delay=case.delay,
                        loss=case.loss,
                    )
                )
            robot = stack.enter_context(processes.robot(self._far, *record))
            controller = stack.enter_context(
                processes.controller(self._near, self._log, *arguments)
            )
            moving = self._tap.wait(
                lambda: (
                    self._tap.moving_at is not None
                    or controller.poll() is not None
                ),
                _START_UP,
            )
            if not moving or controller.poll() is not None:
                return f"the robot never moved: {self._reason()}"
            self._tap.listen_for(_UNDER_WAY)
            if self._stopped() and case.part is not Part.TARGET:
                return f"the robot was stopped too early: {self._reason()}"
            self._begin(robot, controller, network)
            self._look_on(stack, record, controller)
            processes.end(controller)
        return ""

    def _begin(
        self,
        robot: subprocess.Popen,
        controller: subprocess.Popen,
        network: subprocess.Popen | None,
    ) -> None:
        """Lets the fault happen."""
        case = self._case
        self._began = time.time()
        if case.part is Part.ROBOT:
            self._tap.inject(case.fault, case.value)
        elif case.part is Part.CONTROLLER:
            controller.send_signal(signal.SIGUSR1)
        elif case.part is Part.CONTROLLER_KILLED:
            controller.kill()
        elif case.part is Part.DRIVER_KILLED:
            robot.kill()
            robot.wait()
        elif case.part is Part.INTERRUPT:
            controller.send_signal(signal.SIGINT)
        elif network is not None:
            network.send_signal(signal.SIGUSR1)

    def _look_on(
        self,
        stack: contextlib.ExitStack,
        record: tuple[str, str],
        controller: subprocess.Popen,
    ) -> None:
        """Waits for the stop, takes the fault back, and waits again."""
        case = self._case
        if case.outcome == STOPS:
            self._tap.wait(self._stopped, _STOP_LIMIT)
        elif case.outcome not in (GOES_ON, DRIVER_STOPS):
            self._tap.wait(lambda: controller.poll() is not None, _STOP_LIMIT)
        self._tap.listen_for(_PRESENT)
        if case.part is Part.DRIVER_KILLED:
            stack.enter_context(processes.robot(self._far, *record))
            self._tap.listen_for(_PRESENT)
        elif case.part is Part.ROBOT and case.fault != "base-protective-stop":
            self._tap.inject(faults.RECOVER)
        self._tap.listen_for(case.watch)

    def _events(self) -> list[dict]:
        lines = self._log.read_text().splitlines()
        return [json.loads(line) for line in lines]

    def _stopped(self) -> bool:
        return any(event.get("mode") == STOPPED for event in self._events())

    def _reason(self) -> str:
        reasons = [
            event["reason"]
            for event in self._events()
            if event.get("mode") in LATCHED
        ]
        return reasons[-1] if reasons else ""

    def judged(self, world: World) -> FaultResult:
        """What came of it, judged in a world with its true geometry."""
        assert world.truth_field is not None
        case, reason = self._case, self._reason()
        true_run = TrueRun.read(self._motion)
        if case.part is Part.TARGET:
            self._began = self._first_stop()
        if case.part is Part.DRIVER_KILLED:
            # The record of the killed robot is lost with it: what it was
            # told last tells when it was to stand, and the new one's record
            # whether it moved.
            moved = judge_stop(true_run, -math.inf, world.robot).moved_after
            stop = StopQuality(self._tap.latest - self._began, moved)
        elif case.outcome == GOES_ON:
            stop = StopQuality(math.nan, math.nan)
        else:
            stop = judge_stop(true_run, self._began, world.robot)
        clearance = true_clearance(true_run, world.robot, world.truth_field)
        return FaultResult(
            case,
            reason,
            stop.time_to_zero,
            stop.moved_after,
            clearance,
            self._without_effect() or _problem(case, reason, stop, clearance),
        )

    def _without_effect(self) -> str:
        """Says so if the controller did not notice what it should."""
        status = self._case.tick_status
        statuses = self._events()[-1].get("statuses", {}) if status else {}
        if status and status not in statuses:
            return f"no tick was {status!r}: nothing went wrong"
        return ""

    def _first_stop(self) -> float:
        times = [e["time"] for e in self._events() if e.get("mode") in LATCHED]
        return min(times, default=math.nan)


def _problem(
    case: FaultCase, reason: str, stop: StopQuality, clearance: float
) -> str:
    if not clearance > 0:
        return f"touches the scene by {-1e3 * clearance:.1f} mm"
    if case.outcome == GOES_ON:
        return ""
    if case.outcome == STOPS and not reason:
        return "the supervisor did not stop it"
    if case.reason not in reason:
        return f"the reason does not say {case.reason!r}"
    if not stop.time_to_zero < _STOP_LIMIT:
        return "it did not come to rest"
    if not stop.stays:
        return f"it moved again by {1e3 * stop.moved_after:.1f} mm"
    return ""
