"""MuJoCo moves a robot as Drake does, and measures its contacts."""

import numpy as np
import pytest

pytest.importorskip("mujoco", reason="needs the package mujoco")

from apps.studies.mujoco_robot.mujoco_plant import MujocoPlant
from remosplat_drake.app.scenario import load_scenario
from remosplat_drake.app.world import load_world
from remosplat_drake.hardware.stand_in.robot_plant import RobotPlant
from remosplat_drake.hardware.stand_in.simulated_arm import COLLISION_TORQUE
from remosplat_drake.station.station_config import DynamicStation

BASE = {0: (), 2: (0.2, 0.3), 3: (0.2, 0.1, 0.3)}
"""Commands of bases, by their number [m/s, rad/s]."""


@pytest.mark.parametrize("name", ["TableReach", "FetchReach", "Ur5eReach"])
def test_both_simulators_move_a_robot_alike(name):
    world = load_world(load_scenario(name), blank=True)
    robot = world.robot
    arm = np.random.default_rng(0).uniform(-0.2, 0.2, len(robot.home))
    ends = []
    for kind in (RobotPlant, MujocoPlant):
        plant = kind(DynamicStation(), robot, None, world.q0)
        for k in range(500):
            plant.step(
                1e-3 * (k + 1),
                np.array(BASE[robot.n_base]),
                arm,
                np.array([0.02, 20.0]),
            )
        ends.append(plant)
    drake, mujoco = ends
    np.testing.assert_allclose(mujoco.q, drake.q, atol=0.015)
    n = len(robot.home)
    np.testing.assert_allclose(mujoco.q[-n:], drake.q[-n:], atol=2e-3)
    np.testing.assert_allclose(
        mujoco.base_velocity, drake.base_velocity, atol=0.01
    )
    np.testing.assert_allclose(mujoco.hand[0], drake.hand[0], atol=1e-3)


def test_an_arm_that_meets_the_table_feels_it():
    world = load_world(load_scenario("TableReach"), blank=True)
    plant = MujocoPlant(
        DynamicStation(), world.robot, world.fixed_truth, world.q0
    )
    down = np.array([0.0, 0.8, 0.0, 0.0, 0.0, 0.0, 0.0])
    hand, felt = np.array([0.08, 20.0]), 0.0
    for k in range(4000):
        plant.step(1e-3 * (k + 1), np.array([0.3, 0.0]), down, hand)
        felt = max(felt, float(np.abs(plant.arm.external).max()))
        if felt > COLLISION_TORQUE:
            return
    raise AssertionError(felt)
