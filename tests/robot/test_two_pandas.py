"""The shipped two-armed robot is the Panda, twice."""

import numpy as np
import pytest

from remosplat_drake.robot.robot_model import RobotModel, load_robot

SIDES = ("left", "right")


@pytest.fixture(scope="module")
def two() -> RobotModel:
    return load_robot("two_pandas")


@pytest.fixture(scope="module")
def one() -> RobotModel:
    return load_robot("panda")


def test_each_arm_reaches_where_a_panda_does(two, one):
    rng = np.random.default_rng(7)
    qs = rng.uniform(one.position_lower, one.position_upper, (2, 7))
    poses = two.end_effector_poses(qs.ravel())
    for q, X_WE, y in zip(qs, poses, (0.3, -0.3), strict=True):
        X_WE[1, 3] -= y
        np.testing.assert_allclose(X_WE, one.end_effector_pose(q), atol=1e-12)
    assert two.effectors == SIDES


def test_limits_and_spheres_are_those_of_a_panda(two, one):
    for name in (
        "velocity_limit",
        "acceleration_limit",
        "position_lower",
        "position_upper",
        "home",
    ):
        np.testing.assert_array_equal(
            getattr(two, name), np.tile(getattr(one, name), 2)
        )
    for side in SIDES:
        for link in set(one.spheres.links):
            ours = two.spheres.on_link(f"{side}_{link.removeprefix('panda_')}")
            np.testing.assert_array_equal(
                ours.radius, one.spheres.on_link(link).radius
            )
