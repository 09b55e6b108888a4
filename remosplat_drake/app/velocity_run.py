"""Moves a real robot's axes with given velocities, for identification.

These runs use the same diagram as all runs, with another control law. The
controller therefore verifies the velocities against the map, self-collision and
joint limits, the supervisor checks them, and the robot's pose is localised.
"""

import copy
import dataclasses as dc
import time
from typing import cast

import numpy as np
from pydrake.systems.framework import Context

from remosplat_drake.app.diagram import Application, build
from remosplat_drake.app.hardware_run import run_on_hardware
from remosplat_drake.app.run_readings import supervision_of
from remosplat_drake.app.run_result import REACHED
from remosplat_drake.app.scenario import LONGEST_RUN, Scenario
from remosplat_drake.app.world import World
from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.controller.ingredients import MoverDamper, VelocityLimits
from remosplat_drake.controller.ingredients.velocity_tracking import (
    VelocityTracking,
)
from remosplat_drake.controller.tick.reactive_law import ReactiveLaw
from remosplat_drake.hardware.client.hardware_station import HardwareStation
from remosplat_drake.hardware.client.measurement import Measurement
from remosplat_drake.robot.actuators import Actuator
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.signals import station_ports as ports
from remosplat_drake.signals.station_status import StationStatus
from remosplat_drake.signals.supervisor_state import RUNNING, STOPPED, UNARMED
from remosplat_drake.task.velocity_profile import ProfileMaker, VelocityProfile

LATEST_BASE = Actuator(delay=0.2, tube=0.25, noise=0.02)
LATEST_ARM = Actuator(delay=0.1, tube=0.15, noise=0.005)
"""Assumed models of axes before identification. Their error bounds cover delays
from zero to 0.45 s (base) or 0.25 s (arm)."""

_FOLLOW_DWELL = 1.0
"""Time for which an axis may deviate from its assumed model before the robot is
stopped [s]. It is long, since the axis' delay is still unknown."""

LONGEST_GAP = 0.05
"""Longest permitted pause between two commands [s]. After a longer pause, a
command may have expired in the drivers."""


class LateError(RemoSplatError):
    """Raised if a command or a status was late; another attempt may succeed."""


class HeldBackError(RemoSplatError):
    """Raised if verification reduced the robot's speed."""


@dc.dataclass(frozen=True, eq=False)
class Played:
    """The recording of one tick of a velocity profile.

    Attributes:
        sent: Time at which the tick's command was sent, by this computer's wall
            clock [s].
        u: The command, shape (n_u,) [m/s, rad/s].
        measurement: The measurement of the tick.
    """

    sent: float
    u: np.ndarray
    measurement: Measurement


def build_velocity_run(
    scenario: Scenario, world: World, *, hardware: bool = True
) -> Application:
    """Builds a scenario's diagram with given velocities in place of targets.

    Args:
        scenario: The scenario, prepared for hardware; it is not changed.
        world: The content of its files. `LATEST_BASE` and `LATEST_ARM` replace
            the models of the robot's axes.
        hardware: Whether the station is the real robot.

    Raises:
        RemoSplatError: The station cannot be made.
    """
    scenario, robot = copy.deepcopy(scenario), world.robot
    controller = scenario.controller
    controller.guidance.enabled = controller.rest.enabled = False
    scenario.targets = ProfileMaker()
    scenario.time_limit = LONGEST_RUN
    scenario.supervisor.follow_dwell = _FOLLOW_DWELL
    if hardware:
        robot.description.actuators = latest_axes(robot)
    law = ReactiveLaw(
        robot,
        [
            VelocityTracking(),
            VelocityLimits(controller.velocity_limits),
            MoverDamper(controller.movers),
        ],
        scenario.control_period,
        solver=controller.solver,
        verify=controller.verify,
        collision=controller.collision,
        self_collision=controller.self_collision,
    )
    return build(scenario, world, hardware=hardware, law=law)


def latest_axes(robot: RobotModel) -> list[Actuator]:
    """Returns the assumed models of a robot's axes before identification.

    Args:
        robot: The robot.
    """
    n_arm = robot.n_u - robot.n_base
    return [LATEST_BASE] * robot.n_base + [LATEST_ARM] * n_arm


def play(application: Application, u: np.ndarray) -> list[Played]:
    """Moves the real robot along a velocity profile that a person has approved.

    The supervisor is released once, as soon as the robot may move. A stop ends
    the run. At the end, the robot is brought to rest in any case.

    Args:
        application: The result of `build_velocity_run`.
        u: Velocities, one row per period, shape (k, n_u) [m/s, rad/s].

    Returns:
        All ticks.

    Raises:
        LateError: The robot stopped after a command or a status was late.
        HeldBackError: Verification reduced the profile's velocities.
        RemoSplatError: The robot is not allowed to move, or was stopped.
        KeyboardInterrupt: The run was interrupted.
    """
    player = _Player(application, u)
    done = run_on_hardware(application, between_ticks=player)
    outcome = done.run.uninterrupted().outcome
    if outcome == REACHED:
        return player.ticks
    raise (LateError if player.was_late() else RemoSplatError)(outcome)


class _Player:
    """Releases the robot, plays the profile, and keeps the recording.

    Attributes:
        ticks: The ticks so far.
    """

    def __init__(self, application: Application, u: np.ndarray):
        station, profile = application.station, application.targets
        assert isinstance(station, HardwareStation)
        assert isinstance(profile, VelocityProfile)
        self._application, self._u = application, u
        self._station, self._profile = station, profile
        self._hardware = application.scenario.hardware
        self._deadline = time.monotonic() + self._hardware.connect_timeout
        self._is_playing = False
        self._is_late = False
        self.ticks: list[Played] = []

    def __call__(self, root: Context) -> None:
        """Starts and records the profile, or requests a release."""
        state = supervision_of(self._application, root)
        assert state is not None
        if state.mode == RUNNING and not self._is_playing:
            self._is_playing = True
            context = self._profile.GetMyMutableContextFromRoot(root)
            self._profile.play(context, self._u)
        elif self._is_playing:
            self._keep(root)
        elif state.mode == STOPPED and state.reason == UNARMED:
            self._release(root, state.refusal)

    def _release(self, root: Context, refusal: str) -> None:
        """Requests the release again, since a localisation needs some time."""
        if time.monotonic() > self._deadline:
            raise RemoSplatError(refusal or UNARMED)
        supervisor = self._application.supervisor
        assert supervisor is not None
        context = supervisor.GetMyMutableContextFromRoot(root)
        supervisor.request_release(context)

    def _keep(self, root: Context) -> None:
        link = self._station.link
        measurement = self._station.measurement(root)
        self.ticks.append(Played(link.sent, link.u, measurement))
        context = self._station.GetMyContextFromRoot(root)
        port = self._station.GetOutputPort(ports.STATUS)
        status = cast(StationStatus, port.Eval(context))
        self._is_late |= (
            status.age > self._hardware.arm_status_limit
            or status.base_age >= self._hardware.base_status_expiry
        )
        report = self._application.recorder.latest
        if report is not None and report.scale < 1.0:
            raise HeldBackError("verification reduced the speed of the motion")

    def was_late(self) -> bool:
        """Returns whether statuses or commands were late."""
        gaps = np.diff([*(tick.sent for tick in self.ticks), time.time()])
        return self._is_late or bool((gaps[:-1] > LONGEST_GAP).any())
