"""Makes the scenario of a problem, with what the robot can grasp and reach."""

import dataclasses as dc

import numpy as np
from pydrake.math import RigidTransform, RotationMatrix

from remosplat_drake.app.scenario import RobotConfig, Scenario
from remosplat_drake.app.world import World, make_field
from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.base.pose_config import PoseConfig, make_transform
from remosplat_drake.controller.planning.free_space import FreeSpace
from remosplat_drake.controller.planning.goal_configurations import (
    goal_configurations,
)
from remosplat_drake.controller.tick.reactive_law import ReactiveLaw
from remosplat_drake.generation.pick_and_place import TARGET, PickAndPlace
from remosplat_drake.generation.primitive_surfels import surfel_splat
from remosplat_drake.grasping.gripper import ParallelGripper
from remosplat_drake.oracle.object_field import ObjectField, with_objects
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.scene.objects.scene_object import SceneObject
from remosplat_drake.signals.distance_field import DistanceField
from remosplat_drake.station.station_config import DynamicStation
from remosplat_drake.task.carrying import make_payload
from remosplat_drake.task.object_spheres import fit_object
from remosplat_drake.task.step_configs import GraspConfig, Pick, Place

TIME_LIMIT = 150.0
"""A problem has failed if it takes longer than this [s]."""

ARRIVED = 0.004
"""The hand has arrived around the target if its position error is at most this
[m]."""

PUT_DOWN = 0.008
"""Distance from its place at which the target is released [m], since an object
that has turned in the hand touches earlier."""

PATIENCE = 25.0
"""A step has failed if it takes longer than this [s]."""

LOWER = 0.06
"""Distance of the straight motion down to the place [m]; it is short, since
bays are low."""

RETREAT = 0.06
"""Length of the hand's straight retreat from the released target [m]."""

STOPPING = 0.025
"""Distance that goal configurations keep [m]: more than the controller's.
"""

SEEDS = 30
"""Number of configurations from which the search for each pose starts."""

ENOUGH = 3
"""Number of grasps that are tried."""

TURNS = np.radians([0, 45, -45, 90, -90, 135, -135, 180])
"""Turns of the target about the vertical with which it may be put down [rad].
"""

SQUEEZE = 0.012
"""Difference of the object's width and the hand's commanded width [m]."""


def make_world(
    problem: PickAndPlace, robot: RobotModel, grasps: list[GraspConfig]
) -> tuple[Scenario, World]:
    """Makes the scenario of a problem, and its world.

    Args:
        problem: The problem.
        robot: Its robot.
        grasps: The grasps that are tried.
    """
    supports = {problem.pick.support, problem.place.support}
    scene = problem.scene
    stands = tuple(
        SceneObject(each.name, each)
        for each in scene.boxes
        if each.name in supports
    )
    rest = dc.replace(
        scene, boxes=tuple(x for x in scene.boxes if x.name not in supports)
    )
    scenario = Scenario(
        robot=RobotConfig(model=problem.robot),
        station=DynamicStation(time_step=0.002),
        time_limit=TIME_LIMIT,
        tasks=[
            Pick(
                object=TARGET,
                support=problem.pick.support,
                grasps=grasps,
                squeeze=SQUEEZE,
                position=ARRIVED,
                patience=PATIENCE,
            ),
            Place(
                support=problem.place.support,
                places=[PoseConfig(**_pose(X)) for X in turned(problem)],
                position=PUT_DOWN,
                patience=PATIENCE,
                lower=LOWER,
                retreat=RETREAT,
            ),
        ],
    )
    scenario.source = problem.name
    splat, objects = surfel_splat(rest), (*problem.objects, *stands)
    scene_field = make_field(scenario.oracle, splat, rest, problem.name)
    base = scene.X_WB_start if robot.n_base else ()
    return scenario, World(
        robot,
        splat,
        scene,
        with_objects(scene_field, ObjectField(objects)),
        np.array([*(base or ()), *robot.home]),
        scene_field=scene_field,
        objects=objects,
    )


