"""Runs one trial: a method in a scene, from its start to its result."""

import dataclasses as dc
import hashlib
from time import perf_counter

import numpy as np
from pydrake.math import RigidTransform

from remosplat_drake.app.diagram import build
from remosplat_drake.app.scenario import Scenario
from remosplat_drake.app.scenario_robot import load_scenario_robot
from remosplat_drake.app.simulation import run
from remosplat_drake.app.target_config import TargetConfig
from remosplat_drake.app.world import World
from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.base.version import __version__
from remosplat_drake.benchmark import metrics as met
from remosplat_drake.benchmark.carrying import (
    carry,
    judge_carrying,
    until_taken,
)
from remosplat_drake.benchmark.custom_controller import (
    drive,
    load_controller,
)
from remosplat_drake.benchmark.methods import Method
from remosplat_drake.benchmark.moving_case import MovingCase
from remosplat_drake.benchmark.reaching_task import (
    NO_SPLAT,
    BenchmarkCase,
    ReachingTask,
)
from remosplat_drake.benchmark.result import (
    RULES,
    CarryingResult,
    MovingResult,
    TrialResult,
    WallTimes,
)
from remosplat_drake.benchmark.trial_judge import (
    RunJudge,
    arrival_rule,
    judge_contacts,
)
from remosplat_drake.controller.planning.plan import NO_EFFORT, SearchEffort
from remosplat_drake.oracle.oracle_config import make_field
from remosplat_drake.recording.metrics import status_counts
from remosplat_drake.recording.trajectory import Trajectory
from remosplat_drake.robot.pose_error import PoseError
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.signals.distance_field import DistanceField
from remosplat_drake.splat.gaussian_splat import GaussianSplat
from remosplat_drake.task.arrival import has_arrived

TRIAL_VERSION = 8
"""Version of trials, which is a part of their key. Increase it whenever the
results of equal trials change."""


@dc.dataclass(frozen=True)
class Trial:
    """A method in a scene; small enough to be sent to a worker.

    Attributes:
        method: Method that is tried.
        case: Scene and target.
        seed: Seed of all random numbers of the trial.
    """

    method: Method
    case: BenchmarkCase
    seed: int = 0

    def key(self) -> str:
        """Returns a digest of everything that the result depends on.

        If the scene cannot be used, the digest contains the reason instead of
        the scene.
        """
        parts = (
            TRIAL_VERSION,
            self.method.name,
            self.method.fingerprint,
            self.case.name,
            *self._scene_parts(),
            *_moving_parts(self.case),
            self.seed,
        )
        return hashlib.sha256(repr(parts).encode()).hexdigest()[:20]

    def _scene_parts(self) -> tuple:
        try:
            task = self.case.task()
        except RemoSplatError as error:
            return (str(error),)
        splat = self.case.splat_key() if self.method.needs_splat else NO_SPLAT
        return (
            task.content_hash,
            (task.X_WE_target.GetAsMatrix34().tolist(), task.X_WB_start),
            task.arm_start,
            splat,
            *(X_WT.GetAsMatrix34().tolist() for X_WT in task.further_targets),
        )


def _moving_parts(case: BenchmarkCase) -> tuple:
    """Returns the movers of a case; empty if its scene cannot be used."""
    if not isinstance(case, MovingCase):
        return ()
    try:
        return (repr(case.movers()),)
    except RemoSplatError:
        return ()


def describe(trial: Trial, error: str = "") -> TrialResult:
    """Makes a result that contains only the description of its trial.

    Args:
        trial: The trial.
        error: Error text of a crash; empty otherwise.
    """
    scenario = trial.method.scenario
    return TrialResult(
        key=trial.key(),
        method=trial.method.name,
        scene=trial.case.name,
        family=trial.case.family,
        spheres=scenario.robot.spheres,
        gains=trial.method.gains,
        oracle=type(scenario.oracle).__name__,
        splat=NO_SPLAT,
        splat_count=0,
        station=type(scenario.station).__name__.removesuffix("Station").lower(),
        seed=trial.seed,
        version=__version__,
        suite=trial.case.suite,
        error=error,
    )


def run_trial(trial: Trial) -> TrialResult:
    """Runs a trial; equal trials give equal results, except wall-clock times.

    Raises:
        Exception: Any error of the trial.
    """
    started = perf_counter()
    scenario = dc.replace(trial.method.scenario, seed=trial.seed)
    try:
        task = trial.case.task()
    except RemoSplatError as error:
        return dc.replace(describe(trial), problem=str(error))
    splat_W, origin = None, NO_SPLAT
    if trial.method.needs_splat:
        splat_W, origin = trial.case.splat()
    if isinstance(trial.case, MovingCase):
        scenario.movers = list(trial.case.movers())
    if task.support is not None and trial.method.controller:
        problem = (
            f"{trial.method.name}: your own controller cannot carry objects;"
            " select another suite"
        )
        return dc.replace(describe(trial), problem=problem)
    world = _make_world(trial.method, scenario, task, splat_W)
    truth = task.with_grasped(task.truth_field, world.robot)
    problem = start_problem(world.robot, world.q0, truth)
    if problem:
        where = f"{trial.case.file or trial.case.name}: {task.start_field}"
        return dc.replace(describe(trial), problem=f"{where}: {problem}")
    trajectory, effort, carrying = _drive(trial.method, scenario, world, task)
    judge = RunJudge(world.robot, scenario, trajectory, task)
    judgements = {rule: judge.judgement(rule) for rule in RULES}
    return dc.replace(
        describe(trial),
        splat=origin,
        splat_count=0 if splat_W is None else len(splat_W),
        statuses=status_counts(trajectory),
        times=_wall_times(trajectory, perf_counter() - started, effort),
        joint_time=_joint_time(world, task),
        first_checks=None if effort.first_path is None else effort.first_checks,
        self_distance=met.self_distance(world.robot, trajectory.q),
        moving=_contacts(trial, scenario, world, trajectory),
        carrying=carrying,
        **judgements,
    )


