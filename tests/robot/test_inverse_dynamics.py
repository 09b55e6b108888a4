"""Torques of motions, as Drake computes them for all shipped robots."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import MultibodyForces

from remosplat_drake.robot.model_file import add_robot_model
from remosplat_drake.robot.robot_model import RobotModel, load_robot

ROBOTS = ("panda", "frankie", "ur5e", "fetch", "ridgeback_panda", "two_pandas")


def reference_torques(robot: RobotModel, q, v, a) -> np.ndarray:
    """Drake's inverse dynamics, of all joints, shape (n_q,)."""
    plant = MultibodyPlant(time_step=0.0)
    add_robot_model(robot.description, plant)
    plant.Finalize()
    context = plant.CreateDefaultContext()
    for name, value in robot.description.locked.items():
        place = plant.GetJointByName(name).position_start()
        positions = plant.GetPositions(context)
        positions[place] = value
        plant.SetPositions(context, positions)
    joints = [plant.GetJointByName(name) for name in robot.joint_names]
    positions = plant.GetPositions(context)
    velocities, accelerations = np.zeros((2, plant.num_velocities()))
    at = [joint.velocity_start() for joint in joints]
    positions[[joint.position_start() for joint in joints]] = q
    velocities[at], accelerations[at] = v, a
    plant.SetPositions(context, positions)
    plant.SetVelocities(context, velocities)
    forces = MultibodyForces(plant)
    plant.CalcForceElementsContribution(context, forces)
    return plant.CalcInverseDynamics(context, accelerations, forces)[at]


@pytest.mark.parametrize("name", ROBOTS)
@given(seed=st.integers(0, 10**6))
@settings(max_examples=10, deadline=None)
def test_all_robots_need_the_torques_that_drake_computes(name, seed):
    robot, rng = load_robot(name), np.random.default_rng(seed)
    q, v, a = rng.normal(size=(3, robot.n_q))
    expected = reference_torques(robot, q, v, a)
    found = robot.dynamics.torques(q[None], v[None, None], a[None, None])
    arm = robot.n_q - len(robot.dynamics.limit)
    scale = np.abs(expected).max()
    np.testing.assert_allclose(
        found[0, 0], expected[arm:], rtol=1e-9, atol=1e-9 * scale
    )
