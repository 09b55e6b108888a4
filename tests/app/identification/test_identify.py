"""Identification finds the actuators that there were."""

import dataclasses as dc
import math
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from effort import effort
from runs import complaint
from wire_messages import arm_message

from remosplat_drake.app.identification.excitation import (
    CRAWLS,
    Stroke,
    commands,
    find_stroke,
)
from remosplat_drake.app.identification.fit import Recording, fit_axis
from remosplat_drake.app.identification.reading import Reading, robot_stop
from remosplat_drake.app.identification.record import (
    with_actuators,
    write_actuators,
)
from remosplat_drake.app.identification.room import NoRoomError, Room
from remosplat_drake.base.resources import models_dir
from remosplat_drake.controller.verification.kernels.between_samples import (
    TOLERANCE,
)
from remosplat_drake.controller.verification.self_sweep import SelfClearance
from remosplat_drake.hardware.client.measurement import (
    Measurement,
    with_arm_status,
)
from remosplat_drake.hardware.hardware_config import HardwareConfig
from remosplat_drake.hardware.stand_in.simulated_arm import RobotMode
from remosplat_drake.oracle.signed_distance import SignedDistanceField
from remosplat_drake.robot.actuators import Actuator, ActuatorModel
from remosplat_drake.robot.robot_description import load_robot_description
from remosplat_drake.robot.robot_model import load_robot
from remosplat_drake.scene.primitive_scene import PrimitiveScene

DT = 0.01
HEADING = 1.0
"""Yaw with which a base starts [rad]."""


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
    q[:, 3:] = way[:, robot.n_base :]
    # One axis moves: a base turns on the spot, or keeps its heading.
    c, s = math.cos(HEADING), math.sin(HEADING)
    forward, left = way[:, 0], way[:, 1] if robot.n_base == 3 else 0.0
    q[:, 0], q[:, 1] = c * forward - s * left, s * forward + c * left
    q[:, 2] = HEADING + way[:, robot.n_base - 1]
    rng = np.random.default_rng(axis)
    same = np.append(False, np.diff(stamp[:, 0]) == 0)
    q += np.where(same[:, None], 0.0, noise * rng.uniform(-1, 1, q.shape))
    for k in np.flatnonzero(same):
        q[k] = q[k - 1]
    return Recording(sent, u, stamp, q, robot.n_base)


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


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_the_axes_of_an_omnidirectional_base_are_told_apart(axis):
    robot = load_robot("ridgeback_panda")
    assert robot.n_base == 3
    speed = 0.5 * float(robot.velocity_limit[axis])
    truth = Actuator(delay=0.15)
    recording = recorded(robot, axis, truth, speed, 2e-4)
    for other in {0, 1, 2} - {axis}:
        assert np.ptp(recording.way[:, other]) < 0.01
    found = fit_axis(recording, axis, 1.0, [0.02]).actuator
    late = found.delay + found.time_constant
    assert late == pytest.approx(truth.delay, abs=0.005)
    # The base's localisation corrects it as it goes.
    assert found.noise >= 0.02


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


def make_room(robot, scene: PrimitiveScene) -> Room:
    own = SelfClearance.make(robot, 0.01)
    return Room(SignedDistanceField(scene), own, 0.1, DT)


def test_a_stroke_keeps_away_from_things(frankie, scene):
    q = np.array([0.0, 0, 0, *frankie.home])
    limit = frankie.velocity_limit
    free = make_room(frankie, PrimitiveScene())
    full = find_stroke(free, q, 0, limit)
    assert full == Stroke(0, frankie.velocity_limit[0])
    # The table begins 0.7 m ahead: farther away the base goes slowly, or back.
    near = make_room(frankie, scene)
    q[0] = -0.15
    assert find_stroke(near, q, 0, limit).speed < full.speed
    q[0] = 0.0
    with pytest.raises(NoRoomError, match="collision"):
        find_stroke(near, q, 0, limit)
    # The elbow cannot turn beyond its limit.
    q[6] = frankie.position_upper[6] - 0.15
    assert find_stroke(free, q, 5, limit).speed < 0.5
    q[6] = frankie.position_upper[6] - 0.05
    with pytest.raises(NoRoomError, match="joint limit"):
        find_stroke(free, q, 5, limit)


