"""Run an application to its end and say how it ended."""

import dataclasses as dc
import math
from collections.abc import Callable

from pydrake.systems.analysis import (
    ApplySimulatorConfig,
    Simulator,
    SimulatorConfig,
)
from pydrake.systems.framework import Context, EventStatus

from remosplat_drake.app.diagram import Application
from remosplat_drake.app.scenario import Scenario
from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.controller.guidance.selection import Selection
from remosplat_drake.controller.planning.plan import NO_EFFORT, SearchEffort
from remosplat_drake.hardware.client.hardware_station import HardwareStation
from remosplat_drake.recording.metrics import RunMetrics, run_metrics
from remosplat_drake.recording.trajectory import Trajectory
from remosplat_drake.robot.pose_error import PoseError
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.signals.standing import NOT_STARTED, Standing
from remosplat_drake.signals.supervisor_state import (
    STOPPED,
    UNARMED,
    SupervisorState,
)
from remosplat_drake.signals.tick_report import TickReport
from remosplat_drake.standing.sentence import at_end
from remosplat_drake.station.station_config import kinematic_simulator_config

REACHED = "reached"
TIME_LIMIT = "time limit"
INTERRUPTED = "interrupted"
GIVEN_UP = "given up"
"""Outcomes of a run that no supervisor has stopped."""


@dc.dataclass(frozen=True, eq=False)
class RunResult:
    """How a run ended.

    Attributes:
        outcome: REACHED, TIME_LIMIT, INTERRUPTED, GIVEN_UP, or STOPPED and,
            after a colon, why the supervisor stopped the robot.
        targets_reached: Number of targets that were reached.
        targets: Number of targets of the run.
        position_error: Distance from the end effector to the present target at
            the end; of several, of the one that is farthest from its own [m].
        angle_error: Angle from that end effector to that target [rad].
        trajectory: All ticks that the recorder kept.
        metrics: Metrics of the trajectory.
        standing: How things stood at the end, in one sentence.
        standings: All that was news about how things stand, each with its
            time since the start [s].
        search_effort: What the searches of paths have cost.
        effector_errors: By the names of several end effectors, distance [m] and
            angle [rad] of each that has one to its present target; none for an
            only one.
    """

    outcome: str
    targets_reached: int
    targets: int
    position_error: float
    angle_error: float
    trajectory: Trajectory
    metrics: RunMetrics
    standing: Standing
    standings: tuple[tuple[float, Standing], ...] = ()
    search_effort: SearchEffort = NO_EFFORT
    effector_errors: dict[str, tuple[float, float]] = dc.field(
        default_factory=dict
    )


ProgressCallback = Callable[[float, Standing, TickReport | None], None]
"""Function that is told the time [s], how things stand and the last report."""

SupervisionCallback = Callable[[SupervisorState], None]
"""Function that is told what the supervisor is doing."""

StandingCallback = Callable[[float, Standing], None]
"""Function that is told the time [s] and how things stand with the robot."""


