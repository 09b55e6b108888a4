"""The stand-in's bodies: joints without motors do not shift the others."""

import numpy as np
import pytest

from remosplat_drake.app.scenario import load_scenario
from remosplat_drake.app.world import World, load_world
from remosplat_drake.hardware.stand_in.robot_plant import RobotPlant
from remosplat_drake.station.station_config import DynamicStation


@pytest.fixture(scope="module")
def world() -> World:
    return load_world(load_scenario("FetchReach"), blank=True)


@pytest.mark.parametrize("joint", [1, 7])
def test_a_joint_that_speeds_up_has_a_torque(world, joint):
    """A Fetch's head is locked, and comes before the joints of its arm."""
    plant = RobotPlant(DynamicStation(), world.robot, world.truth, world.q0)
    rates = np.zeros(8)
    rates[joint] = 1.0
    torques = np.zeros(8)
    for k in range(5):
        hand = np.array([0.1, 10.0])
        plant.step(1e-3 * (k + 1), np.zeros(2), rates, hand)
        torques = np.maximum(torques, np.abs(plant.arm.torque))
    assert torques[joint] > 0.01