def strong_enough(
    problem: PickAndPlace, gripper: ParallelGripper
) -> list[GraspConfig]:
    """Returns the grasps of a problem for which the hand is strong enough.

    Args:
        problem: The problem.
        gripper: The gripper of its robot.
    """
    mass = problem.objects[0].mass or 0.0
    found = []
    for grasp in problem.grasps:
        try:
            force = grasp.force(gripper, mass)
        except RemoSplatError:
            continue
        found.append(
            GraspConfig(
                **_pose(grasp.X_OE),
                width=grasp.width,
                force=force,
            )
        )
    return found


def keep_reachable(
    scenario: Scenario, world: World, gripper: ParallelGripper
) -> bool:
    """Removes grasps and places of a scenario that the robot cannot reach.

    The arm must keep its distances with the hand in front of the target, around
    the target, above one of the places with the target in the hand, and with
    the empty hand at the place and after its retreat.

    Args:
        scenario: The scenario of a problem, which is changed.
        world: Its world.
        gripper: The gripper of its robot.

    Returns:
        Whether any grasp and place are left.
    """
    pick, place = scenario.tasks
    assert isinstance(pick, Pick)
    assert isinstance(place, Place)
    target, others = world.objects[0], world.objects[1:]
    assert world.scene_field is not None
    beside = with_objects(world.scene_field, ObjectField(others))
    robot, q0, X_WO = world.robot, world.q0, target.X_WO.GetAsMatrix4()
    law = ReactiveLaw.make(scenario.controller, robot, scenario.control_period)
    spheres = fit_object(target)
    before, after, above = np.eye(4), np.eye(4), np.eye(4)
    before[:3, 3] = -pick.approach * gripper.approach_E
    after[:3, 3] = -place.retreat * gripper.approach_E
    above[2, 3] = place.lower
    grasps, places = [], []
    for grasp in pick.grasps:
        X_OE = make_transform(grasp, scenario.source, "grasps").GetAsMatrix4()
        if not _reaches(law, beside, q0, X_WO @ X_OE):
            continue
        if not _reaches(law, world.field, q0, X_WO @ X_OE @ before):
            continue
        X_WO_held = robot.end_effector_pose(q0) @ np.linalg.inv(X_OE)
        held = target.at(RigidTransform(X_WO_held))
        carrying = law.holding(make_payload(robot, held, spheres, q0))
        at = []
        for each in place.places:
            X_WP = make_transform(each, scenario.source, "places")
            X_WE = X_WP.GetAsMatrix4() @ X_OE
            if _reaches(carrying, beside, q0, above @ X_WE) and all(
                _reaches(law, beside, q0, X) for X in (X_WE, X_WE @ after)
            ):
                at.append(each)
        if at:
            grasps.append(grasp)
            places += [each for each in at if each not in places]
        if len(grasps) == ENOUGH:
            break
    pick.grasps, place.places = grasps, places
    return bool(grasps)


def _reaches(
    law: ReactiveLaw, field: DistanceField, q0: np.ndarray, X_WE: np.ndarray
) -> bool:
    """Whether some configuration at a pose keeps all distances."""
    robot = law.robot
    bounds = robot.position_lower, robot.position_upper
    if robot.n_base:
        room = np.array([2.0, 2.0, 4.0])
        p = np.array([*X_WE[:2, 3], 0.0])
        bounds = bounds[0].copy(), bounds[1].copy()
        bounds[0][:3], bounds[1][:3] = p - room, p + room
    space = FreeSpace(robot, field, STOPPING, law.self_clearance, bounds, q0)
    rng = np.random.default_rng(0)
    found = goal_configurations(space, X_WE, q0, seeds=SEEDS, most=1, rng=rng)
    return len(found.q) > 0


def turned(problem: PickAndPlace) -> list[np.ndarray]:
    """Returns the poses at which the target may be put down, (4, 4) each.

    Args:
        problem: The problem.
    """
    goal = problem.X_WO_goal
    return [
        RigidTransform(
            RotationMatrix.MakeZRotation(turn) @ goal.rotation(),
            goal.translation(),
        ).GetAsMatrix4()
        for turn in TURNS
    ]


def _pose(X: np.ndarray) -> dict[str, list]:
    return {"translation": X[:3, 3].tolist(), "rotation": X[:3, :3].tolist()}
