"""Predicted motion, and how well its model explains the measurements."""

import math

import numpy as np
import prediction_reference
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pydrake.common.value import Value
from pydrake.systems.analysis import Simulator

from remosplat_drake.controller.prediction.history import (
    History,
)
from remosplat_drake.controller.prediction.kernels.append_command import (
    append_command,
)
from remosplat_drake.controller.prediction.kernels.lead_forward import (
    lead_forward,
)
from remosplat_drake.controller.prediction.motion_predictor import (
    MotionPredictor,
)
from remosplat_drake.controller.prediction.predict import (
    modelled_way,
    predict,
)
from remosplat_drake.controller.prediction.station_ramp import StationRamp
from remosplat_drake.robot.actuators import Actuator, ActuatorModel
from remosplat_drake.robot.base_motion import base_way
from remosplat_drake.signals.station_status import StationStatus

DT = 0.01
LATE = [Actuator(delay=0.05, time_constant=0.1)] * 3


def model(axes, tube=0.0, noise=0.0) -> ActuatorModel:
    made = ActuatorModel.make(axes)
    return ActuatorModel(made.parameters, made.tube + tube, made.noise + noise)


def driven(axes: ActuatorModel, u: np.ndarray) -> History:
    """The history of one command a tick, from 0 s on."""
    history = History.at_rest(u.shape[1])
    for k, command in enumerate(u):
        history = history.with_command(axes, k * DT, command)
    return history


@settings(max_examples=60)
@given(st.integers(0, 10**6))
def test_kernels_say_what_their_reference_says(frankie, seed):
    rng = np.random.default_rng(seed)
    axes = model(
        [
            Actuator(
                delay=rng.uniform(0, 0.1),
                time_constant=rng.choice([0.0, rng.uniform(0, 0.1)]),
                dead_band=rng.choice([0.0, 0.01]),
            )
            for _ in range(9)
        ]
    )
    history = driven(axes, rng.normal(size=(rng.integers(1, 40), 9)))
    now = history.sent[-1] + rng.uniform(0, 0.02)
    stamp = now - rng.choice([0.0, 0.05, np.inf]) * rng.random(9)
    q = rng.normal(size=10)
    past = history.sent, history.u, history.v, history.way
    found = lead_forward(axes.parameters, past, q, stamp, now, 2)
    expected = prediction_reference.lead_forward(
        axes, history, q, stamp, now, 2
    )
    for ours, theirs in zip(found, expected, strict=True):
        np.testing.assert_array_equal(ours, theirs)
    u, span = rng.normal(size=9), rng.uniform(0, 0.5)
    rows = append_command(
        axes.parameters, (*past, history.drift), now + 0.01, u, span
    )
    expected = prediction_reference.append_command(
        axes, history, now + 0.01, u, span
    )
    for ours, theirs in zip(rows, expected, strict=True):
        np.testing.assert_array_equal(ours, theirs)


def test_without_delays_nothing_is_predicted(three_link):
    axes = model([Actuator()] * 3)
    history = driven(axes, np.full((5, 3), 0.7))
    q = np.array([0.1, -0.2, 0.3])
    motion = predict(three_link, axes, history, q, np.full(3, 0.05), 0.05)
    assert motion.q_start.tolist() == motion.q_planned.tolist() == q.tolist()
    assert motion.start == 0.05


def test_an_old_measurement_is_led_along_the_commands(three_link):
    axes = model([Actuator()] * 3)
    history = driven(axes, np.linspace(0.1, 0.5, 5)[:, None] * np.ones(3))
    stamp = np.array([0.0, 0.02, 0.05])
    motion = predict(three_link, axes, history, np.zeros(3), stamp, 0.05)
    # 0.1 to 0.5 rad/s for 10 ms each: all of it, the last three, none.
    np.testing.assert_allclose(motion.q_start, [0.015, 0.012, 0.0])


@settings(max_examples=30)
@given(st.integers(0, 99))
def test_by_the_next_command_the_plan_moves_as_without_delays(three_link, seed):
    axes = model(LATE)
    u = np.random.default_rng(seed).uniform(-1, 1, (30, 3))
    planned = []
    for k in (20, 21):
        history = driven(axes, u[:k])
        now = np.full(3, k * DT)
        q = modelled_way(axes, history, now)
        planned.append(
            predict(three_link, axes, history, q, now, k * DT).q_planned
        )
    np.testing.assert_allclose(planned[1] - planned[0], DT * u[20], atol=1e-9)


