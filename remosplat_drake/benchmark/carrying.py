"""Carries a grasped object to the start's pose, and judges the whole run.

The robot reaches the target as in other trials; only the hand may touch the
object. Then the hand grasps the object, which from then on is part of the
robot. The robot lifts it off its support, and carries it to the end effector's
pose at the start. In some problems, the object is sunk into its support by up
to 10 mm; it is then raised onto the support.
"""

import dataclasses as dc

import numpy as np
from pydrake.math import RigidTransform

from remosplat_drake.app.diagram import build
from remosplat_drake.app.object_map import without_objects
from remosplat_drake.app.run_result import REACHED, RunResult
from remosplat_drake.app.scenario import Scenario
from remosplat_drake.app.simulation import run
from remosplat_drake.app.world import World
from remosplat_drake.benchmark import metrics as met
from remosplat_drake.benchmark.reaching_task import ReachingTask
from remosplat_drake.benchmark.result import (
    COLLISION,
    SUCCESS,
    TIMEOUT,
    CarryingResult,
)
from remosplat_drake.benchmark.trial_judge import CHECKS_A_TICK
from remosplat_drake.oracle.object_field import ObjectField, with_objects
from remosplat_drake.oracle.oracle_config import make_field
from remosplat_drake.recording.trajectory import Trajectory
from remosplat_drake.robot.hand_links import hand_links
from remosplat_drake.robot.payload import Payload
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.robot.sphere_model import Spheres
from remosplat_drake.scene.objects.scene_object import SceneObject
from remosplat_drake.scene.objects.solid_distances import SolidDistances
from remosplat_drake.signals.motion_status import MotionStatus
from remosplat_drake.signals.tick_report import TickReport
from remosplat_drake.task.object_spheres import fit_object, overhang
from remosplat_drake.task.step_configs import (
    AnyStep,
    Attach,
    Lift,
    ReachTo,
    Touch,
)

LEAST = 0.002
"""The robot lifts the object by at least this length [m]."""

_LEFT = 0.005
"""The object has left its support if their distance exceeds this [m]. Before
that, the two may overlap."""

Carried = tuple[float, Payload]
"""The time at which the object was grasped [s], and the object in the hand."""


def carrying_steps(
    task: ReachingTask, robot: RobotModel, q0: np.ndarray, scenario: Scenario
) -> list[AnyStep]:
    """Makes the steps of a trial in which the object is carried.

    Args:
        task: The task, with an object and its support.
        robot: The robot.
        q0: Configuration at the start, shape (n_q,).
        scenario: The scenario, with the arrival tolerances, and with the time
            limit of each step.
    """
    (thing,), support = task.grasped, task.support
    assert support is not None
    leaving = [Touch(support.name, [thing.name])]
    above = max(_distance(thing, support), 0.0)
    # Until the spheres of the object are out of the support, even if the lift
    # ends early by its tolerance.
    out = overhang(thing, fit_object(thing)) + Lift().position
    up = max(out - above, LEAST)
    clear = [Touch(support.name, [thing.name], stopping=0.0)]
    common = {
        "patience": scenario.time_limit,
        "position": scenario.arrival.position,
        "angle": scenario.arrival.angle,
    }
    X_WT = task.X_WE_target.GetAsMatrix4()
    return [
        _reach(X_WT, touch=[Touch(thing.name)], **common),
        Attach(object=thing.name, touch=leaving),
        Lift(
            by=[0.0, 0.0, up],
            touch=leaving,
            patience=scenario.time_limit,
        ),
        _reach(robot.end_effector_pose(q0), touch=clear, **common),
    ]


def _raised(thing: SceneObject, support: SceneObject) -> SceneObject:
    """The object where it stands on its support; some problems sink it in."""
    up = RigidTransform([0.0, 0.0, max(-_distance(thing, support), 0.0)])
    return thing.at(up @ thing.X_WO)


def _distance(thing: SceneObject, support: SceneObject) -> float:
    """The distance of two objects [m], negative if they overlap."""
    (apart,) = SolidDistances(thing.solid, [support.solid]).at(thing.X_WO)
    return float(apart)


def carry(
    task: ReachingTask, scenario: Scenario, world: World
) -> tuple[RunResult, Carried | None]:
    """Runs a trial in which the object is carried.

    Args:
        task: The task, with an object and its support.
        scenario: The scenario of the method.
        world: The content of the scenario's files.

    Returns:
        The run; and the time at which the object was grasped, with its pose in
        the hand, or None if it was not grasped.

    Raises:
        RemoSplatError: The oracle does not support solids.
    """
    assert task.solids is not None and task.support is not None
    (thing,), support = task.grasped, task.support
    objects = (_raised(thing, support), support)
    rest = without_objects(task.solids, objects)
    scene_field = make_field(scenario.oracle, None, rest, scenario.source)
    world = dc.replace(
        world,
        field=with_objects(scene_field, ObjectField(objects)),
        scene_field=scene_field,
        objects=objects,
    )
    scenario = dc.replace(
        scenario,
        tasks=carrying_steps(task, world.robot, world.q0, scenario),
        # Each of the motions fails after the method's time.
        time_limit=4.0 * scenario.time_limit,
    )
    taken: list[Carried] = []

    def watch(
        time: float, motion_status: MotionStatus, report: TickReport | None
    ) -> None:
        if report is None or report.payload is None or taken:
            return
        taken.append((report.time, report.payload))

    result = run(build(scenario, world), on_progress=watch).uninterrupted()
    return result, taken[0] if taken else None


