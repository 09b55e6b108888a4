"""A shipped scenario with a person: no contact, and the robot arrives."""

import numpy as np
import pytest
from pydrake.systems.analysis import Simulator

from remosplat_drake.app.diagram import build
from remosplat_drake.app.scenario import load_scenario
from remosplat_drake.app.world import load_world
from remosplat_drake.scene.moving.mover_track import MoverTrack
from remosplat_drake.scene.moving.track import movers_at
from remosplat_drake.signals.near_movers import NearMovers


@pytest.fixture(scope="module")
def scenario():
    return load_scenario("PersonPasses")


def test_the_robot_makes_way_and_arrives(scenario):
    world = load_world(scenario)
    application = build(scenario, world)
    tracks = [MoverTrack(config) for config in scenario.movers]
    simulator = Simulator(application.diagram)
    nearest, retreated, before = np.inf, 0, np.inf
    while not arrived(application, simulator):
        time = simulator.get_context().get_time() + 0.05
        assert time < 12.0
        simulator.AdvanceTo(time)
        q = measured(application, simulator)
        there = movers_at(tracks, time)
        spheres = world.robot.spheres_at(q)
        near = NearMovers.find(there, time, spheres, 9.0)
        nearest = min(nearest, float(near.distance.min()))
        p_WE = world.robot.end_effector_pose(q)[0, 3]
        retreated += int(p_WE < before - 1e-3 and near.closing.max() > 0.1)
        before = p_WE
    assert 0.04 < nearest < 0.2
    assert retreated > 3


def arrived(application, simulator) -> bool:
    targets = application.targets
    context = targets.GetMyContextFromRoot(simulator.get_context())
    return targets.progress(context).finished


def measured(application, simulator) -> np.ndarray:
    port = application.configuration
    context = port.get_system().GetMyContextFromRoot(simulator.get_context())
    return port.Eval(context)


@pytest.mark.slow
def test_it_would_be_touched_if_it_were_not_told(scenario):
    """Without the damper and verification of movers the hand goes on."""
    told = scenario.movers
    blind = load_scenario("PersonPasses", "{movers: []}")
    world = load_world(blind)
    application = build(blind, world)
    tracks = [MoverTrack(config) for config in told]
    simulator = Simulator(application.diagram)
    nearest = np.inf
    for time in np.arange(0.05, 4.0, 0.05):
        simulator.AdvanceTo(time)
        q = measured(application, simulator)
        near = NearMovers.find(
            movers_at(tracks, time), time, world.robot.spheres_at(q), 9.0
        )
        nearest = min(nearest, float(near.distance.min()))
    assert nearest < 0.0
