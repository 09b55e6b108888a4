"""`FaultRun`: runs a case of the fault campaign, in several processes."""

import contextlib
import json
import math
import os
import random
import signal
import subprocess
import time
from collections.abc import Callable, Sequence
from pathlib import Path

from remosplat_drake.acceptance import hardware_processes as processes
from remosplat_drake.acceptance.company import Company
from remosplat_drake.acceptance.consent import Consent
from remosplat_drake.acceptance.described_robot import write_description
from remosplat_drake.acceptance.fault_case import (
    DRIVER_STOPS,
    GOES_ON,
    JOINING,
    REACHES,
    STOPS,
    FaultCase,
    Part,
)
from remosplat_drake.acceptance.ros2_faults import Ros2Faults
from remosplat_drake.acceptance.wire_tap import WireTap
from remosplat_drake.hardware.stand_in import faults, fci_library
from remosplat_drake.signals.supervisor_state import LATCHED, STOPPED, UNARMED

STOP_LIMIT = 4.0
"""A standstill counts as a stop if it comes within this time after a fault [s].
"""

_REFUSED = 30.0
"""If the first release is refused for this time, the robot will not move [s].
"""

_UNDER_WAY = 0.7
"""Time from the robot's first motion to the fault [s]."""

_SOON = 0.03
"""Time between the first and the second fault of a case [s]."""

_PRESENT = 0.3
"""Time from the standstill to the first release, or to the end of the fault
[s].
"""

_RELEASE_LIMIT = 60.0
"""Longest time from a release to its refusal, or to the arrival at the target
[s].
"""


_ROS2 = """
hardware:
  arm_status_rate: 100
  arm_driver: !Ros2Arm {{domain: {domain}, emergency_stop: /arm/e_stop}}
  base_driver: !Ros2Base {{domain: {domain}, emergency_stop: /base/e_stop}}
"""
"""YAML with the drivers of a robot on ROS 2."""

_DOMAINS = range(100, 200)
"""ROS_DOMAIN_IDs that hardly any other program uses."""


