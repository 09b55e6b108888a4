"""The reach of an arm is never less than what it does reach."""

import numpy as np
import pytest

from remosplat_drake.robot.reach import arm_reach, shoulder
from remosplat_drake.robot.robot_model import RobotModel


def reached(robot: RobotModel, q: np.ndarray) -> float:
    """How far the arm gets from its shoulder at q, to its surface [m]."""
    spheres = robot.spheres_at(q)
    arm = ~robot.spheres.on_links({"base_link", "panda_link0"})
    distance = np.linalg.norm(spheres.p_WS - shoulder(robot, q), axis=1)
    return (distance + spheres.radius)[arm].max()


def test_an_outstretched_arm(three_link):
    """Links of 0.5 and 0.4 m, and a wrist's ball of 0.04 m in front."""
    wrist = np.hypot(0.06, 0.01) + 0.04
    assert arm_reach(three_link) == pytest.approx(0.9 + wrist)
    np.testing.assert_allclose(shoulder(three_link, np.zeros(3)), [0, 0, 1])
    # The ball is 1 cm beside the arm's line.
    assert reached(three_link, np.zeros(3)) == pytest.approx(1.0, abs=3e-3)


def test_no_configuration_gets_farther(frankie):
    rng = np.random.default_rng(0)
    arm = rng.uniform(
        frankie.position_lower[3:], frankie.position_upper[3:], (2000, 7)
    )
    base = rng.uniform(-3, 3, (2000, 3))
    distance = [reached(frankie, q) for q in np.hstack([base, arm])]
    assert 0.7 * arm_reach(frankie) < max(distance) <= arm_reach(frankie)


def test_the_shoulder_rides_on_the_base(frankie):
    home = np.array([0, 0, 0, *frankie.home])
    x, y, z = shoulder(frankie, home)
    # Half a turn, and elsewhere.
    moved = shoulder(frankie, np.array([3, -2, np.pi, *frankie.home]))
    np.testing.assert_allclose(moved, [3 - x, -2 - y, z], atol=1e-12)
    # For any motion of the arm.
    turned = shoulder(frankie, home + np.array([0, 0, 0, *np.ones(7)]))
    np.testing.assert_allclose(turned, [x, y, z])
