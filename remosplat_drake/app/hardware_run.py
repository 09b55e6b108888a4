"""Runs an application on the real robot, in real time."""

import dataclasses as dc
import gc
import importlib
import math
import time
from collections.abc import Callable

import numpy as np
from pydrake.systems.analysis import InitializeParams, Simulator
from pydrake.systems.framework import Context

from remosplat_drake.app.arming import Arming
from remosplat_drake.app.diagram import Application
from remosplat_drake.app.hardware_limits import (
    HARDWARE_SPEED,
    check_for_hardware,
)
from remosplat_drake.app.run_monitor import (
    MapCallback,
    MotionStatusCallback,
    ProgressCallback,
    RunMonitor,
    SupervisionCallback,
)
from remosplat_drake.app.run_result import RunResult, make_result
from remosplat_drake.app.scenario import Scenario
from remosplat_drake.app.scene_config import OBSTACLE
from remosplat_drake.base.clock import next_tick, sleep_until
from remosplat_drake.base.real_time import (
    CONTROLLER_PRIORITY,
    LoopLog,
    LoopQuality,
    garbage_collection_disabled,
    realtime_priority,
)
from remosplat_drake.base.stop_signals import stop_signals
from remosplat_drake.hardware.client.hardware_station import HardwareStation
from remosplat_drake.hardware.client.robot_link import RobotLink
from remosplat_drake.robot.braking import braking_command, periods_between
from remosplat_drake.signals import station_ports as ports
from remosplat_drake.signals.near_movers import mover_at
from remosplat_drake.signals.optional_input import value_or_none

STATUS_TIMEOUT = 0.003
"""A tick waits at most this long for the arm's next status [s]. The arm sends a
status every millisecond."""

_SCIPY = ("linalg", "ndimage", "optimize", "sparse.csgraph", "spatial")
"""Modules that scipy imports at first use. They are imported at the start,
since an import during a tick would delay it."""

REHEARSAL = 0.3
"""Duration of the rehearsal at the start, in which the loop sends no commands
[s]."""

FINAL_ZEROS = 0.1
"""Time for which zero commands are sent at the end of a run [s]."""

PROGRESS_PERIOD = 0.05
"""Time between two calls of `on_progress` [s]."""

_BEFORE_TICK = 1e-4  # Far more than the resolution of epoch times [s].


@dc.dataclass(frozen=True, eq=False)
class HardwareResult:
    """Result of a run on the real robot, and timing of its loop.

    Attributes:
        run: Result of the run.
        loop: Timing of the real-time loop.
    """

    run: RunResult
    loop: LoopQuality


def prepare_for_hardware(
    scenario: Scenario, lcm_url: str | None, *, shadow: bool = False
) -> None:
    """Sets the values of a scenario that a real robot needs.

    Guidance runs its rollouts in a separate process, so that ticks do not wait
    for them. The quadratic program includes the base's speed limits; it
    includes the acceleration limits for every choice of `gains`. Unless the
    scenario sets other values, `HARDWARE_SPEED` bounds speeds, and unseen space
    counts as an obstacle.

    Args:
        scenario: The scenario, which is changed in place.
        lcm_url: LCM URL of the drivers; None means the URL in the scenario.
        shadow: If True, the run sends no commands; this overrides the scenario.

    Raises:
        FieldError: The scenario disables a safety check, such as the supervisor
            or verification; see `check_for_hardware`.
        RemoSplatError: The URL is unusable.
    """
    check_for_hardware(scenario)
    if lcm_url is not None:
        scenario.hardware.use_url(lcm_url)
    scenario.hardware.shadow |= shadow
    scenario.scene.unknown = scenario.scene.unknown or OBSTACLE
    hardware, controller = scenario.hardware, scenario.controller
    controller.guidance.asynchronous = True
    for part in (controller.servo, controller.path_tracking):
        part.max_speed = part.max_speed or HARDWARE_SPEED
    limits = controller.velocity_limits
    limits.acceleration = limits.strict = True
    limits.max_forward = _least(limits.max_forward, hardware.base_forward_upper)
    limits.max_reverse = _least(
        limits.max_reverse, -hardware.base_forward_lower
    )
    limits.max_sideways = _least(limits.max_sideways, hardware.base_sideways)
    limits.max_yaw_rate = _least(limits.max_yaw_rate, hardware.base_yaw_rate)


def _least(given: float | None, bound: float) -> float:
    return bound if given is None else min(given, bound)