class FaultRun:
    """One run of a case of the campaign, with its files in a folder.

    Attributes:
        motion: Path of the record of the robot's true motion.
        began: Wall-clock time of the fault [s].
        released: Wall-clock time of the first release after the end of the
            fault [s]; infinite if there was none.
        company: Process that joins the network; None if the case has no such
            process.
        commanded: Wall-clock time of the latest motion command before the
            release [s].
    """

    def __init__(
        self,
        case: FaultCase,
        folder: Path,
        stand_in: Sequence[str] = processes.STAND_IN,
    ):
        """Prepares a run.

        Args:
            case: The fault to inject.
            folder: Empty folder for the run's files.
            stand_in: Command line of the simulated robot.
        """
        self._stand_in = stand_in
        self.motion = folder / "motion.npz"
        self.began, self.released = math.nan, math.inf
        self.commanded = math.nan
        self._case = case
        self._log = folder / "log.jsonl"
        self._ros2, ros2 = None, ""
        if case.ros2:
            self._ros2 = Ros2Faults(random.choice(_DOMAINS))
            ros2 = _ROS2.format(domain=self._ros2.domain)
        self._text = case.text + ros2
        if case.actuators:
            described = folder / "robot.yaml"
            write_description(described, "frankie", case.actuators)
            self._text += f"\nrobot: {{model: {described}}}"
        self._robot = ("--record", str(self.motion), *case.robot)
        if case.ros2:
            self._robot += ("--ros2", "--scenario-text", ros2)
        self._near = processes.free_url()
        networked = case.part is Part.NETWORK
        self._far = processes.free_url() if networked else self._near
        self._tap = WireTap(self._far)
        self._consent = Consent(self._near)
        self.company = Company(case, self._near, folder)
        self._fci = processes.free_port()
        self._arm_driver: subprocess.Popen | None = None

    @property
    def events(self) -> list[dict]:
        """Events that the controller's process has logged so far."""
        lines = self._log.read_text().splitlines()
        return [json.loads(line) for line in lines]

    @property
    def reason(self) -> str:
        """Reason of the first stop; empty if the robot was not stopped."""
        reasons = (e["reason"] for e in self.events if _is_latched(e))
        return next(reasons, "")

    @property
    def refusal(self) -> str:
        """Answer to the first release while the fault was present, or ""."""
        answers = [
            event["refusal"]
            for event in self.events
            if "refusal" in event and event["time"] < self.released
        ]
        return answers[0] if answers else ""

    @property
    def first_stop(self) -> float:
        """Wall-clock time at which the supervisor first began a stop [s]."""
        times = [event["time"] for event in self.events if _is_latched(event)]
        return min(times, default=math.nan)

    def carry_out(self) -> str:
        """Runs the case; returns the reason of an early stop, or ""."""
        case = self._case
        arguments = ["--scenario-text", self._text]
        if case.part is Part.CONTROLLER:
            arguments += ["--fault", case.fault]
        with contextlib.ExitStack() as stack:
            network = None
            if case.part is Part.NETWORK:
                network = stack.enter_context(
                    processes.relay(
                        self._near,
                        self._far,
                        delay=case.delay,
                        loss=case.loss,
                    )
                )
            robot = self._start_robot(stack)
            controller = stack.enter_context(
                processes.controller(self._near, self._log, *arguments)
            )
            problem = self._set_out(controller, robot)
            if problem:
                return problem
            self._begin(robot, controller, network)
            if case.part in JOINING:
                self.company.join(stack)
                self.began = self.company.began
                if self.first_stop < self.began:
                    # The controller may have received the message before this
                    # process.
                    if not case.expects(self.reason):
                        return f"the robot was stopped too early: {self.reason}"
                    self.began = self.first_stop
            self._look_on(stack, controller, network)
            processes.end(controller)
        return ""

    def _start_robot(self, stack: contextlib.ExitStack) -> subprocess.Popen:
        """Starts the stand-in, and the driver of its arm if there is one."""
        options = ["--fci", str(self._fci)] if self._case.arm_driver else []
        robot = stack.enter_context(self._robot_process(*options))
        if self._case.ros2:
            drivers = processes.ros2_drivers(self._far, self._text)
            stack.enter_context(drivers)
        if self._case.arm_driver:
            self._wait(self._arm_answers, robot)
            self._start_arm_driver(stack)
        if self._case.ros2 or self._case.arm_driver:
            # The controller does not wait long for statuses.
            self._wait(lambda: self._tap.heard > 0, robot)
        return robot

    def _wait(
        self, happens: Callable[[], bool], *needed: subprocess.Popen
    ) -> None:
        """Waits for an event, or until a process ends that it needs."""
        self._tap.wait(
            lambda: happens() or any(p.poll() is not None for p in needed),
            processes.START_UP,
        )

    def _robot_process(
        self, *options: str
    ) -> contextlib.AbstractContextManager[subprocess.Popen]:
        line = (*self._robot, *options)
        return processes.robot(self._far, *line, stand_in=self._stand_in)

    def _arm_answers(self) -> bool:
        try:
            fci_library.Robot(str(self._fci)).read_once()
        except RuntimeError:
            return False
        return True

    def _start_arm_driver(self, stack: contextlib.ExitStack) -> None:
        self._arm_driver = stack.enter_context(
            processes.arm_driver(self._far, self._fci)
        )

    def _set_out(
        self, controller: subprocess.Popen, robot: subprocess.Popen
    ) -> str:
        """Waits until the robot moves; returns the problem if it does not."""

        def is_under_way() -> bool:
            self._consent.give()
            return self._tap.moving_at is not None or self._is_refused()

        self._wait(is_under_way, controller, robot)
        if self._tap.moving_at is None or controller.poll() is not None:
            refusals = [e["refusal"] for e in self.events if "refusal" in e]
            ends = [
                f"{name} has ended with exit code {process.returncode}"
                for name, process in (
                    ("the simulated robot", robot),
                    ("the controller", controller),
                )
                if process.poll() is not None
            ]
            whys = [self.reason, *refusals[-1:], *ends]
            return f"the robot never moved: {', '.join(filter(None, whys))}"
        self._tap.listen_for(_UNDER_WAY)
        if self._has_stopped() and self._case.part is not Part.TARGET:
            return f"the robot was stopped too early: {self.reason}"
        return ""

    def _begin(
        self,
        robot: subprocess.Popen,
        controller: subprocess.Popen,
        network: subprocess.Popen | None,
    ) -> None:
        """Injects the fault."""
        case = self._case
        self.began = time.time()
        if case.part is Part.ROBOT:
            self._inject(case.fault, case.value)
            if case.then:
                self._tap.listen_for(_SOON)
                self._inject(case.then)
        elif case.part is Part.CONTROLLER:
            controller.send_signal(signal.SIGUSR1)
        elif case.part is Part.CONTROLLER_KILLED:
            controller.kill()
        elif case.part is Part.DRIVER_KILLED:
            robot.kill()
            robot.wait()
        elif self._arm_driver and case.part is Part.ARM_DRIVER_STALLED:
            self._arm_driver.send_signal(signal.SIGSTOP)
        elif self._arm_driver and case.part is Part.ARM_CALLBACK_STALLED:
            os.kill(processes.callback_of(self._arm_driver), signal.SIGSTOP)
        elif case.part is Part.INTERRUPT:
            controller.send_signal(signal.SIGINT)
        elif network is not None:
            network.send_signal(signal.SIGUSR1)

    def _inject(self, fault: str, value: float = 0.0) -> None:
        """Begins a fault of the simulated robot."""
        if self._ros2 is None:
            self._tap.inject(fault, value)
        else:
            self._ros2.inject(fault, value)

    def _look_on(
        self,
        stack: contextlib.ExitStack,
        controller: subprocess.Popen,
        network: subprocess.Popen | None,
    ) -> None:
        """Waits for the stop, tries a release, and removes the fault.

        Then the robot is observed for a while before the final release.
        """
        case = self._case
        if case.outcome == STOPS:
            self._tap.wait(self._has_stopped, STOP_LIMIT)
        elif case.outcome not in (GOES_ON, DRIVER_STOPS):
            self._tap.wait(lambda: controller.poll() is not None, STOP_LIMIT)
        self._tap.listen_for(_PRESENT)
        if case.refusal is not None:
            controller.send_signal(signal.SIGUSR2)
            self._tap.wait(lambda: bool(self.refusal), _RELEASE_LIMIT)
        self._take_back(stack, controller, network)
        self._tap.listen_for(case.watch)
        self.commanded = self._tap.latest
        if case.outcome == STOPS and self._has_stopped():
            self._release(controller)

    def _take_back(
        self,
        stack: contextlib.ExitStack,
        controller: subprocess.Popen,
        network: subprocess.Popen | None,
    ) -> None:
        """Ends the fault, unless it ends by itself."""
        case = self._case
        if case.part is Part.DRIVER_KILLED:
            stack.enter_context(self._robot_process())
            gone = time.time()
            self._wait(lambda: self._tap.heard > gone, controller)
        elif case.part is Part.ROBOT and case.fault != "base-protective-stop":
            self._inject(faults.RECOVER)
        elif case.part in JOINING:
            self.company.leave()
        elif network is not None and case.outcome == STOPS:
            network.send_signal(signal.SIGUSR1)
        elif case.part is Part.CONTROLLER and case.refusal is not None:
            controller.send_signal(signal.SIGUSR1)
        if self._arm_driver is not None:
            self._arm_driver.kill()
            self._arm_driver.wait()
            self._tap.inject(faults.RECOVER)
            self._start_arm_driver(stack)
            gone = time.time()
            self._wait(lambda: self._tap.heard > gone, controller)

    def _release(self, controller: subprocess.Popen) -> None:
        """Releases the stop, and waits until the robot continues."""
        self.released = time.time()
        controller.send_signal(signal.SIGUSR2)
        if self._case.resumes == REACHES:
            self._tap.wait(
                lambda: controller.poll() is not None, _RELEASE_LIMIT
            )
        else:
            self._tap.listen_for(self._case.watch)

    def _is_refused(self) -> bool:
        """Whether the first release has been refused for too long."""
        times = [event["time"] for event in self.events if "refusal" in event]
        return bool(times) and time.time() - min(times) > _REFUSED

    def _has_stopped(self) -> bool:
        return any(
            _is_latched(event) and event["mode"] == STOPPED
            for event in self.events
        )


def _is_latched(event: dict) -> bool:
    """Whether a stop is latched; False before the robot is armed."""
    return event.get("mode") in LATCHED and event["reason"] != UNARMED
