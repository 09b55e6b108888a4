"""The kinematic station reaches the state that was verified, exactly."""

import numpy as np
import pytest

from remosplat_drake.station.simulated_station import MakeSimulatedStation
from remosplat_drake.station.station_config import KinematicStation

EXACT = 1e-10


def make(robot, harness, q0, **kwargs):
    station = MakeSimulatedStation(
        config=KinematicStation(hand_speed=0.1),
        robot=robot,
        scene=None,
        q0=q0,
    )
    return harness(station, robot, **kwargs)


@pytest.fixture(params=["frankie", "three_link"])
def robot(request):
    return request.getfixturevalue(request.param)


@pytest.mark.parametrize("period", [0.005, 0.02, 0.1])
def test_the_state_reached_is_the_one_predicted(robot, harness, period):
    rng = np.random.default_rng(0)
    q = rng.uniform(-1, 1, robot.n_q)
    dut = make(robot, harness, q, control_period=period)
    for _ in range(20):
        u = rng.uniform(-1, 1, robot.n_u) * robot.velocity_limit
        dut.command(u)
        dut.advance(period)
        q = robot.advance(q, u, period)
        np.testing.assert_allclose(dut.q, q, rtol=0, atol=EXACT)


def test_a_viewer_between_two_ticks_changes_nothing(frankie, harness):
    """Steps that a publish event cuts in two end in the same state."""
    q0 = np.r_[0, 0, 0.5, frankie.home]
    u = frankie.velocity_limit * [1, -1, 1, 0, 0, 1, 0, 0, 1]
    dut = make(frankie, harness, q0)
    dut.command(u)
    for duration in (0.013, 0.002, 0.005):
        dut.advance(duration)
    q = frankie.advance(q0, u, 0.02)
    np.testing.assert_allclose(dut.q, q, rtol=0, atol=EXACT)


def test_a_tick_costs_seven_derivatives(frankie, harness):
    dut = make(frankie, harness, np.r_[0, 0, 0, frankie.home])
    dut.advance(0.1)
    integrator = dut.simulator.get_integrator()
    ticks = integrator.get_num_steps_taken()
    assert ticks == 5
    assert integrator.get_num_derivative_evaluations() <= 7 * (ticks + 1)


def test_odometry_may_drift_while_the_robot_does_not(frankie, harness):
    q0 = np.r_[0.2, 0.1, 0.5, frankie.home]
    config = KinematicStation(odometry_drift=[0.02, -0.01, 0.001])
    station = MakeSimulatedStation(
        config=config, robot=frankie, scene=None, q0=q0
    )
    dut = harness(station, frankie)
    dut.advance(2.0)
    drifted = q0 + np.r_[0.04, -0.02, 0.002, np.zeros(7)]
    np.testing.assert_allclose(dut.q, drifted, rtol=0, atol=EXACT)


def test_measured_velocity_is_the_commanded_one(robot, harness):
    dut = make(robot, harness, np.zeros(robot.n_q))
    u = np.linspace(0.1, 0.5, robot.n_u)
    dut.command(u)
    np.testing.assert_array_equal(dut.u, u)


def test_the_hand_moves_at_its_speed_and_arrives(frankie, harness):
    """From 80 mm to 20 mm at 100 mm/s: 60 mm in the first 0.55 s or so."""
    dut = make(
        frankie, harness, np.r_[0, 0, 0, frankie.home], hand=(0.02, 10.0)
    )
    np.testing.assert_allclose(dut.eval("hand.state"), [0.08, -0.1, 0])
    dut.advance(0.2)
    np.testing.assert_allclose(dut.eval("hand.state"), [0.06, -0.1, 0])
    dut.advance(1.0)
    np.testing.assert_allclose(dut.eval("hand.state"), [0.02, 0, 0], atol=1e-5)


def test_each_hand_goes_where_it_is_told(two_pandas, harness):
    dut = make(two_pandas, harness, two_pandas.q_home)
    dut.fix("right_hand.command", [0.02, 10.0])
    np.testing.assert_allclose(dut.eval("right_hand.state"), [0.08, -0.1, 0])
    dut.advance(0.2)
    np.testing.assert_allclose(dut.eval("right_hand.state"), [0.06, -0.1, 0])
    np.testing.assert_allclose(dut.eval("left_hand.state"), [0.08, 0, 0])
    dut.fix("left_hand.command", [0.03, 10.0])
    dut.advance(1.0)
    for side, width in (("left", 0.03), ("right", 0.02)):
        reading = dut.eval(f"{side}_hand.state")
        np.testing.assert_allclose(reading, [width, 0, 0], atol=1e-5)
    np.testing.assert_allclose(dut.q, two_pandas.q_home)


def test_the_hand_stops_at_its_ends(frankie, harness):
    dut = make(frankie, harness, np.r_[0, 0, 0, frankie.home])
    dut.fix("hand.command", [1.0, 10.0])
    dut.advance(0.5)
    assert dut.eval("hand.state")[0] <= 0.08
    dut.fix("hand.command", [-1.0, 10.0])
    dut.advance(2.0)
    assert 0 <= dut.eval("hand.state")[0] < 1e-5


def test_without_a_hand_command_the_width_stays(frankie, harness):
    dut = make(frankie, harness, np.r_[0, 0, 0, frankie.home])
    dut.advance(0.5)
    np.testing.assert_array_equal(dut.eval("hand.state"), [0.08, 0, 0])


@pytest.mark.parametrize(
    ("port", "size"),
    [
        ("base.velocity_commanded", 2),
        ("panda.velocity_commanded", 7),
        ("hand.command", 2),
    ],
)
@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_one_bad_number_stops_the_robot(frankie, harness, port, size, bad):
    dut = make(frankie, harness, np.r_[0, 0, 0, frankie.home])
    dut.command(0.1 * frankie.velocity_limit)
    dut.fix("hand.command", [0.02, 10.0])
    dut.advance(0.1)
    assert dut.eval("status").mode == "running"
    q, (width, *_) = dut.q, dut.eval("hand.state")

    value = np.zeros(size)
    value[-1] = bad
    dut.fix(port, value)
    dut.advance(0.1)
    status = dut.eval("status")
    assert status.mode == "stopped"
    assert status.stop_reason == f"{port}: the command is not finite"
    np.testing.assert_array_equal(dut.q, q)
    np.testing.assert_array_equal(dut.u, np.zeros(9))
    np.testing.assert_array_equal(dut.eval("hand.state"), [width, 0, 0])

    dut.command(0.1 * frankie.velocity_limit)
    dut.fix("hand.command", [0.02, 10.0])
    dut.advance(0.1)
    assert dut.eval("status").mode == "running"
    assert (dut.q != q).any()
