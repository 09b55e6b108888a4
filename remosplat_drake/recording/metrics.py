"""Metrics of a run, such as smallest clearance and path length."""

import dataclasses as dc
from collections.abc import Sequence

import numpy as np

from remosplat_drake.recording.mover_contacts import (
    Contact,
    MoverJudgement,
    judge_movers,
)
from remosplat_drake.recording.trajectory import Trajectory
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.scene.mover import Movers
from remosplat_drake.signals.distance_field import DistanceField


@dc.dataclass(frozen=True)
class RunMetrics:
    """The metrics of a run.

    Attributes:
        duration: Simulated time from the first tick to the end [s].
        clearance_min: Smallest clearance in the run by the distance oracle [m];
            None if the scene was never within the influence distance.
        clearance_mean: Mean over the ticks of the smallest clearance by the
            distance oracle [m]; None if `clearance_min` is None.
        truth_clearance_min: Smallest clearance in the run by ground truth [m];
            None if the ground truth is unknown.
        truth_clearance_mean: Mean over the ticks of the smallest clearance by
            ground truth [m] (paper section V, D_avg); None if the ground truth
            is unknown.
        path_length: Length of the path of the first or only end effector [m]
            (paper section V, L).
        base_path_length: Length of the path of the base's origin [m].
        ticks: Number of control ticks.
        tick_p50: Median wall-clock time of a tick [s].
        tick_p99: 99th percentile of the wall-clock time of a tick [s].
        control_rate: 1 / tick_p50 [Hz]; 0 if ticks were not timed.
        statuses: Number of ticks, keyed by the name of their status.
        scaled_ticks: Number of ticks whose command verification reduced.
        effector_paths: Lengths of the paths of several end effectors, keyed by
            name [m]; empty if there is only one end effector.
        line_deviation_max: Largest deviation of the end effector from the
            straight lines of targets [m]; None if no target has a line.
        line_deviation_mean: Mean deviation of the end effector from the
            straight lines of targets, over the ticks with such a line [m]; None
            if there are none.
        unseen_clearance_min: Smallest distance of the robot to space that no
            camera has seen [m], negative inside this space; None if the seen
            space is unknown.
        unseen_ticks: Number of ticks at which a part of the robot was in unseen
            space.
        mover_distance_min: Smallest true distance to a mover (moving object)
            [m]; None without movers.
        mover_contacts: All contacts with movers (moving objects), each with its
            cause.
        waited: Total time in which no part of the robot moved [s]; None if
            there are no movers.
        separation_margin_min: Smallest value over all ticks of the distance to
            known movers minus the protective separation distance S_p [m]; None
            if there are no movers.
    """

    duration: float
    clearance_min: float | None
    clearance_mean: float | None
    truth_clearance_min: float | None
    truth_clearance_mean: float | None
    path_length: float
    base_path_length: float
    ticks: int
    tick_p50: float
    tick_p99: float
    control_rate: float
    statuses: dict[str, int]
    scaled_ticks: int
    effector_paths: dict[str, float] = dc.field(default_factory=dict)
    line_deviation_max: float | None = None
    line_deviation_mean: float | None = None
    unseen_clearance_min: float | None = None
    unseen_ticks: int = 0
    mover_distance_min: float | None = None
    mover_contacts: tuple[Contact, ...] = ()
    waited: float | None = None
    separation_margin_min: float | None = None