def test_where_it_must_not_start_an_axis_stands(frankie, scene):
    q = np.array([0.1, 0, 0, *frankie.home])
    limit = frankie.velocity_limit
    with pytest.raises(
        NoRoomError, match="mm away, nearer than the required 100 mm"
    ):
        find_stroke(make_room(frankie, scene), q, 0, limit)
    free = make_room(frankie, PrimitiveScene())
    q[4], q[6] = 1.7, -3.0
    with pytest.raises(NoRoomError, match="too near to each other"):
        find_stroke(free, q, 3, limit)
    q[0] = np.nan
    with pytest.raises(NoRoomError, match="is unknown"):
        find_stroke(free, q, 0, limit)


def clear_poses(room: Room, n: int) -> Iterator[np.ndarray]:
    """Random poses that keep the distances of a room."""
    robot, rng = room.own.robot, np.random.default_rng(0)
    arm = slice(3, None)
    while n:
        q = np.zeros(robot.n_q)
        q[arm] = rng.uniform(
            robot.position_lower[arm], robot.position_upper[arm]
        )
        if not room.problem(q):
            yield q
            n -= 1


def test_no_stroke_enters_the_robot(frankie):
    room = make_room(frankie, PrimitiveScene().with_floor())
    limit, stopping = frankie.velocity_limit, room.own.stopping
    offered = refused = 0
    for q in clear_poses(room, effort(12, 40)):
        for axis in range(frankie.n_base, frankie.n_u):
            try:
                stroke = find_stroke(room, q, axis, limit)
            except NoRoomError:
                refused += 1
                continue
            offered += 1
            forth, back = stroke.ends(frankie.acceleration_limit)
            way = DT * commands(stroke, frankie, limit, DT)[:, axis].cumsum()
            # A late stop is within the ends, too.
            assert min(forth, back) <= way.min() and way.max() <= max(
                forth, back
            )
            step = np.eye(frankie.n_u)[axis]
            ways = np.linspace(back, forth, 400)
            for q_then in frankie.advance_for(q, step, ways):
                apart = room.own.distances(q_then, stopping).min()
                assert apart >= stopping - TOLERANCE
    assert offered > 5 * refused


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


@pytest.mark.parametrize(
    ("flags", "said"),
    [
        (("--fraction", "2"), "--fraction: must be at most 1"),
        (("--clearance", "-1"), "--clearance: -1 is not a number > 0"),
    ],
)
def test_a_flag_that_would_take_a_bound_away_is_refused(capsys, flags, said):
    assert said in complaint(capsys, "identify", "TableReach", *flags)


def test_a_robot_that_nothing_is_known_of_is_not_moved(
    capsys, tmp_path, monkeypatch
):
    """A real robot needs its doctor's report, and every one a known map."""
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path))
    url = "udpm://239.255.76.67:7667?ttl=0"
    said = complaint(capsys, "identify", "TableReach", "--lcm-url", url)
    assert "remosplat doctor" in said
    assert "no robot is selected" in complaint(capsys, "identify", "TableReach")
    scene = models_dir() / "scenes" / "table" / "splat.ply"
    (tmp_path / "splat.ply").write_bytes(scene.read_bytes())
    scenario = tmp_path / "table.yaml"
    scenario.write_text("Table: {scene: {splat: splat.ply}}\n")
    said = complaint(capsys, "identify", str(scenario), "--rehearsal")
    assert "--accept unknown-map-error" in said


@pytest.mark.parametrize(
    ("mode", "reason"),
    [
        (RobotMode.MOVE, ""),
        (RobotMode.OTHER, "the arm's mode is other"),
        (RobotMode.USER_STOPPED, "the arm is in mode user_stopped"),
    ],
)
def test_an_arm_that_does_not_obey_is_not_measured(mode, reason):
    panda, now = load_robot("panda"), time.time()
    config = HardwareConfig(arm_status_expiry=1.0, frozen_after=1.0)
    status = arm_message(utime=round(1e6 * now), robot_mode=mode)
    told = with_arm_status(Measurement(), status, now, 7, config)
    reading = Reading(told, np.full(7, now), panda.q_home, panda.q_home)
    assert robot_stop(reading, panda, config) == reason