def test_a_base_is_led_along_its_arc(frankie):
    axes = model([Actuator(delay=0.2)] * 9)
    u = np.zeros((30, 9))
    u[:, :2] = 0.5, 0.8
    history = driven(axes, u)
    q = np.zeros(10)
    motion = predict(frankie, axes, history, q, np.full(9, 0.3), 0.3)
    # At 0.5 s the commands of 0.3 s have come to act.
    np.testing.assert_allclose(
        motion.q_planned, frankie.advance(q, u[0], 0.2), atol=1e-9
    )


@pytest.mark.parametrize(
    ("acceleration", "way"),
    # One step of a tenth of a second; or two, the first of which moves on.
    [(10.0, 0.15), (5.0, 0.15 + 0.5 * 0.1)],
)
def test_a_station_brakes_where_no_command_comes(acceleration, way):
    axes = model([Actuator()] * 3)
    history = driven(axes, np.ones((1, 3)))
    ramp = StationRamp(np.full(3, acceleration), 0.1)
    after = history.with_command(axes, 1.0, np.zeros(3), ramp)
    np.testing.assert_allclose(after.way[-1], way)
    # A command in time finds it as it was sent.
    in_time = history.with_command(axes, 0.14, np.zeros(3), ramp)
    np.testing.assert_allclose(in_time.way[-1], 0.14)
    assert len(in_time.sent) == len(history.sent) + 1


def test_an_exact_model_leaves_no_residual(three_link):
    axes = model(LATE, tube=0.1)
    u = np.sin(np.arange(200) / 9)[:, None] * np.ones(3)
    history = History.at_rest(3)
    for k, command in enumerate(u):
        q = modelled_way(axes, history, np.full(3, k * DT)) + 0.4
        now = np.full(3, k * DT)
        history = history.with_measurement(
            q, modelled_way(axes, history, now), 0
        )
        history = history.with_command(axes, k * DT, command)
    assert history.residual(2.0).max() < 1e-12
    np.testing.assert_allclose(history.peak(), 1.0, atol=0.01)


def test_a_robot_that_stands_where_it_should_move_is_noticed(three_link):
    axes = model([Actuator(tube=0.02, noise=0.001)] * 3)
    history = History.at_rest(3)
    for k in range(100):
        way = modelled_way(axes, history, np.full(3, k * DT))
        history = history.with_measurement(np.zeros(3), way, 0)
        history = history.with_command(axes, k * DT, np.full(3, 0.05))
        motion = predict(
            three_link, axes, history, np.zeros(3), np.full(3, k * DT), k * DT
        )
        if (motion.residual > motion.bound).any():
            break
    # 0.05 rad/s leave 0.02 s * 0.05 rad/s + 1 mrad after 40 ms.
    assert k * DT == pytest.approx(0.05, abs=0.011)


def test_at_rest_the_tube_is_the_noise(three_link):
    axes = model(LATE, tube=0.1, noise=0.002)
    motion = predict(
        three_link, axes, History.at_rest(3), np.zeros(3), np.zeros(3), 0.0
    )
    assert motion.bound.tolist() == [0.002] * 3


def test_a_bases_way_is_measured_along_its_heading(frankie):
    u = np.array([0.3, -0.5, *np.zeros(7)])
    before = np.array([1.0, 2.0, 3.1, *np.zeros(7)])
    after = frankie.advance(before, u, 0.1)
    after[2] = math.remainder(after[2], math.tau)
    np.testing.assert_allclose(
        base_way(before[:3], after[:3], 2), 0.1 * u[:2], rtol=1e-9
    )


def test_commands_count_from_when_they_were_sent(three_link):
    """And the next one is expected as long after its tick as the latest."""
    period, late, u = 0.1, 0.02, np.array([1.0, 0.5, 0.0])
    predictor = MotionPredictor(
        robot=three_link, model=model([Actuator()] * 3), period=period
    )
    simulator = Simulator(predictor)
    context = simulator.get_mutable_context()

    def fix(**values) -> None:
        for name, value in values.items():
            predictor.GetInputPort(name).FixValue(context, value)

    fix(velocity_executed=u, status=Value(StationStatus()))
    for k in range(60):
        # As is measured at a tick; each command was sent late.
        q = u * max(k * period - late, 0.0)
        sent = (k - 1) * period + late if k else -math.inf
        fix(configuration=q, odometry=q)
        fix(status=Value(StationStatus(sent=sent)))
        simulator.AdvanceTo(k * period)
        motion = predictor.GetOutputPort("motion").Eval(context)
        simulator.AdvancePendingEvents()
    np.testing.assert_allclose(motion.residual, 0.0, atol=1e-9)
    np.testing.assert_allclose(np.diff(motion.sent[1:]), period)
    assert motion.sent[-1] == pytest.approx(58 * period + late)
    assert motion.time == pytest.approx(context.get_time() + late, abs=1e-3)