def run_on_hardware(
    application: Application,
    *,
    on_progress: ProgressCallback | None = None,
    on_supervision: SupervisionCallback | None = None,
    on_motion_status: MotionStatusCallback | None = None,
    on_map: MapCallback | None = None,
    between_ticks: Callable[[Context], None] | None = None,
    patience: float = 0.0,
) -> HardwareResult:
    """Runs the real robot until the last target is reached or time is up.

    The run waits for the drivers, and rehearses without sending commands. Then
    it requests the drivers' lease, the exclusive right to command the robot.
    The robot does not move until an operator releases it, see `Arming`. A
    shadow run, which sends no commands, does not wait for an operator. Each
    tick waits for a new status of the robot. The loop has a real-time priority
    (SCHED_RR) if the computer grants it, and automatic garbage collection is
    off. At the end, also after Ctrl-C and exceptions, the run brings the robot
    to rest along the braking ramp.

    `warm_up.compile_kernels` must have run before: a tick in which a kernel
    is compiled is so late that the supervisor stops the robot.

    Args:
        application: The diagram; its station must be a `HardwareStation`.
        on_progress: Function that is called every `PROGRESS_PERIOD` with the
            time since the start [s], the robot's state and the latest tick
            report.
        on_supervision: Function that is called with the supervisor's state
            whenever its mode has changed.
        on_motion_status: Function that is called with the time since the start
            [s] and the robot's state whenever the state has changed.
        on_map: Function that is called with the live map's status whenever the
            field `news` of this status changes.
        between_ticks: Function that is called after every tick with the
            diagram's context. It may stop or release the robot.
        patience: Time for which a stopped robot waits until a person releases
            it [s]; then the run ends.

    Raises:
        RemoSplatError: A driver sends no status, or another program has its
            lease.
    """
    loop = HardwareLoop(application)
    loop.rehearse()
    with stop_signals() as request, realtime_priority(CONTROLLER_PRIORITY):
        try:
            with garbage_collection_disabled():
                loop.start()
                arming = Arming(application, loop.link)
                monitor = RunMonitor(
                    application,
                    start=loop.context.get_time(),
                    on_progress=on_progress,
                    on_supervision=on_supervision,
                    on_motion_status=on_motion_status,
                    on_map=on_map,
                    patience=patience,
                    progress_period=PROGRESS_PERIOD,
                )
                while not (monitor.is_finished or request.made):
                    if loop.context.get_time() > monitor.time_limit:
                        break
                    loop.tick()
                    monitor(loop.context)
                    arming(loop.context)
                    if between_ticks is not None:
                        between_ticks(loop.context)
        finally:
            request.has_ended = True
            # If the run has not sent any command, it must not send zero
            # commands either, since another program may drive the robot.
            if math.isfinite(loop.link.sent):
                bring_to_rest(
                    loop.link,
                    application.world.robot.acceleration_limit,
                    application.scenario.control_period,
                )
    result = make_result(
        application, loop.context, request.made, monitor.motion_history
    )
    return HardwareResult(result, loop.log.quality())


