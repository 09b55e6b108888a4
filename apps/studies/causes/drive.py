"""Runs a situation, and records the states that are displayed."""

import dataclasses as dc
from collections.abc import Callable

import numpy as np
from pydrake.common.value import Value
from pydrake.systems.analysis import ApplySimulatorConfig, Simulator

from remosplat_drake.app.diagram import build
from remosplat_drake.app.run_monitor import RunMonitor
from remosplat_drake.app.run_readings import supervision_of
from remosplat_drake.app.scenario import Scenario
from remosplat_drake.app.simulation import simulator_config
from remosplat_drake.app.world import World
from remosplat_drake.recording.trajectory import Trajectory
from remosplat_drake.robot.pose_error import pose_error
from remosplat_drake.signals import motion_status as states
from remosplat_drake.signals.binding import MOVER
from remosplat_drake.signals.motion_status import MotionStatus
from remosplat_drake.signals.operator_requests import OperatorRequests

_STEP = 0.1
"""Time between two checks of the run [s]."""

_PATIENCE = 8.0
"""Time that a stopped robot waits for its release [s]."""

SLOW, ARM = 0.01, 0.3
"""A hand counts as resting while its pose changes by less than `SLOW` [m];
`ARM` times its angle [rad] is added to its displacement [m]."""


@dc.dataclass(frozen=True, eq=False)
class Drive:
    """A run.

    Attributes:
        motion_history: Changes of the robot's state with their times [s].
        latched_at: Time at which the supervisor stopped it [s]; NaN for never.
        trajectory: All ticks.
        reached: Whether it reached the target.
    """

    motion_history: tuple[tuple[float, MotionStatus], ...]
    latched_at: float
    trajectory: Trajectory
    reached: bool

    @property
    def first(self) -> tuple[float, MotionStatus] | None:
        """The first state that names a cause, with its time; None for none."""
        return first_cause(self.motion_history)


def first_cause(
    motion_history: tuple[tuple[float, MotionStatus], ...],
) -> tuple[float, MotionStatus] | None:
    """Returns the first state that names a cause, with its time.

    Args:
        motion_history: Changes of the state with their times [s].
    """
    named = ((t, s) for t, s in motion_history if s.cause)
    return next(named, None)


def drive(
    scenario: Scenario,
    world: World,
    *,
    press_at: float = np.inf,
    release_at: float = np.inf,
    until: Callable[[float, tuple[tuple[float, MotionStatus], ...]], bool],
) -> Drive:
    """Simulates a run.

    Args:
        scenario: The scenario.
        world: The content of its files.
        press_at: Time at which an operator presses STOP [s].
        release_at: Time at which the operator releases the robot [s].
        until: Function that ends the run, given the time [s] and the changes
            of the state so far.
    """
    application = build(scenario, world)
    simulator = Simulator(application.diagram)
    ApplySimulatorConfig(simulator_config(scenario), simulator)
    root = simulator.get_mutable_context()
    supervisor = application.supervisor
    assert supervisor is not None
    requests = supervisor.GetInputPort("operator").FixValue(
        supervisor.GetMyMutableContextFromRoot(root), Value(OperatorRequests())
    )
    monitor = RunMonitor(application, patience=_PATIENCE)
    simulator.set_monitor(monitor)
    simulator.Initialize()
    latched_at = np.nan
    while not monitor.is_finished and root.get_time() < monitor.time_limit:
        simulator.AdvanceTo(root.get_time() + _STEP)
        time = root.get_time()
        state = supervision_of(application, root)
        if state is not None and state.is_latched and np.isnan(latched_at):
            latched_at = time
        counts = OperatorRequests(
            int(time >= press_at), int(time >= release_at)
        )
        requests.GetMutableData().set_value(counts)
        if until(time, monitor.motion_history):
            break
    targets, recorder = application.targets, application.recorder
    progress = targets.progress(targets.GetMyContextFromRoot(root))
    return Drive(
        monitor.motion_history,
        latched_at,
        recorder.trajectory(recorder.GetMyContextFromRoot(root)),
        progress.finished,
    )


def held_since(
    drive: Drive,
    X_WEs: np.ndarray,
    p_WT: np.ndarray,
    time: float,
    status: MotionStatus,
) -> float:
    """Returns the earliest time at which a cause could be stated [s].

    For a stop, that is the time of the supervisor's stop; for a target out of
    reach, the start of the run; for a mover, the time since when the robot has
    come no nearer to its target. Otherwise it is the time since when the hand
    has not moved by `SLOW`.

    Args:
        drive: The run.
        X_WEs: Pose of the hand at each tick, shape (n, 4, 4).
        p_WT: Position of the target, shape (3,) [m].
        time: Time at which the cause was stated [s].
        status: The state that names it.
    """
    if status.kind in (states.STOPPING, states.STOPPED):
        return drive.latched_at - _STEP
    if status.kind == states.MOVING:
        return 0.0
    times = drive.trajectory.time[: len(X_WEs)]
    p_WE = X_WEs[:, :3, 3]
    at = int(np.searchsorted(times, time)) - 1
    errors = [pose_error(X_WE, X_WEs[at]) for X_WE in X_WEs[: at + 1]]
    moved = np.array([e.distance + ARM * e.angle > SLOW for e in errors])
    if status.cause == MOVER:
        left = np.linalg.norm(p_WE[: at + 1] - p_WT, axis=1)
        moved = left > left.min() + SLOW
        moved[int(left.argmin()) :] = False
    return float(times[: at + 1][moved].max(initial=0.0))
