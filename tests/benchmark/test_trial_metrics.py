"""The paper's metrics on motions that can be worked out by hand."""

import numpy as np
import pytest

from remosplat_drake.benchmark import metrics as met
from remosplat_drake.generation.scene_generators import generate
from remosplat_drake.oracle.signed_distance import SignedDistanceField
from remosplat_drake.task.arrival import ArrivalConfig


def spin(robot, rate: float, dt: float, ticks: int):
    """The first joint turns at a constant rate."""
    u = np.zeros((ticks, robot.n_u))
    u[:, 0] = rate
    q = [np.array(robot.home, float)]
    for u_t in u:
        q.append(robot.advance(q[-1], u_t, dt))
    return np.array(q), u


def test_a_steady_turn_has_only_centripetal_acceleration(three_link):
    q, u = spin(three_link, rate=0.5, dt=0.05, ticks=20)
    state = three_link.state(q[0])
    radius = np.linalg.norm(state.Jv_WE[:, 0])
    assert radius > 0.1
    acceleration = met.mean_acceleration(three_link, q, u, 0.05)
    assert acceleration == pytest.approx(radius * 0.5**2, rel=1e-6)


def test_a_straight_drive_has_no_acceleration_but_at_its_ends(frankie):
    dt, speed, ticks = 0.05, 0.4, 10
    u = np.zeros((ticks, frankie.n_u))
    u[:, 0] = speed
    q = np.zeros((ticks + 1, frankie.n_q))
    q[:, 3:] = frankie.home
    q[:, 0] = speed * dt * np.arange(ticks + 1)
    assert met.mean_acceleration(frankie, q, u, dt) == pytest.approx(
        0, abs=1e-6
    )

    # Ten velocities and a rest at each end: eleven steps, two of 0.4 m/s.
    p_WE = met.end_effector_positions(frankie, q)
    expected = 2 * speed / dt / 11
    assert met.resampled_acceleration(p_WE, dt) == pytest.approx(expected)


def test_a_ramp_has_the_acceleration_of_its_slope(frankie):
    dt, slope, ticks = 0.05, 0.3, 12
    u = np.zeros((ticks, frankie.n_u))
    u[:, 0] = slope * dt * np.arange(ticks)
    q = np.tile([0, 0, 0, *frankie.home], (ticks, 1))
    acceleration = met.mean_acceleration(frankie, q, u, dt)
    assert acceleration == pytest.approx(slope, rel=1e-6)


@pytest.mark.parametrize("dt", [0.05, 0.01])
def test_the_resampled_acceleration_does_not_see_the_control_rate(dt):
    times = np.arange(0, 1 + dt / 2, dt)
    p_WE = np.outer(0.5 * 0.8 * times**2, [1, 0, 0])
    # 20 velocities, the last one 0.8 * 0.975 m/s: up a ramp, then a stop.
    expected = 2 * 0.8 * 0.975 / 0.05 / 21
    assert met.resampled_acceleration(p_WE, dt) == pytest.approx(expected)


def test_nothing_moved_is_no_acceleration(three_link):
    q = np.array([three_link.home])
    assert met.mean_acceleration(three_link, q, np.zeros((0, 3)), 0.05) == 0.0
    assert met.resampled_acceleration(np.zeros((1, 3)), 0.05) == 0.0


def test_arrival_is_the_first_configuration_that_the_rule_accepts(three_link):
    q, _ = spin(three_link, rate=0.1, dt=0.05, ticks=40)
    X_WT = three_link.end_effector_pose(q[30])
    errors = met.target_errors(three_link, q, X_WT[None])
    for rule in (ArrivalConfig(), ArrivalConfig(rule="authors")):
        tick = met.arrival_tick(errors, rule)
        assert tick is not None and 0 < tick < 30
        position = errors[tick].distance
        assert position < 0.02
    X_WT = X_WT.copy()
    X_WT[0, 3] += 1
    errors = met.target_errors(three_link, q, X_WT[None])
    assert met.arrival_tick(errors, ArrivalConfig()) is None


def test_between_ticks_divides_them_evenly():
    q = np.array([[0.0, 0.0], [1.0, 5.0]])
    expected = [[[0.2, 1], [0.4, 2], [0.6, 3], [0.8, 4]]]
    np.testing.assert_allclose(met.between_ticks(q, 5), expected)


def test_minimum_clearances_are_those_of_the_truth(frankie):
    field = SignedDistanceField(generate("table", 1))
    q = np.array([[-1.0, 0, 0, *frankie.home], [0.0, 0, 0, *frankie.home]])
    far, near = met.minimum_clearances(frankie, q, field)
    assert far > near
    assert near == field.clearances(frankie.spheres_at(q[1])).minimum()


def test_standing_still_is_stalled_and_moving_is_not(frankie):
    q = np.tile([0.0, 0, 0, *frankie.home], (41, 1))
    stall = {"dt": 0.05, "window": 1.0, "reach": 0.01}
    assert met.is_stalled(frankie, q, **stall)
    early = q.copy()
    early[:10, 0] = np.linspace(0, 1, 10)
    assert met.is_stalled(frankie, early, **stall)
    late = q.copy()
    late[-10:, 0] = np.linspace(0, 1, 10)
    assert not met.is_stalled(frankie, late, **stall)