class HardwareLoop:
    """Runs the ticks of an application in real time.

    A tick receives the newest statuses, computes the diagram, and sends the
    command at once; drawing and recording follow. A tick that would start too
    late is skipped.

    Attributes:
        context: Context of the whole diagram; its time is the wall clock's.
        link: The link to the robot's drivers.
        log: Times of the ticks, from which the loop's timing is computed.
    """

    def __init__(self, application: Application):
        """Prepares the loop; no command is sent before `tick`.

        Args:
            application: The diagram; its station must be a `HardwareStation`.
        """
        station = application.station
        assert isinstance(station, HardwareStation)
        self._application = application
        self._station = station
        self._period = application.scenario.control_period
        self._status = station.GetOutputPort(ports.STATUS)
        self.link = station.link
        self.link.period = self._period
        self._restart()

    def _restart(self) -> None:
        self._simulator = Simulator(self._application.diagram)
        self.context = self._simulator.get_mutable_context()
        self._station_context = self._station.GetMyContextFromRoot(self.context)
        self.log = LoopLog(self._period)

    def rehearse(self) -> None:
        """Runs some ticks without sending commands, and discards their results.

        Code that imports modules or fills caches at its first use runs here, so
        that it does not delay a later tick. `warm_up.compile_kernels` has
        already compiled the kernels.
        """
        for name in _SCIPY:
            importlib.import_module(f"scipy.{name}")
        log = self._application.log
        if log is not None:
            log.is_paused = True
        self._initialize()
        for _ in range(math.ceil(REHEARSAL / self._period)):
            self._compute()
            self._end_tick()
        self._restart()
        if log is not None:
            log.is_paused = False

    def start(self) -> None:
        """Starts the loop at the next tick; the robot must be at rest.

        If the robot's clearance in the map is too small, the supervisor stops
        it before it moves.

        Raises:
            RemoSplatError: A driver sends no status, or another program has its
                lease.
        """
        self._initialize()
        self.link.is_armed = self._application.scenario.hardware.shadow
        self.link.take_command()
        # The first drawing takes long, so it is done before the loop starts.
        self._application.diagram.ForcedPublish(self.context)
        self.link.wait_for_statuses()
        self._leave_out_late_ticks(time.time())
        self.log = LoopLog(self._period)
        self._check_start()

    def _check_start(self) -> None:
        """Stops the robot if its start is too near to obstacles."""
        app, robot = self._application, self._application.world.robot
        context = app.oracle.GetMyContextFromRoot(self.context)
        clearances = app.oracle.GetOutputPort("clearances").Eval(context)
        assert app.supervisor is not None
        least = app.supervisor.law.min_clearance
        # A clearance of NaN passes this check, but the supervisor stops the
        # robot because of it at the first tick.
        if clearances.minimum() < least:
            row = int(clearances.distance.argmin())
            link = robot.spheres.links[clearances.sphere[row]]
            context = app.supervisor.GetMyMutableContextFromRoot(self.context)
            port = app.supervisor.GetInputPort("movers")
            mover = mover_at(
                value_or_none(port, context),
                self.context.get_time(),
                clearances.p_WC[row],
            )
            where = f"beside {mover} " if mover else "in the map "
            app.supervisor.request_stop(
                context,
                f"{where}{link} starts at a clearance of"
                f" {1e3 * clearances.minimum():.1f} mm, below"
                f" {1e3 * least:.1f} mm",
            )

    def _initialize(self) -> None:
        """Initialises the diagram for the next tick; sends no command."""
        self.link.wait_for_statuses()
        self._next = next_tick(time.time(), self._period, 0)
        self.context.SetTime(self._next * self._period - _BEFORE_TICK)
        self._simulator.Initialize()

    def tick(self) -> None:
        """Waits for the time of the next tick, runs it, and then draws."""
        heard, stamp = self._compute()
        self._station.ForcedPublish(self._station_context)
        self.log.record(
            stamp=stamp,
            heard=heard,
            sent=self.link.sent,
            image=self._station.newest_image(self._station_context),
        )
        self._end_tick()

    def _compute(self) -> tuple[float, float]:
        """Computes a tick from the newest status.

        Returns: The time at which that status was received, and its stamp [s].
        """
        sleep_until(self._next * self._period, self._period)
        if not self.link.flush(min(STATUS_TIMEOUT, self._period)):
            self.log.unheard += 1
        heard = time.time()
        # The time is set after the statuses are received, since a tick must not
        # be earlier than its statuses.
        self._leave_out_late_ticks(heard)
        self._station.receive(self.context)
        self._simulator.AdvanceTo(self._next * self._period)
        status = self._status.Eval(self._station_context)
        self._simulator.AdvancePendingEvents()
        return heard, self.context.get_time() - status.age

    def _end_tick(self) -> None:
        """Draws, records and collects garbage after the command is sent."""
        self._next += 1
        self._simulator.AdvanceTo(self._next * self._period - _BEFORE_TICK)
        gc.collect(1)
        self.link.take_out()

    def _leave_out_late_ticks(self, now: float) -> None:
        due = next_tick(now, self._period, self._next - 1)
        if due > self._next:
            self.log.missed += due - self._next
            self._next = due
            self.context.SetTime(due * self._period - _BEFORE_TICK)
            self._simulator.Initialize(
                InitializeParams(suppress_initialization_events=True)
            )


def bring_to_rest(
    link: RobotLink, acceleration_limit: np.ndarray, period: float
) -> None:
    """Sends commands that decrease to zero along the braking ramp.

    The function uses only the link, since the diagram may have failed. If the
    drivers are already braking along the ramp, it continues their ramp.

    Args:
        link: The link to the robot's drivers.
        acceleration_limit: Bounds on |du/dt|, shape (n_u,).
        period: Time between two commands [s].
    """
    zeros = round(FINAL_ZEROS / period)
    while zeros > 0:
        time.sleep(period)
        elapsed = periods_between(link.sent, time.time(), period) * period
        u = braking_command(link.u, acceleration_limit, elapsed)
        link.send(u)
        zeros -= not u.any()