def run_metrics(
    trajectory: Trajectory,
    robot: RobotModel,
    dt: float,
    truth: DistanceField | None,
    unseen: DistanceField | None = None,
    line_deviation: Sequence[float] | np.ndarray = (),
    separation_margin: Sequence[float] | np.ndarray = (),
) -> RunMetrics:
    """Computes the metrics of a finished run.

    Args:
        trajectory: The robot's motion.
        robot: The robot, for its kinematics and its spheres.
        dt: Control period [s].
        truth: The true scene; None if it is unknown.
        unseen: Space that no camera has seen; None if it is unknown.
        line_deviation: Deviation of the end effector from the line at each tick
            [m]; NaN without a line.
        separation_margin: Distance to known movers minus S_p at each tick [m];
            NaN without known movers.
    """
    margins = np.array(separation_margin)
    margins = margins[~np.isnan(margins)]
    p_WE = np.array([robot.end_effector_poses(q) for q in trajectory.q])
    lengths = [path_length(p_WE[:, i, :3, 3]) for i in range(p_WE.shape[1])]
    several = dict(zip(robot.effectors, lengths, strict=True))
    true_min, true_mean = _summary(clearances_to(truth, trajectory, robot))
    to_unseen = clearances_to(unseen, trajectory, robot)
    oracle_min, oracle_mean = _summary(trajectory.clearance)
    beside = np.array(line_deviation)
    beside = beside[np.isfinite(beside)]
    moving = _judged(trajectory, robot, dt)
    p50, p99 = _percentiles(trajectory.timings.get("total"))
    return RunMetrics(
        duration=len(trajectory) * dt,
        clearance_min=oracle_min,
        clearance_mean=oracle_mean,
        truth_clearance_min=true_min,
        truth_clearance_mean=true_mean,
        path_length=lengths[0],
        base_path_length=(
            path_length(trajectory.q[:, :2]) if robot.n_base else 0.0
        ),
        ticks=len(trajectory),
        tick_p50=p50,
        tick_p99=p99,
        control_rate=1.0 / p50 if p50 > 0 else 0.0,
        statuses=status_counts(trajectory),
        scaled_ticks=int((trajectory.scale < 1.0).sum()),
        effector_paths=several if len(several) > 1 else {},
        line_deviation_max=float(beside.max()) if len(beside) else None,
        line_deviation_mean=float(beside.mean()) if len(beside) else None,
        unseen_clearance_min=_summary(to_unseen)[0],
        unseen_ticks=int((to_unseen < 0).sum()),
        mover_distance_min=_summary(moving.distance)[0] if moving else None,
        mover_contacts=moving.contacts if moving else (),
        waited=moving.waited if moving else None,
        separation_margin_min=float(margins.min()) if len(margins) else None,
    )


def _judged(
    trajectory: Trajectory, robot: RobotModel, dt: float
) -> MoverJudgement | None:
    """Finds the contacts with the movers of a run; None without movers.

    Between two ticks, movers are assumed to keep the velocity that they have at
    the earlier tick.
    """
    if not trajectory.movers or not len(trajectory):
        return None

    def at(time: float) -> Movers:
        k = int(np.searchsorted(trajectory.time, time + 1e-9, "right")) - 1
        return trajectory.movers[max(k, 0)].predicted(time)

    return judge_movers(robot, trajectory.time, trajectory.q, at, dt)


def status_counts(trajectory: Trajectory) -> dict[str, int]:
    """Counts the ticks of each status."""
    names, counts = np.unique(trajectory.status, return_counts=True)
    return {str(n): int(c) for n, c in zip(names, counts, strict=True)}


def clearances_to(
    field: DistanceField | None, trajectory: Trajectory, robot: RobotModel
) -> np.ndarray:
    """Computes each configuration's smallest clearance from a field.

    Returns:
        The clearances, shape (T + 1,) [m]; shape (0,) if there is no field.
    """
    if field is None:
        return np.zeros(0)
    return np.array(
        [field.clearances(robot.spheres_at(q)).minimum() for q in trajectory.q]
    )


def path_length(p: np.ndarray) -> float:
    """Returns the length of a polyline [m] of points, shape (T, d) [m]."""
    return float(np.linalg.norm(np.diff(p, axis=0), axis=1).sum())


def _summary(clearance: np.ndarray) -> tuple[float | None, float | None]:
    finite = clearance[np.isfinite(clearance)]
    if not len(finite):
        return None, None
    return float(finite.min()), float(finite.mean())


def _percentiles(seconds: np.ndarray | None) -> tuple[float, float]:
    if seconds is None or not len(seconds):
        return 0.0, 0.0
    p50, p99 = np.percentile(seconds, [50, 99])
    return float(p50), float(p99)