def _contacts(
    trial: Trial, scenario: Scenario, world: World, trajectory: Trajectory
) -> MovingResult | None:
    """Evaluates the contacts of a run with movers; None without movers."""
    if not isinstance(trial.case, MovingCase):
        return None
    return judge_contacts(
        scenario, world, trajectory, trial.case.tracks(), trial.seed
    )


def start_problem(
    robot: RobotModel, q: np.ndarray, truth: DistanceField
) -> str:
    """Returns the reason why a robot cannot start at a configuration, or "".

    Args:
        robot: The robot, with its spheres and limits.
        q: Configuration to start from, shape (n_q,).
        truth: True distances.
    """
    if problem := robot.beyond_limits(q):
        return problem
    clearances = truth.clearances(robot.spheres_at(q))
    depth = -clearances.minimum()
    if depth < 0:
        return ""
    row = int(clearances.distance.argmin())
    link = robot.spheres.links[clearances.sphere[row]]
    return (
        f"the robot would be inside the scene: {link} by {1e3 * depth:.0f} mm"
    )


def _joint_time(world: World, task: ReachingTask) -> float | None:
    """Returns the time of a straight path in joint space at full speed [s]."""
    if task.arm_goal is None:
        return None
    way = np.abs(np.array(task.arm_goal) - world.q0)
    return float((way / world.robot.velocity_limit).max())


def _make_world(
    method: Method,
    scenario: Scenario,
    task: ReachingTask,
    splat_W: GaussianSplat | None,
) -> World:
    robot = load_scenario_robot(scenario)
    # Measured ground truth has no solids, so its distance field is used as the
    # map.
    if task.solids is None and not method.needs_splat:
        field = task.truth_field
    else:
        field = make_field(
            scenario.oracle, splat_W, task.solids, scenario.source
        )
    base = task.X_WB_start if robot.n_base else ()
    arm = task.arm_start or scenario.robot.arm or robot.home
    q0 = robot.rounded_into_limits(np.array([*base, *arm]))
    field = task.with_grasped(field, robot)
    return World(robot, splat_W, task.solids, field, q0)


def _drive(
    method: Method, scenario: Scenario, world: World, task: ReachingTask
) -> tuple[Trajectory, SearchEffort, CarryingResult | None]:
    """Runs the closed loop until the robot has arrived by every rule.

    If the robot carries an object back, the trajectory ends at the grasp.
    """
    if task.support is not None:
        result, carried = carry(task, scenario, world)
        carrying = judge_carrying(task, world.robot, result, carried)
        way = until_taken(result.trajectory, carried)
        return way, result.search_effort, carrying
    until = _ArrivedByEveryRule(scenario)
    if not method.controller:
        targets = [
            _pose(X_WT, effector)
            for effector, X_WT in zip(
                world.robot.effectors,
                (task.X_WE_target, *task.further_targets),
                strict=False,
            )
        ]
        scenario = dc.replace(scenario, targets=targets)
        result = run(build(scenario, world), until=until).uninterrupted()
        return result.trajectory, result.search_effort, None
    X_WT = task.X_WE_target.GetAsMatrix4()
    dt = scenario.control_period
    make = load_controller(method.controller)
    trajectory = drive(
        make(world.robot, world.field, X_WT, dt),
        world.robot,
        world.q0,
        X_WT,
        dt=dt,
        ticks=round(scenario.time_limit / dt),
        until=until,
    )
    return trajectory, NO_EFFORT, None


def _pose(X: RigidTransform, effector: str) -> TargetConfig:
    return TargetConfig(
        X.translation().tolist(),
        rotation=X.rotation().matrix().tolist(),
        effector=effector,
    )


class _ArrivedByEveryRule:
    """Whether the robot has arrived by each success rule during the run.

    All rules can then judge the same run.
    """

    def __init__(self, scenario: Scenario):
        self._open = [arrival_rule(scenario, rule) for rule in RULES]

    def __call__(self, error: PoseError) -> bool:
        self._open = [r for r in self._open if not has_arrived(error, r)]
        return not self._open


def _wall_times(
    trajectory: Trajectory, seconds: float, effort: SearchEffort
) -> WallTimes:
    def summary(phase: str, statistic) -> float:
        durations = trajectory.timings.get(phase, np.zeros(0))
        return float(statistic(durations)) if len(durations) else 0.0

    return WallTimes(
        solve_mean=summary("solve", np.nanmean),
        solve_std=summary("solve", np.nanstd),
        tick_p50=summary("total", np.nanmedian),
        tick_p99=summary("total", lambda x: np.nanpercentile(x, 99)),
        trial=seconds,
        first_path=effort.first_path,
    )