def run(
    application: Application,
    *,
    realtime_rate: float | None = None,
    on_progress: ProgressCallback | None = None,
    on_supervision: SupervisionCallback | None = None,
    on_standing: StandingCallback | None = None,
    until: Callable[[PoseError], bool] | None = None,
    patience: float = 0.0,
) -> RunResult:
    """Simulates until the last target is reached or time is up.

    A robot that its supervisor has stopped ends the run, too. The real robot
    runs by its own clock: see `hardware_run.run_on_hardware`.

    Args:
        application: The diagram to run, with all of its parts.
        realtime_rate: Pace relative to the wall clock, 0 is unlimited; None
            takes that of the scenario's `simulator`, unlimited if it has none.
        on_progress: Called after every step with the time [s], how things
            stand and the latest tick report.
        on_supervision: Called with the supervisor's state whenever its mode
            has changed.
        on_standing: Called with the time [s] and how things stand whenever
            that is news.
        until: Function that ends the run in place of the arrival at the last
            target; asked once a step with the error to the present target.
        patience: Time that a stopped robot waits to be released before the
            run ends [s]. The time limit does not count this time.

    Returns:
        How the run ended, with its trajectory and metrics.

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
            f"{scenario.source}: run the real robot with run_on_hardware"
        )
    simulator = Simulator(application.diagram)
    ApplySimulatorConfig(simulator_config(scenario), simulator)
    if realtime_rate is not None:
        simulator.set_target_realtime_rate(realtime_rate)

    monitor = RunMonitor(
        application,
        on_progress=on_progress,
        on_supervision=on_supervision,
        on_standing=on_standing,
        until=until,
        patience=patience,
    )
    simulator.set_monitor(monitor)
    interrupted = False
    try:
        simulator.Initialize()
        end = 0.0
        while not monitor.is_finished and end < monitor.time_limit:
            end = monitor.time_limit
            simulator.AdvanceTo(end)
    except KeyboardInterrupt:
        interrupted = True
    return make_result(
        application, simulator.get_context(), interrupted, monitor.standings
    )


def simulator_config(scenario: Scenario) -> SimulatorConfig:
    """Returns the settings of Drake's simulator for a scenario.

    Args:
        scenario: The scenario; where it has no `simulator`, the settings are
            those with which kinematic stations are exact.
    """
    if scenario.simulator is not None:
        return scenario.simulator
    return kinematic_simulator_config(scenario.control_period)


class RunMonitor:
    """Drake's monitor of a run: looks on after every step and ends the run.

    Attributes:
        is_finished: Whether the run is over.
    """

    def __init__(
        self,
        application: Application,
        *,
        start: float = 0.0,
        on_progress: ProgressCallback | None = None,
        on_supervision: SupervisionCallback | None = None,
        on_standing: StandingCallback | None = None,
        until: Callable[[PoseError], bool] | None = None,
        patience: float = 0.0,
        progress_period: float = 0.0,
    ):
        """Makes the monitor of a run.

        Args:
            application: The diagram that runs, with all of its parts.
            start: Time of the context at which the run starts [s].
            on_progress: Called with the time since the start [s], how things
                stand and the latest tick report.
            on_supervision: Called with the supervisor's state whenever its
                mode has changed, or a release was refused.
            on_standing: Called with the time since the start [s] and how
                things stand whenever that is news.
            until: Function that ends the run in place of the arrival at the
                last target; asked once a step with the error to the present
                target.
            patience: Time that a stopped robot waits to be released before
                the run ends [s].
            progress_period: Least time between two calls of `on_progress`
                [s].
        """
        self._application = application
        self._on_progress = on_progress
        self._on_supervision = on_supervision
        self._on_standing = on_standing
        self._standings: list[tuple[float, Standing]] = []
        self._until = until
        self._patience = patience
        self._progress_period = progress_period
        self._progressed = -math.inf
        self._start = start
        self._time = start
        self._told = "", ""
        self._waited = 0.0
        self._paused = 0.0
        self.is_finished = False

    @property
    def standings(self) -> tuple[tuple[float, Standing], ...]:
        """All news so far of how things stand, each with its time [s]."""
        return tuple(self._standings)

    @property
    def time_limit(self) -> float:
        """Time of the context at which the run is given up [s].

        The time in which the robot stood stopped does not count.
        """
        limit = self._application.scenario.time_limit
        return self._start + limit + self._paused

    def __call__(self, root: Context) -> EventStatus:
        """Looks at the diagram after a step, as Drake's monitor.

        Args:
            root: Context of the whole diagram.

        Returns:
            The status that ends the simulation, once the run is over.
        """
        targets = self._application.targets
        context = targets.GetMyContextFromRoot(root)
        time = root.get_time() - self._start
        is_due = not 0 <= time - self._progressed < self._progress_period
        if self._on_progress is not None and is_due:
            self._progressed = time
            self._on_progress(
                time,
                standing_of(self._application, root),
                self._application.recorder.latest,
            )
        supervision = supervision_of(self._application, root)
        if supervision is not None:
            self._watch(root.get_time(), supervision)
        if supervision is not None and supervision.is_latched:
            stands = supervision.mode == STOPPED
            stands = stands and supervision.reason != UNARMED
            self.is_finished = stands and self._waited >= self._patience
        elif self._until is None:
            self.is_finished = targets.progress(context).finished
        else:
            self.is_finished = self._until(targets.error(context))
        self._listen(time, root)
        self._heed_guidance(root)
        if self.is_finished:
            return EventStatus.ReachedTermination(
                self._application.diagram, "the run is over"
            )
        return EventStatus.DidNothing()

    def _listen(self, time: float, root: Context) -> None:
        """Keeps and tells what is news about how things stand."""
        standing = standing_of(self._application, root)
        known = self._standings
        before = known[-1][1] if known else NOT_STARTED
        if not standing.is_news_after(before):
            return
        known.append((time, standing))
        if self._on_standing is not None:
            self._on_standing(time, standing)

    def _heed_guidance(self, root: Context) -> None:
        """Ends the run where guidance has given up, if that is wanted."""
        selection = selection_of(self._application, root)
        if selection is None:
            return
        planning = self._application.scenario.controller.guidance.planning
        if planning.give_up and selection.has_given_up(planning.attempts):
            self.is_finished = True

    def _watch(self, time: float, supervision: SupervisorState) -> None:
        """Counts how long the robot stands stopped; tells of changes."""
        step, self._time = time - self._time, time
        stands = supervision.mode == STOPPED
        # However long it takes until somebody lets the robot go.
        unarmed = stands and supervision.reason == UNARMED
        waits = stands and not unarmed
        self._waited = self._waited + step if waits else 0.0
        patient = waits and self._patience > 0
        self._paused += step if patient or unarmed else 0.0
        if (supervision.mode, supervision.refusal) != self._told:
            self._told = supervision.mode, supervision.refusal
            if self._on_supervision is not None:
                self._on_supervision(supervision)


def supervision_of(
    application: Application, root: Context
) -> SupervisorState | None:
    """Reads the supervisor's state; None without a supervisor.

    Args:
        application: The diagram that runs, with all of its parts.
        root: Context of the whole diagram.
    """
    supervisor = application.supervisor
    if supervisor is None:
        return None
    return supervisor.supervision(supervisor.GetMyContextFromRoot(root))


def selection_of(application: Application, root: Context) -> Selection | None:
    """Reads what guidance has chosen; None without guidance.

    Args:
        application: The diagram that runs, with all of its parts.
        root: Context of the whole diagram.
    """
    selector = application.selector
    if selector is None:
        return None
    context = selector.GetMyContextFromRoot(root)
    return selector.GetOutputPort("selection").Eval(context)


def standing_of(application: Application, root: Context) -> Standing:
    """Reads how things stood at the latest look.

    Args:
        application: The diagram that runs, with all of its parts.
        root: Context of the whole diagram.
    """
    system = application.standing
    return system.latest(system.GetMyContextFromRoot(root))


def make_result(
    application: Application,
    root: Context,
    interrupted: bool,
    standings: tuple[tuple[float, Standing], ...] = (),
) -> RunResult:
    """Reads off the diagram's context how a run ended.

    Args:
        application: The diagram that ran, with all of its parts.
        root: Context of the whole diagram at the end.
        interrupted: Whether somebody has ended the run.
        standings: What was news about how things stand, as `RunMonitor` has
            kept it.
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
    else:
        outcome = INTERRUPTED if interrupted else TIME_LIMIT
    selection = selection_of(application, root)
    effort = NO_EFFORT if selection is None else selection.effort
    if selection is not None and outcome != REACHED:
        planning = scenario.controller.guidance.planning
        gives_up = planning.give_up and outcome == TIME_LIMIT
        if gives_up and selection.has_given_up(planning.attempts):
            outcome = GIVEN_UP
    system = application.standing
    now = system.now(system.GetMyContextFromRoot(root))
    standing = at_end(now, outcome)
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
            [report.line_deviation for report in recorder.reports],
            [report.separation for report in recorder.reports],
        ),
        standing=standing,
        standings=standings,
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
