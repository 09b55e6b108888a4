"""Judges a run of the benchmark: arrival, collisions, contacts with movers."""

import dataclasses as dc
from collections.abc import Sequence

import numpy as np

from remosplat_drake.app.scenario import CAMERAS, Scenario
from remosplat_drake.app.world import World
from remosplat_drake.benchmark import metrics as met
from remosplat_drake.benchmark.reaching_task import ReachingTask
from remosplat_drake.benchmark.result import (
    COLLISION,
    INFEASIBLE,
    LOCAL_MINIMUM,
    SUCCESS,
    TIMEOUT,
    Judgement,
    MovingResult,
)
from remosplat_drake.benchmark.watched_run import WatchedRun
from remosplat_drake.detection.simulated.camera_detection import placed_cameras
from remosplat_drake.recording.metrics import path_length
from remosplat_drake.recording.mover_contacts import KINDS, judge_movers
from remosplat_drake.recording.trajectory import Trajectory
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.scene.mover import Movers
from remosplat_drake.scene.moving.track import Track, movers_at
from remosplat_drake.signals.distance_field import DistanceField
from remosplat_drake.signals.tick_report import BRAKING, RELAXED
from remosplat_drake.task.arrival import ArrivalConfig

CHECKS_A_TICK = 5
"""Number of collision checks per tick: at the tick, and at four points between
this tick and the next tick."""

STALL_WINDOW, STALL_REACH = 1.0, 0.01
"""Duration of the last part of a run [s], and length of the path in this part
[m] below which the robot counts as at rest."""


def arrival_rule(scenario: Scenario, rule: str) -> ArrivalConfig:
    """Returns a scenario's arrival tolerances with another success rule.

    Args:
        scenario: The scenario.
        rule: One of `RULES`.
    """
    return dc.replace(scenario.arrival, rule=rule)


class RunJudge:
    """Judges one finished run by several success rules.

    Args:
        robot: The robot.
        scenario: Scenario with the control period and the arrival tolerances.
        trajectory: The robot's motion in the run.
        task: The target, and the true scene.
    """

    def __init__(
        self,
        robot: RobotModel,
        scenario: Scenario,
        trajectory: Trajectory,
        task: ReachingTask,
    ):
        self._robot, self._scenario = robot, scenario
        self._trajectory = trajectory
        self._errors = met.target_errors(robot, trajectory.q, task.X_WTs)
        field = task.with_grasped(task.truth_field, robot)
        self._at = met.minimum_clearances(robot, trajectory.q, field)
        self._between = self._clearances_between(field)

    def _clearances_between(self, field: DistanceField) -> np.ndarray:
        q = met.between_ticks(self._trajectory.q, CHECKS_A_TICK)
        flat = q.reshape(-1, self._robot.n_q)
        clearances = met.minimum_clearances(self._robot, flat, field)
        return clearances.reshape(q.shape[:2]).min(axis=1, initial=np.inf)

    def judgement(self, rule: str) -> Judgement:
        """Judges the part of the run up to the arrival by a rule.

        Args:
            rule: One of `RULES`.
        """
        scenario, trajectory = self._scenario, self._trajectory
        dt = scenario.control_period
        arrival = met.arrival_tick(self._errors, arrival_rule(scenario, rule))
        end = len(trajectory) if arrival is None else arrival
        q, u = trajectory.q[: end + 1], trajectory.u[:end]
        p_WE = met.end_effector_positions(self._robot, q)
        minimum = min(
            self._at[: end + 1].min(), self._between[:end].min(initial=np.inf)
        )
        if minimum <= 0.0:
            outcome = COLLISION
        elif arrival is not None:
            outcome = SUCCESS
        else:
            outcome = self._failure()
        return Judgement(
            outcome=outcome,
            duration=end * dt,
            average_distance=float(self._at[: end + 1].mean()),
            minimum_distance=float(minimum),
            gracefulness=met.mean_acceleration(self._robot, q, u, dt),
            acceleration=met.resampled_acceleration(p_WE, dt),
            path_length=path_length(p_WE),
            base_path_length=(
                path_length(q[:, :2]) if self._robot.n_base else 0.0
            ),
            jerk=met.jerk_share(self._robot, u, dt),
            torque=met.torque_share(self._robot, q, u, dt),
        )

    def _failure(self) -> str:
        """Returns the outcome of a collision-free run that did not arrive."""
        trajectory = self._trajectory
        if len(trajectory) and trajectory.status[-1] in (RELAXED, BRAKING):
            return INFEASIBLE
        stalled = met.is_stalled(
            self._robot,
            trajectory.q,
            self._scenario.control_period,
            STALL_WINDOW,
            STALL_REACH,
        )
        return LOCAL_MINIMUM if stalled else TIMEOUT


def judge_contacts(
    scenario: Scenario,
    world: World,
    trajectory: Trajectory,
    tracks: Sequence[Track],
    seed: int,
) -> MovingResult:
    """Evaluates a run with movers.

    Args:
        scenario: Scenario, which defines the robot's perception of movers.
        world: The robot and the true scene.
        trajectory: The robot's motion.
        tracks: Motions of the movers over time.
        seed: Seed of the cameras' noise.
    """
    robot, dt = world.robot, scenario.control_period

    def movers(time: float) -> Movers:
        return movers_at(tracks, time)

    judged = judge_movers(robot, trajectory.time, trajectory.q, movers, dt)
    if scenario.movers_from == CAMERAS:
        judged = WatchedRun(
            robot,
            trajectory,
            movers,
            placed_cameras(scenario.cameras, robot, world.truth, seed),
            scenario.detection.least_points,
            scenario.controller.movers.separation,
            dt,
        ).judged(judged)
    return MovingResult(
        len(movers(0.0)),
        {kind: judged.count(kind) for kind in KINDS},
        float(judged.distance.min()),
        judged.waited,
    )
