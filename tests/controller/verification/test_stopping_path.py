"""The path of a robot that does not obey at once."""

import dataclasses as dc
import math

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from verified_commands import (
    Around,
    at,
    knots,
    make_path,
    spans,
    tube_of,
    verified_command,
)
from verify_reference import least_margins

from remosplat_drake.base.kernels.packed import Packed
from remosplat_drake.controller.prediction.history import History
from remosplat_drake.controller.prediction.predict import predict
from remosplat_drake.generation.scene_generators import generate
from remosplat_drake.oracle.signed_distance import SignedDistanceField
from remosplat_drake.robot.actuators import Actuator, ActuatorModel
from remosplat_drake.robot.braking import (
    braking_command,
    braking_steps,
)

DT = 0.02
LIMIT = np.full(3, 5.0)
AXES = [
    Actuator(delay=0.05, time_constant=0.1),
    Actuator(delay=0.01, time_constant=0.03),
    Actuator(delay=0.03, acceleration=4.0),
]


def motion_of(robot, axes, commands, q):
    """The motion of a robot at q after one command a tick."""
    model = ActuatorModel.make(axes)
    history = History.at_rest(robot.n_u)
    for k, u in enumerate(commands):
        history = history.with_command(model, k * DT, u)
    now = len(commands) * DT
    stamp = np.full(robot.n_u, now)
    return predict(robot, model, history, q, stamp, now)


def limited(robot):
    values = robot.arrays.values
    return Packed(values._replace(acceleration_limit=LIMIT))


def through(robot, motion, u):
    """The path of a command that actuators delay and lag behind."""
    return make_path(limited(robot), motion.q_start, u, DT, motion)


def reference(robot, motion, u, limit, dt, ends):
    """What `late_path` computes, in the words of `ActuatorModel.response`."""
    steps = max(braking_steps(u, limit, dt), 1.0)
    k = np.arange(math.ceil(steps) + 1)
    shares = np.maximum(1.0 - k / steps, 0.0)
    way, v = motion.model.response(
        np.concatenate([motion.sent, motion.time + k * dt]),
        np.concatenate([motion.u, shares[:, None] * u]),
        np.full(robot.n_u, motion.start),
        motion.v_start,
        np.repeat(motion.start + ends[:, None], robot.n_u, axis=1),
    )
    way = np.concatenate([way, way[-1:] + motion.model.lag * v[-1]])
    ways = np.diff(way, axis=0, prepend=0.0)
    q = [motion.q_start]
    for piece in ways:
        q.append(robot.advance(q[-1], piece, 1.0))
    return np.array(q), ways


@settings(max_examples=30)
@given(st.integers(0, 999))
def test_the_kernel_makes_the_path_that_the_model_says(three_link, seed):
    rng = np.random.default_rng(seed)
    commands = list(rng.uniform(-1, 1, (8, 3)))
    u = rng.uniform(-1, 1, 3) * (seed > 0)
    motion = motion_of(three_link, AXES, commands, rng.uniform(-1, 1, 3))
    path = through(three_link, motion, u)
    q, ways = reference(three_link, motion, u, LIMIT, DT, path.times[:-1])
    np.testing.assert_allclose(knots(path), q, atol=1e-12)
    np.testing.assert_allclose(
        path.rates * spans(path)[:, None], ways, atol=1e-12
    )


def test_without_delays_it_is_the_path_of_a_held_command(three_link):
    u, q = np.array([1.0, -0.5, 0.7]), np.array([0.2, 0.1, -0.4])
    motion = motion_of(three_link, [Actuator()] * 3, [u], q)
    path = through(three_link, motion, u)
    held = make_path(limited(three_link), q, u, DT)
    np.testing.assert_allclose(
        knots(path)[-1], at(held, held.times[-2:-1])[0], atol=1e-12
    )
    # Samples are at the same places, though not at the same times.
    times = held.times[:-1]
    np.testing.assert_allclose(
        at(path, path.times)[: len(times)], at(held, times), atol=1e-12
    )


@settings(max_examples=30)
@given(st.integers(0, 999))
def test_braking_follows_the_path_that_was_checked(three_link, seed):
    rng = np.random.default_rng(seed)
    commands = list(np.cumsum(rng.uniform(-0.1, 0.1, (8, 3)), axis=0))
    q, u = np.zeros(3), commands[-1]
    motion = motion_of(three_link, AXES, commands, q)
    path = through(three_link, motion, u)
    # A tick later the ramp's first step is sent, from where the path then is.
    model = motion.model
    way, v = model.response(
        np.append(motion.sent, motion.time),
        np.vstack([motion.u, u]),
        np.full(3, motion.start),
        motion.v_start,
        np.full((1, 3), motion.start + DT),
    )
    later = dc.replace(
        motion,
        time=motion.time + DT,
        sent=np.append(motion.sent, motion.time),
        u=np.vstack([motion.u, u]),
        start=motion.start + DT,
        q_start=motion.q_start + way[0],
        v_start=v[0],
    )
    ramp = braking_command(u, LIMIT, DT)
    rest = through(three_link, later, ramp)
    np.testing.assert_allclose(knots(rest)[-1], knots(path)[-1], atol=1e-9)
    told = rest.times[rest.times < 0.4]
    np.testing.assert_allclose(at(rest, told), at(path, told + DT), atol=2e-3)


def test_the_tube_widens_with_the_speed_and_is_zero_at_rest(three_link):
    axes = [dc.replace(axis, tube=0.02) for axis in AXES]
    tubes = []
    for speed in (0.0, 0.5, 1.0):
        u = np.full(3, speed)
        motion = motion_of(three_link, axes, [np.zeros(3)], np.zeros(3))
        path = through(three_link, motion, u)
        tubes.append(tube_of(three_link, path))
    assert not tubes[0].any()
    np.testing.assert_allclose(tubes[2], 2 * tubes[1])
    assert (tubes[1] > 0).all()


@settings(max_examples=15)
@given(st.integers(0, 999))
def test_what_passes_keeps_its_distances_on_the_whole_path(frankie, seed):
    rng = np.random.default_rng(seed)
    scene = generate("bookshelf", seed % 5)
    field = SignedDistanceField(scene)
    q = np.array([*scene.X_WB_start, *frankie.home])
    q[0] += rng.uniform(0.0, 0.5)
    axes = [Actuator(delay=0.1, tube=0.01)] * 2 + [
        Actuator(delay=0.01, time_constant=0.1, tube=0.01)
    ] * 7
    u = rng.uniform(-0.6, 0.6, 9) * frankie.velocity_limit
    motion = motion_of(frankie, axes, [0.5 * u, 0.6 * u, 0.7 * u], q)
    state = frankie.state(motion.q_planned)
    near = field.clearances(state.spheres).per_sphere(len(state.spheres))
    limit = frankie.acceleration_limit
    around = Around(frankie, field, state, near, 0.02, DT, limit, motion=motion)
    command, scale, _ = verified_command(around, u, 0.7 * u)
    if scale:
        exact = field.clearances(frankie.spheres_at(motion.q_start))
        known = dc.replace(around, clearance=exact.per_sphere(len(near)))
        ends, between = least_margins(known, command, samples=5)
        assert ends >= -1e-9
        assert between >= -1e-9