def until_taken(trajectory: Trajectory, carried: Carried | None) -> Trajectory:
    """Returns the part of a run before the object was grasped.

    Args:
        trajectory: The whole run.
        carried: The time at which the object was grasped; None if it was not.
    """
    if carried is None:
        return trajectory
    n = _tick(trajectory, carried)
    return Trajectory(
        trajectory.time[:n],
        trajectory.q[: n + 1],
        trajectory.u[:n],
        trajectory.status[:n],
        trajectory.scale[:n],
        trajectory.clearance[:n],
        {name: each[:n] for name, each in trajectory.timings.items()},
    )


def _tick(trajectory: Trajectory, carried: Carried | None) -> int:
    """The tick at which the object was taken; the end if it was not."""
    if carried is None:
        return len(trajectory)
    return int(np.searchsorted(trajectory.time, carried[0] - 1e-9))


def judge_carrying(
    task: ReachingTask,
    robot: RobotModel,
    result: RunResult,
    carried: Carried | None,
) -> CarryingResult:
    """Judges a run with a carried object against the true shapes.

    The object may touch the hand. It may also touch its support until it has
    left the support.

    Args:
        task: The task.
        robot: The robot, without a payload.
        result: The run.
        carried: The time at which the object was grasped, and its pose in the
            hand.
    """
    trajectory = result.trajectory
    count = CHECKS_A_TICK
    between = met.between_ticks(trajectory.q, count)
    q = np.concatenate([trajectory.q[:-1, None], between], axis=1)
    start = _tick(trajectory, carried)
    shape = (-1, trajectory.q.shape[1])
    before, after = q[:start].reshape(shape), q[start:].reshape(shape)
    standing = task.with_grasped(task.truth_field, robot)
    least = [met.minimum_clearances(robot, before, standing)]
    if carried is not None:
        least.append(met.minimum_clearances(robot, after, task.truth_field))
        least.append(load_clearances(task, robot, after, carried[1]))
    distance = float(np.min(np.concatenate(least), initial=np.inf))
    outcome = SUCCESS if result.outcome == REACHED else TIMEOUT
    return CarryingResult(
        taken=carried is not None,
        outcome=COLLISION if distance <= 0.0 else outcome,
        reason="" if result.outcome == REACHED else result.outcome,
        duration=float(trajectory.time[-1] - trajectory.time[start])
        if start < len(trajectory)
        else 0.0,
        minimum_distance=distance,
    )


def load_clearances(
    task: ReachingTask, robot: RobotModel, q: np.ndarray, payload: Payload
) -> np.ndarray:
    """Computes the least true distance of the carried object from all else.

    Args:
        task: The task, whose object is carried.
        robot: The robot, without a payload.
        q: Configurations in their order, shape (n, n_q).
        payload: The object in the hand.

    Returns:
        Distances to all solids of the scene, and to all links except the
        hand's, shape (n,) [m]; those from the support count once the object has
        left it.
    """
    (thing,), support = task.grasped, task.support
    assert task.solids is not None and support is not None
    others = without_objects(task.solids, [support]).primitives
    shapes = SolidDistances(thing.solid, [support.solid, *others])
    alone = ObjectField([thing.at(RigidTransform())])
    links, hand = robot.spheres.links, hand_links(robot)
    arm = np.array([link not in hand for link in links])
    body, left, found = robot.tree.index(payload.link), False, []
    for q_t in q:
        X_WO = robot.body_poses(q_t)[body] @ payload.X_LO
        distances = shapes.at(RigidTransform(X_WO))
        left = left or bool(distances[0] > _LEFT)
        spheres = robot.spheres_at(q_t).select(arm)
        p_OS = (spheres.p_WS - X_WO[:3, 3]) @ X_WO[:3, :3]
        own = alone.clearances(Spheres.at(p_OS, spheres.radius)).minimum()
        found.append(min(own, *distances[0 if left else 1 :]))
    return np.array(found)


def _reach(X_WT: np.ndarray, **common) -> ReachTo:
    return ReachTo(
        translation=X_WT[:3, 3].tolist(),
        rotation=X_WT[:3, :3].tolist(),
        **common,
    )
