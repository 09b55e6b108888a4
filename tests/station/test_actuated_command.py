"""A simulated robot that obeys late and slowly."""

import numpy as np

from remosplat_drake.robot.actuators import Actuator, ActuatorModel
from remosplat_drake.station.actuated_command import stepped

AXES = ActuatorModel.make(
    [Actuator(delay=0.03), Actuator(time_constant=0.1), Actuator()]
)


def test_steps_are_those_of_the_model():
    rng, dt, late = np.random.default_rng(1), 0.01, np.array([3, 0, 0])
    u = rng.uniform(-1, 1, (20, 3))
    state, way = np.zeros((6, 3)), np.zeros(3)
    for command in u:
        state = stepped(AXES, late, state, command, dt)
        way += dt * state[1]
    zeros = np.zeros(3)
    expected, v = AXES.response(
        dt * np.arange(20), u, zeros, zeros, np.full((1, 3), 0.2)
    )
    np.testing.assert_allclose(way, expected[0], atol=1e-12)
    np.testing.assert_allclose(state[0, 1:], v[0, 1:], atol=1e-12)
