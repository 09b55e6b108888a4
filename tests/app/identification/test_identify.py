"""What identification finds is what there was."""

import dataclasses as dc
import math
from pathlib import Path

import numpy as np
import pytest

from remosplat_drake.app.identification.excitation import (
    CRAWLS,
    Stroke,
    commands,
    find_stroke,
)
from remosplat_drake.app.identification.fit import Recording, fit_axis
from remosplat_drake.app.identification.record import (
    with_actuators,
    write_actuators,
)
from remosplat_drake.oracle.signed_distance import SignedDistanceField
from remosplat_drake.robot.actuators import Actuator, ActuatorModel
from remosplat_drake.robot.robot_description import load_robot_description
from remosplat_drake.scene.primitive_scene import PrimitiveScene

DT = 0.01


def recorded(robot, axis: int, truth: Actuator, speed: float, noise: float):
    """A recording of one axis that moves by a model; 37 Hz for the base."""
    u = commands(Stroke(axis, speed), robot, robot.velocity_limit, DT)
    sent = 1e9 + DT * np.arange(len(u))
    stamp = sent - 0.002
    if axis < robot.n_base:
        stamp = sent[0] + 0.027 * np.floor((sent - sent[0]) / 0.027)
    stamp = np.tile(stamp[:, None], robot.n_u)
    model = ActuatorModel.make([truth] * robot.n_u)
    zeros = np.zeros(robot.n_u)
    way, _ = model.response(sent, u, zeros + sent[0] - 1, zeros, stamp)
    q = np.zeros((len(u), robot.n_q))
    q[:, 3:] = way[:, 2:]
    q[:, 0], q[:, 2] = way[:, 0], way[:, 1]
    rng = np.random.default_rng(axis)
    same = np.append(False, np.diff(stamp[:, 0]) == 0)
    q += np.where(same[:, None], 0.0, noise * rng.uniform(-1, 1, q.shape))
    for k in np.flatnonzero(same):
        q[k] = q[k - 1]
    return Recording(sent, u, stamp, q)


@pytest.mark.parametrize(
    ("axis", "truth"),
    [
        (0, Actuator(delay=0.15)),
        (0, Actuator(delay=0.25, acceleration=0.6)),
        (1, Actuator(delay=0.1, time_constant=0.15)),
        (3, Actuator(delay=0.012, time_constant=0.083)),
        (8, Actuator(time_constant=0.2)),
        (4, Actuator(delay=0.03, dead_band=0.04)),
    ],
)
def test_delays_and_lags_are_found_within_milliseconds(frankie, axis, truth):
    speed = 0.5 * frankie.velocity_limit[axis]
    recording = recorded(frankie, axis, truth, speed, 2e-4)
    limit = frankie.velocity_limit[axis]
    fit = fit_axis(
        recording,
        axis,
        float(frankie.acceleration_limit[axis]),
        [share * limit for share in CRAWLS],
    )
    found = fit.actuator
    # A short lag and a dead time look alike: what counts is their sum.
    late = truth.delay + truth.time_constant
    assert found.delay + found.time_constant == pytest.approx(late, abs=0.005)
    if truth.acceleration is None:
        assert found.delay == pytest.approx(truth.delay, abs=0.008)
    else:
        assert found.acceleration == pytest.approx(truth.acceleration, rel=0.05)
    if truth.dead_band:
        # Between the crawl that moved nothing and the one that did.
        assert CRAWLS[0] * limit < found.dead_band <= 1.1 * CRAWLS[0] * limit
    assert found.tube < 0.006
    assert fit.residual < 0.004


def test_what_no_model_explains_widens_the_tube(frankie):
    truth = Actuator(delay=0.05)
    recording = recorded(frankie, 3, truth, 1.0, 0.0)
    slipped = recording.q.copy()
    slipped[:, 4] += 0.02 * np.sin(40 * recording.way[:, 3])
    spoilt = dc.replace(recording, q=slipped)
    tubes = [
        fit_axis(r, 3, 10.0, [0.02]).actuator.tube for r in (recording, spoilt)
    ]
    assert tubes[0] < 0.003
    assert tubes[1] > 0.02


def test_commands_stay_within_the_bounds_and_come_back(frankie):
    for axis in range(frankie.n_u):
        speed = frankie.velocity_limit[axis]
        u = commands(Stroke(axis, speed), frankie, frankie.velocity_limit, DT)
        change = np.abs(np.diff(u, axis=0)).max(axis=0)
        assert (change <= frankie.acceleration_limit * DT * (1 + 1e-9)).all()
        assert (np.abs(u).max(axis=0) <= frankie.velocity_limit).all()
        assert u[:, axis].sum() == pytest.approx(0.0, abs=1e-9)
        assert u[:, axis].max() == speed


def test_a_stroke_keeps_away_from_things(frankie, scene):
    q = np.array([0.0, 0, 0, *frankie.home])
    free = SignedDistanceField(PrimitiveScene())
    full = find_stroke(frankie, free, q, 0, frankie.velocity_limit, 0.1)
    assert full == Stroke(0, frankie.velocity_limit[0])
    # The table begins 0.7 m ahead: the base goes back first, or slowly.
    near = SignedDistanceField(scene)
    stroke = find_stroke(frankie, near, q, 0, frankie.velocity_limit, 0.1)
    assert stroke is None or stroke.speed < full.speed
    # The elbow cannot turn beyond its limit.
    q[6] = frankie.position_upper[6] - 0.05
    elbow = find_stroke(frankie, free, q, 5, frankie.velocity_limit, 0.1)
    assert elbow is None or elbow.speed < 0 or abs(elbow.speed) < 0.5


def test_a_description_keeps_everything_else(frankie, tmp_path):
    source = frankie.description.source
    text = Path(source).read_text()
    path = tmp_path / "frankie.yaml"
    path.write_text(text)
    axes = [Actuator(delay=0.15, acceleration=0.8, tube=0.01)] * 9
    kept = write_actuators(path, axes, list("abcdefghi"), "2026-11-22")
    assert kept.read_text() == text
    assert path.read_text().startswith(text)
    assert load_robot_description(path).actuators == axes
    # A second time takes the place of the first.
    again = with_actuators(path.read_text(), axes[:1], ["a"], "2026-11-23")
    assert again.count("actuators:") == 1
    assert again.startswith(text)
    assert math.isclose(again.count("- {delay"), 1)
