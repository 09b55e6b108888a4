"""A base that goes to poses, with the arm as it is."""

import numpy as np
import pytest
from runs import load_application
from true_shapes import watched

from remosplat_drake.app.diagram import Application
from remosplat_drake.robot import planar_pose
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.signals.distance_field import DistanceField
from remosplat_drake.task.task import DONE

USUAL, MAP_ERROR = 0.021, 0.003
"""The stopping distance, and the measured error of the splat [m]."""

BOX = [-1.2, -1.6, -np.pi], [1.0, 1.6, np.pi]
"""Where bases are drawn: the arm reaches over the table, between its cans."""


def free_base(
    robot: RobotModel, truth: DistanceField, rng: np.random.Generator
) -> np.ndarray:
    """A pose of the base where the robot at home keeps 30 mm."""
    while True:
        q = robot.q_home.copy()
        q[:3] = rng.uniform(*BOX)
        if truth.clearances(robot.spheres_at(q)).minimum() > 0.03:
            return q[:3]


def driving(name: str, start, goal) -> Application:
    return load_application(
        "TableReach",
        f"{{robot: {{model: {name}, base_pose: {list(map(float, start))}}},"
        f" time_limit: 60, tasks: [!DriveTo {{patience: 55,"
        f" base_pose: {list(map(float, goal))}}}]}}",
    )


@pytest.mark.parametrize(
    ("name", "drives"),
    [
        ("frankie", 1),
        pytest.param("frankie", 20, marks=pytest.mark.slow),
        pytest.param("fetch", 20, marks=pytest.mark.slow),
        pytest.param("ridgeback_panda", 20, marks=pytest.mark.slow),
    ],
)
def test_a_base_arrives_among_obstacles_with_its_arm(name, drives):
    rng = np.random.default_rng(41)
    world = load_application("TableReach", f"robot: {{model: {name}}}").world
    robot, truth = world.robot, world.truth_field
    assert truth is not None
    start = free_base(robot, truth, rng)
    for _ in range(drives):
        goal = free_base(robot, truth, rng)
        moments = watched(driving(name, start, goal))
        last = moments[-1]
        assert last.state.outcome == DONE, last.state.failures
        off = planar_pose.relative(last.q[:3], goal)
        assert np.hypot(*off[:2]) < 0.022 and abs(off[2]) < np.radians(1.1)
        # 20 mm or a degree at the hand is less than this of any joint.
        assert np.abs(last.q[3:] - moments[0].q[3:]).max() < 0.06
        nearest = min(
            truth.clearances(robot.spheres_at(m.q)).minimum()
            for m in moments[::3]
        )
        assert nearest > USUAL - MAP_ERROR
        start = goal
