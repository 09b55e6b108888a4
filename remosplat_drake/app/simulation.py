"""`run`: simulates an application to its end."""

import signal
from collections.abc import Callable

from pydrake.systems.analysis import (
    ApplySimulatorConfig,
    Simulator,
    SimulatorConfig,
)
from pydrake.systems.framework import Context, Diagram, EventStatus

from remosplat_drake.app.diagram import Application
from remosplat_drake.app.run_monitor import (
    MapCallback,
    MotionStatusCallback,
    ProgressCallback,
    RunMonitor,
    SupervisionCallback,
)
from remosplat_drake.app.run_result import RunResult, make_result
from remosplat_drake.app.scenario import Scenario
from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.base.stop_signals import stop_signals
from remosplat_drake.hardware.client.hardware_station import HardwareStation
from remosplat_drake.robot.pose_error import PoseError
from remosplat_drake.station.station_config import kinematic_simulator_config


def run(
    application: Application,
    *,
    realtime_rate: float | None = None,
    on_progress: ProgressCallback | None = None,
    on_supervision: SupervisionCallback | None = None,
    on_motion_status: MotionStatusCallback | None = None,
    on_map: MapCallback | None = None,
    until: Callable[[PoseError], bool] | None = None,
    patience: float = 0.0,
) -> RunResult:
    """Simulates until the last target is reached or time is up.

    A stop by the supervisor ends the run, too. Ctrl-C ends it after the present
    step; a second Ctrl-C interrupts that step. For the real robot, see
    `hardware_run.run_on_hardware`.

    Args:
        application: The diagram to run, with all of its parts.
        realtime_rate: Speed relative to the wall clock; 0 is unlimited. None
            means the rate of the scenario's `simulator`, or an unlimited rate
            if the scenario has no `simulator`.
        on_progress: Function that is called after every step with the time [s],
            the robot's state and the latest tick report.
        on_supervision: Function that is called with the supervisor's state
            whenever its mode has changed.
        on_motion_status: Function that is called with the time [s] and the
            robot's state whenever the state has changed.
        on_map: Function that is called with the live map's status whenever the
            field `news` of this status changes.
        until: Function that decides whether the run ends; without it, the run
            ends when the robot arrives at the last target. It is called once
            per step with the error to the present target.
        patience: Time for which a stopped robot waits until a person releases
            it [s]; then the run ends. The time limit does not include this
            time.

    Returns:
        The outcome of the run, with its trajectory and metrics.

    Raises:
        RemoSplatError: The application's station is the real robot.

    Example:
        >>> import remosplat_drake as rs
        >>> scenario = rs.load_scenario("TableGroundTruth")
        >>> rs.run(rs.build(scenario)).outcome
        'reached'
    """
    scenario = application.scenario
    if isinstance(application.station, HardwareStation):
        raise RemoSplatError(
            f"{scenario.source}: this application drives a real robot; use "
            "run_on_hardware"
        )
    simulator = Simulator(application.diagram)
    ApplySimulatorConfig(simulator_config(scenario), simulator)
    if realtime_rate is not None:
        simulator.set_target_realtime_rate(realtime_rate)

    monitor = RunMonitor(
        application,
        on_progress=on_progress,
        on_supervision=on_supervision,
        on_motion_status=on_motion_status,
        on_map=on_map,
        until=until,
        patience=patience,
    )
    interrupted = _advance(simulator, monitor, application.diagram)
    return make_result(
        application,
        simulator.get_context(),
        interrupted,
        monitor.motion_history,
    )


def _advance(
    simulator: Simulator, monitor: RunMonitor, diagram: Diagram
) -> bool:
    """Simulates to the end of the run; returns whether Ctrl-C ended it.

    The end of the run moves during the simulation, since time in which the
    robot is stopped does not count towards the time limit.
    """
    with stop_signals([signal.SIGINT]) as request:

        def watch(root: Context) -> EventStatus:
            status = monitor(root)
            if request.made:
                return EventStatus.ReachedTermination(diagram, "interrupted")
            return status

        simulator.set_monitor(watch)
        end = 0.0
        try:
            simulator.Initialize()
            while not (monitor.is_finished or request.made):
                if end >= monitor.time_limit:
                    break
                end = monitor.time_limit
                simulator.AdvanceTo(end)
        except KeyboardInterrupt:
            return True
        return request.made


def simulator_config(scenario: Scenario) -> SimulatorConfig:
    """Returns the settings of Drake's simulator for a scenario.

    Args:
        scenario: The scenario. If it has no `simulator`, the result has fixed
            time steps, with which a kinematic station is exact.
    """
    if scenario.simulator is not None:
        return scenario.simulator
    return kinematic_simulator_config(scenario.control_period)
