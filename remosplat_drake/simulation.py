"""Run an application to its end and say how it ended."""

import dataclasses as dc
from collections.abc import Callable

from pydrake.systems.analysis import ApplySimulatorConfig, Simulator
from pydrake.systems.framework import Context, EventStatus

from remosplat_drake.controller.servo import PoseError
from remosplat_drake.controller.tick_report import TickReport
from remosplat_drake.diagram import Application
from remosplat_drake.recording.metrics import RunMetrics, run_metrics
from remosplat_drake.recording.trajectory import Trajectory
from remosplat_drake.station.config import kinematic_simulator_config

REACHED = "reached"
TIME_LIMIT = "time limit"
INTERRUPTED = "interrupted"


@dc.dataclass(frozen=True, eq=False)
class RunResult:
    """How a run ended.

    Attributes:
        outcome: REACHED, TIME_LIMIT or INTERRUPTED.
        targets_reached: How many of the targets were reached.
        targets: How many there were.
        position_error: Of the end effector at the end [m].
        angle_error: Of the end effector at the end [rad].
        trajectory: What the robot did.
        metrics: Numbers about it.
    """

    outcome: str
    targets_reached: int
    targets: int
    position_error: float
    angle_error: float
    trajectory: Trajectory
    metrics: RunMetrics


ProgressCallback = Callable[[float, PoseError, TickReport | None], None]


def run(
    application: Application,
    *,
    realtime_rate: float = 0.0,
    on_progress: ProgressCallback | None = None,
    until: Callable[[PoseError], bool] | None = None,
) -> RunResult:
    """Simulates until the last target is reached or time is up.

    Args:
        application: The diagram to run.
        realtime_rate: Pace relative to the wall clock; 0 is unlimited.
        on_progress: Called after every step with the time, the pose error
            and the latest tick report.
        until: Ends the run in place of the arrival at the last target; asked
            once a step with the error to the present target.
    """
    scenario, targets = application.scenario, application.targets
    simulator = Simulator(application.diagram)
    ApplySimulatorConfig(
        kinematic_simulator_config(scenario.control_period), simulator
    )
    simulator.set_target_realtime_rate(realtime_rate)

    def monitor(root: Context) -> EventStatus:
        context = targets.GetMyContextFromRoot(root)
        if on_progress is not None:
            on_progress(
                root.get_time(),
                targets.error(context),
                application.recorder.latest,
            )
        finished = (
            targets.progress(context).finished
            if until is None
            else until(targets.error(context))
        )
        if finished:
            return EventStatus.ReachedTermination(None, REACHED)
        return EventStatus.DidNothing()

    simulator.set_monitor(monitor)
    interrupted = False
    try:
        simulator.Initialize()
        simulator.AdvanceTo(scenario.time_limit)
    except KeyboardInterrupt:
        interrupted = True
    return _result(application, simulator.get_context(), interrupted)


def _result(
    application: Application, root: Context, interrupted: bool
) -> RunResult:
    scenario, world = application.scenario, application.world
    targets, recorder = application.targets, application.recorder
    context = targets.GetMyContextFromRoot(root)
    progress, error = targets.progress(context), targets.error(context)
    trajectory = recorder.trajectory(recorder.GetMyContextFromRoot(root))
    if progress.finished:
        outcome = REACHED
    else:
        outcome = INTERRUPTED if interrupted else TIME_LIMIT
    return RunResult(
        outcome=outcome,
        targets_reached=progress.index,
        targets=progress.count,
        position_error=error.distance,
        angle_error=error.angle,
        trajectory=trajectory,
        metrics=run_metrics(
            trajectory,
            world.robot,
            scenario.control_period,
            world.truth_field,
        ),
    )
