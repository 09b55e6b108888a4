"""A robot on the move goes over to another map only where it can stop."""

import numpy as np
import pytest
from pydrake.math import RigidTransform

from remosplat_drake.controller.map_change import NO_WAY_TO_STOP, objection
from remosplat_drake.controller.tick.reactive_law import ReactiveLaw
from remosplat_drake.oracle.signed_distance import SignedDistanceField
from remosplat_drake.robot.robot_model import RobotModel, load_robot
from remosplat_drake.scene.primitive_scene import Box, PrimitiveScene

DT = 0.01


@pytest.fixture(scope="module")
def law() -> ReactiveLaw:
    return ReactiveLaw(load_robot("frankie"), [], DT)


def wall(robot: RobotModel, gap: float) -> SignedDistanceField:
    """A wall in front of the robot's home, so far from its foremost sphere."""
    spheres = robot.spheres_at(robot.q_home)
    front = float((spheres.p_WS[:, 0] + spheres.radius).max())
    middle = RigidTransform([front + gap + 0.5, 0, 1])
    box = Box(middle, np.array([0.5, 3.0, 3.0]))
    return SignedDistanceField(PrimitiveScene(boxes=(box,)))


def ahead(law: ReactiveLaw, speed: float) -> np.ndarray:
    u = np.zeros(law.robot.n_u)
    u[0] = speed
    return u


def braking_distance(law: ReactiveLaw, speed: float) -> float:
    """How far a base goes in a tick and on its ramp, worked by hand [m]."""
    steps = speed / (law.robot.acceleration_limit[0] * DT)
    return speed * DT * sum(1 - k / steps for k in range(int(np.ceil(steps))))


def test_what_leaves_room_for_the_ramp_may_count(law):
    way = braking_distance(law, 0.3)
    stopping = law.collision.stopping
    q = law.robot.q_home
    near = wall(law.robot, way + stopping - 0.003)
    assert objection(law, near, q, ahead(law, 0.3)).startswith(NO_WAY_TO_STOP)
    enough = wall(law.robot, way + stopping + 0.003)
    assert objection(law, enough, q, ahead(law, 0.3)) == ""


def test_the_pose_in_the_new_map_counts(law):
    q, u = law.robot.q_home.copy(), ahead(law, 0.3)
    room = braking_distance(law, 0.3) + law.collision.stopping + 0.003
    field = wall(law.robot, room)
    assert objection(law, field, q, u) == ""
    q[0] += 0.006
    assert objection(law, field, q, u).startswith(NO_WAY_TO_STOP)


def test_a_robot_at_rest_or_going_away_may_always_change(law):
    field = wall(law.robot, -0.05)
    q = law.robot.q_home
    assert objection(law, field, q, ahead(law, 0.0)) == ""
    assert objection(law, field, q, ahead(law, -0.1)) == ""
    assert objection(law, field, q, ahead(law, 0.1)).startswith(NO_WAY_TO_STOP)


def test_without_verification_there_is_no_question(law):
    careless = ReactiveLaw(law.robot, [], DT, verify=False)
    field = wall(law.robot, -0.05)
    assert objection(careless, field, law.robot.q_home, ahead(law, 0.3)) == ""
