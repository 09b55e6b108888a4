"""The stand-in's slow axes are those that prediction believes in."""

import numpy as np
import pytest

from remosplat_drake.hardware.stand_in.actuated_axes import ActuatedAxes
from remosplat_drake.robot.actuators import Actuator, ActuatorModel

AXES = [
    Actuator(),
    Actuator(delay=0.05, acceleration=1.0),
    Actuator(delay=0.003, time_constant=0.2, dead_band=0.01),
]


def test_an_axis_without_a_model_does_as_it_is_told():
    axes = ActuatedAxes([Actuator()] * 3, 1e-3)
    u = np.array([0.3, -0.2, 1.0])
    assert axes.step(u).tolist() == u.tolist()


def test_ways_are_those_of_the_model():
    rng = np.random.default_rng(0)
    axes, tick = ActuatedAxes(AXES, 1e-3), 0.01
    u = rng.uniform(-1, 1, (30, 3))
    way = np.zeros(3)
    for command in np.repeat(u, 10, axis=0):
        way += 1e-3 * axes.step(command)
    expected, _ = ActuatorModel.make(AXES).response(
        tick * np.arange(30), u, np.zeros(3), np.zeros(3), np.full((1, 3), 0.3)
    )
    np.testing.assert_allclose(way, expected[0], atol=1e-9)


def test_a_delay_is_a_delay():
    axes = ActuatedAxes([Actuator(delay=0.15)], 1e-3)
    moved = [axes.step(np.ones(1))[0] for _ in range(200)]
    assert sum(moved) == pytest.approx(50)
    assert moved[:150] == [0.0] * 150
