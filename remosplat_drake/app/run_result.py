"""`RunResult`: the outcome of a run, with its measurements."""

import dataclasses as dc

from pydrake.systems.framework import Context

from remosplat_drake.app.diagram import Application
from remosplat_drake.app.run_readings import selection_of, supervision_of
from remosplat_drake.controller.planning.plan import NO_EFFORT, SearchEffort
from remosplat_drake.motion_status.sentence import at_end
from remosplat_drake.recording.metrics import RunMetrics, run_metrics
from remosplat_drake.recording.trajectory import Trajectory
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.signals.motion_status import MotionStatus
from remosplat_drake.signals.supervisor_state import STOPPED
from remosplat_drake.signals.tick_report import TickReport

REACHED = "reached"
TIME_LIMIT = "time limit"
INTERRUPTED = "interrupted"
GIVEN_UP = "given up"
"""Outcomes of a run that the supervisor has not stopped."""


@dc.dataclass(frozen=True, eq=False)
class RunResult:
    """The outcome of a run, with its trajectory and metrics.

    Attributes:
        outcome: REACHED, TIME_LIMIT, INTERRUPTED, GIVEN_UP or STOPPED. After
            STOPPED, and after GIVEN_UP in a task, a colon and the reason
            follow.
        targets_reached: Number of targets that were reached.
        targets: Number of targets of the run.
        position_error: Distance from the end effector to its target at the end
            of the run [m]. With several end effectors, it is the largest
            distance.
        angle_error: Angle between the orientations of the same end effector and
            its target [rad].
        trajectory: All ticks that the recorder kept.
        metrics: Metrics of the trajectory.
        motion_status: The robot's state at the end of the run.
        motion_history: Changes of the robot's state, each with its time since
            the start [s].
        search_effort: Numbers and durations of the searches for paths.
        effector_errors: Distance [m] and angle [rad] from each end effector to
            its present target, keyed by the end effector's name; empty for a
            single end effector.
    """

    outcome: str
    targets_reached: int
    targets: int
    position_error: float
    angle_error: float
    trajectory: Trajectory
    metrics: RunMetrics
    motion_status: MotionStatus
    motion_history: tuple[tuple[float, MotionStatus], ...] = ()
    search_effort: SearchEffort = NO_EFFORT
    effector_errors: dict[str, tuple[float, float]] = dc.field(
        default_factory=dict
    )

    def uninterrupted(self) -> "RunResult":
        """Returns this result; raises `KeyboardInterrupt` after Ctrl-C.

        Raises:
            KeyboardInterrupt: A person has ended the run.
        """
        if self.outcome == INTERRUPTED:
            raise KeyboardInterrupt
        return self


def make_result(
    application: Application,
    root: Context,
    interrupted: bool,
    motion_history: tuple[tuple[float, MotionStatus], ...] = (),
) -> RunResult:
    """Makes the result of a run from the diagram's context.

    Args:
        application: The diagram that ran, with all of its parts.
        root: Context of the whole diagram at the end.
        interrupted: Whether a person has ended the run.
        motion_history: Changes of the robot's state, from `RunMonitor`.
    """
    scenario, world = application.scenario, application.world
    targets, recorder = application.targets, application.recorder
    robot = world.robot
    context = targets.GetMyContextFromRoot(root)
    progress, error = targets.progress(context), targets.error(context)
    trajectory = recorder.trajectory(recorder.GetMyContextFromRoot(root))
    supervision = supervision_of(application, root)
    if supervision is not None and supervision.is_latched:
        outcome = f"{STOPPED}: {supervision.reason}"
    elif progress.finished:
        outcome = REACHED
    elif progress.failed:
        outcome = f"{GIVEN_UP}: {progress.failed}"
    else:
        outcome = INTERRUPTED if interrupted else TIME_LIMIT
    selection = selection_of(application, root)
    effort = NO_EFFORT if selection is None else selection.effort
    if selection is not None and outcome == TIME_LIMIT:
        planning = scenario.controller.guidance.planning
        if planning.give_up and selection.has_given_up(planning.attempts):
            outcome = GIVEN_UP
    system = application.motion_status
    now = system.now(system.GetMyContextFromRoot(root))
    motion_status = at_end(now, outcome)
    return RunResult(
        outcome=outcome,
        targets_reached=progress.index,
        targets=progress.count,
        position_error=error.distance,
        angle_error=error.angle,
        trajectory=trajectory,
        metrics=run_metrics(
            trajectory,
            robot,
            scenario.control_period,
            world.truth_field,
            world.seen and world.seen.field,
            recorder.ticks.line_deviation,
            recorder.ticks.separation_margin,
        ),
        motion_status=motion_status,
        motion_history=motion_history,
        search_effort=effort,
        effector_errors=_errors_by_name(recorder.latest, trajectory, robot),
    )


def _errors_by_name(
    report: TickReport | None, trajectory: Trajectory, robot: RobotModel
) -> dict[str, tuple[float, float]]:
    if report is None or len(robot.effectors) == 1:
        return {}
    errors = report.aim.errors(robot.end_effector_poses(trajectory.q[-1]))
    return {
        robot.effectors[i]: (error.distance, error.angle)
        for (i, _), error in zip(report.aim.items, errors, strict=True)
    }
