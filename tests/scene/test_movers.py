"""Possible positions of movers, against motions that keep their bounds."""

import dataclasses as dc
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pydrake.math import RigidTransform, RotationMatrix
from scipy.spatial.transform import Rotation

from remosplat_drake.base.errors import FieldError
from remosplat_drake.scene.kernels.mover_reach import (
    is_retreat,
    moved_on,
    near_movers,
    reach,
)
from remosplat_drake.scene.mover import MOST, Mover, Movers

seeds = st.integers(0, 2**32 - 1)


def draw_mover(rng, **bounds) -> Mover:
    """A sphere, a capsule or a box that moves and turns."""
    kind = rng.integers(3)
    half_extents = (
        rng.uniform(0.02, 0.4, 3)
        * [
            [0, 0, 0],
            [0, 0, 1],
            [1, 1, 1],
        ][kind]
    )
    X_WM = RigidTransform(
        RotationMatrix(Rotation.random(rng=rng).as_matrix()),
        rng.uniform(-1, 1, 3),
    )
    radius = 0.0 if kind == 2 else rng.uniform(0.02, 0.2)
    v_WM, w_WM = rng.uniform(-1, 1, (2, 3))
    return Mover("it", X_WM, half_extents, radius, v_WM, w_WM, **bounds)


def core_distance(mover: Mover, X_WM: RigidTransform, p_W) -> float:
    """How far a point is from the core; inside, minus its depth."""
    p_M = X_WM.inverse().multiply(np.array(p_W, float))
    apart = np.abs(p_M) - mover.half_extents
    outside = np.linalg.norm(np.maximum(apart, 0.0))
    return outside if outside > 0.0 else apart.max()


def predicted(mover: Mover, t: float) -> RigidTransform:
    turned = Rotation.from_rotvec(mover.w_WM * t).as_matrix()
    return RigidTransform(
        RotationMatrix(turned) @ mover.X_WM.rotation(),
        mover.X_WM.translation() + mover.v_WM * t,
    )


@given(seed=seeds, time=st.floats(0.0, 1.0))
@settings(max_examples=60)
def test_a_motion_within_its_bounds_stays_within_reach(seed, time):
    """It starts as measured, within errors, and then does as it likes."""
    rng = np.random.default_rng(seed)
    mover = draw_mover(rng)
    far = np.linalg.norm(mover.half_extents)
    turn = np.linalg.norm(mover.w_WM)
    velocity_error, position_error = rng.uniform(0, 0.3, 2)
    spin, push = rng.uniform(0, 2, 2)
    fastest_turn = turn + spin
    mover = Mover(
        "it",
        mover.X_WM,
        mover.half_extents,
        mover.radius,
        mover.v_WM,
        mover.w_WM,
        max_acceleration=push + (spin + fastest_turn**2) * far,
        max_speed=math.sqrt(3) + velocity_error + push + fastest_turn * far,
        velocity_error=velocity_error,
        position_error=position_error,
    )
    error = rng.normal(size=(2, 3))
    error /= np.linalg.norm(error, axis=1)[:, None]
    p = mover.X_WM.translation() + position_error * error[0]
    v = mover.v_WM + velocity_error * error[1]
    axis = mover.w_WM / turn
    a = push * error[rng.integers(2)]
    sense = rng.choice([-1.0, 1.0])
    angle = turn * time + 0.5 * sense * spin * time**2
    R = RotationMatrix(Rotation.from_rotvec(axis * angle).as_matrix())
    X_true = RigidTransform(
        R @ mover.X_WM.rotation(), p + v * time + 0.5 * a * time**2
    )
    bound = compiled_reach(Movers(0.0, [mover]), time)
    X_said = predicted(mover, time)
    for corner in np.array(np.meshgrid(*[[-1, 1]] * 3)).reshape(3, -1).T:
        p_M = corner * mover.half_extents
        off = X_true.multiply(p_M) - X_said.multiply(p_M)
        assert np.linalg.norm(off) <= bound + 1e-9


@given(seed=seeds, time=st.floats(0.0, 2.0))
@settings(max_examples=30)
def test_a_prediction_keeps_the_twist(seed, time):
    mover = draw_mover(np.random.default_rng(seed))
    assert mover.after(time).IsNearlyEqualTo(predicted(mover, time), 1e-9)


@given(seed=seeds)
@settings(max_examples=100)
def test_what_a_newer_measurement_allows_was_allowed_before(seed):
    """What can be reached at the next tick has been verified at this one.

    A measurement is admissible if what it says, with its errors, could be as
    far as was known: in place, and in velocity. All that it lets a mover do
    was then known to be possible. This holds as long as a bound on the
    acceleration is what bounds its way; a bound on its speed alone, as soon as
    that is what counts, is a bound on the truth, not on what is measured.
    """
    rng = np.random.default_rng(seed)
    speed, push = rng.uniform(0.5, 3.0), rng.uniform(0.5, 10.0)
    first, later, end = np.cumsum(rng.uniform(0.0, 0.3, 3))
    e_p, e_v = rng.uniform(0.0, 0.05), rng.uniform(0.0, 0.2)
    bounds = {"max_speed": speed, "max_acceleration": push}
    known = draw_ball(rng, first, e_p, e_v, bounds)
    passed = later - first
    far = reach(known.at(later), 0, 0.0)
    fast = e_v + push * passed
    # A part of what may be is the error that remains.
    e_q, e_w = rng.uniform(0.0, far), rng.uniform(0.0, fast)
    ball = known.movers[0]
    newer = Mover.sphere(
        "it",
        ball.after(passed).translation() + (far - e_q) * unit(rng),
        ball.radius,
        v_WM=ball.v_WM + (fast - e_w) * unit(rng),
        velocity_error=e_w,
        position_error=e_q,
        **bounds,
    )
    news = Movers(later, [newer])
    if e_v + 0.5 * push * (end - first) > speed + ball.speed:
        return
    apart = newer.after(end - later).translation()
    apart = np.linalg.norm(apart - ball.after(end - first).translation())
    then = reach(news.at(end), 0, 0.0)
    assert apart + then <= reach(known.at(end), 0, 0.0) + 1e-9


def draw_ball(rng, stamp, position_error, velocity_error, bounds) -> Movers:
    v_WM = rng.uniform(0.0, bounds["max_speed"]) * unit(rng)
    ball = Mover.sphere(
        "it",
        rng.uniform(-1, 1, 3),
        0.1,
        v_WM=v_WM,
        velocity_error=velocity_error,
        position_error=position_error,
        **bounds,
    )
    return Movers(stamp, [ball])


def unit(rng) -> np.ndarray:
    direction = rng.normal(size=3)
    return direction / np.linalg.norm(direction)


@given(seed=seeds, time=st.floats(0.0, 3.0))
@settings(max_examples=30)
def test_kernels_move_them_on_as_they_would_be_seen_later(seed, time):
    """With their twists for two seconds, and at rest afterwards."""
    rng = np.random.default_rng(seed)
    movers = Movers(0.0, [draw_mover(rng) for _ in range(3)])
    ours = moved_on(movers.at(0.1), time, 2.0)
    theirs = movers.moved_on(time, 2.0).at(0.1)
    for one, other in zip(ours, theirs, strict=True):
        np.testing.assert_allclose(one, other, atol=1e-9)
    p_WS, radius = rng.uniform(-2, 2, (4, 3)), np.full(4, 0.1)
    if time < 2.0:  # As what is measured then, at the same age.
        there = Movers(
            time, [dc.replace(m, X_WM=m.after(time)) for m in movers]
        )
        for one, other in zip(
            near_movers(ours, p_WS, radius, np.inf, 0.0),
            near_movers(there.at(time + 0.1), p_WS, radius, np.inf, 0.0),
            strict=True,
        ):
            np.testing.assert_allclose(one, other, atol=1e-9)
    assert ours.v_WM.any() == (time <= 2.0)


def compiled_reach(movers: Movers, time: float) -> float:
    """`reach` as kernels use it: what the distance of a far point lacks."""
    mover = movers.movers[0]
    p_W = np.array([[50.0, 0.0, 0.0]])
    _, _, distance, _, _ = near_movers(
        movers.at(time), p_W, np.zeros(1), np.inf, 0.0
    )
    return (
        core_distance(mover, predicted(mover, time), p_W[0])
        - mover.radius
        - float(distance[0])
    )


def test_reach_by_hand():
    bounds = {"max_speed": 2.0, "max_acceleration": 5.0}
    movers = Movers(1.0, [Mover.sphere("it", [0, 0, 0], 0.1, **bounds)])
    assert reach(movers.at(1.0), 0, 0.0) == 0.0
    assert reach(movers.at(1.0), 0, 0.2) == pytest.approx(0.1)  # 5 / 2 x 0.04
    assert reach(movers.at(1.1), 0, 0.1) == pytest.approx(0.1)  # its age counts
    assert reach(movers.at(1.0), 0, 2.0) == pytest.approx(4.0)  # 2 m/s
    assert reach(movers.at(0.8), 0, 0.0) == pytest.approx(0.1)  # the future


@given(seed=seeds)
@settings(max_examples=60)
def test_distances_and_closing_speeds_are_those_of_the_prediction(seed):
    rng = np.random.default_rng(seed)
    none = {"max_acceleration": 0.0, "max_speed": 0.0}
    mover = draw_mover(rng, **none)
    # Turning alone may bend: the prediction itself is looked at here.
    movers = Movers(0.0, [mover])
    p_WS, radius = rng.uniform(-2, 2, (8, 3)), rng.uniform(0, 0.1, 8)
    sphere, which, distance, n, closing = near_movers(
        movers.at(0.0), p_WS, radius, np.inf, 0.0
    )
    np.testing.assert_array_equal(sphere, np.arange(8))
    assert not which.any()
    h = 1e-6
    for i in range(8):
        now, then = (
            core_distance(mover, predicted(mover, t), p_WS[i]) for t in (0, h)
        )
        expected = now - mover.radius - radius[i]
        assert distance[i] == pytest.approx(expected, abs=1e-9)
        assert closing[i] == pytest.approx((now - then) / h, abs=1e-4)
        moved = core_distance(mover, mover.X_WM, p_WS[i] + h * n[i])
        assert moved - now == pytest.approx(-h, abs=1e-9)


def test_what_is_far_is_left_out():
    movers = Movers(
        0.0,
        [
            Mover.sphere("near", [1, 0, 0], 0.1),
            Mover.sphere("far", [3, 0, 0], 0.1),
        ],
    )
    sphere, which, distance, n, _ = near_movers(
        movers.at(0.0), np.zeros((1, 3)), np.full(1, 0.2), 1.0, 0.0
    )
    assert sphere.tolist() == which.tolist() == [0]
    np.testing.assert_allclose(distance, [0.7])
    np.testing.assert_allclose(n, [[1, 0, 0]], atol=1e-12)


@given(seed=seeds, within=st.floats(-0.5, 3.0))
@settings(max_examples=100)
def test_what_is_left_out_early_is_beyond(seed, within):
    rng = np.random.default_rng(seed)
    movers = Movers(0.0, [draw_mover(rng) for _ in range(4)]).at(0.1)
    p_WS, radius = rng.uniform(-3, 3, (20, 3)), rng.uniform(0, 0.1, 20)
    found = near_movers(movers, p_WS, radius, within, 0.0)
    everything = near_movers(movers, p_WS, radius, np.inf, 0.0)
    near = everything.distance < within
    for some, whole in zip(found, everything, strict=True):
        np.testing.assert_array_equal(some, whole[near])


@given(
    seed=seeds,
    depth=st.floats(0.001, 0.3),
    touching=st.floats(0.01, 0.3),
    ahead=st.floats(-1, 1),
    aside=st.floats(0, 1),
)
@settings(max_examples=200)
def test_a_retreat_leads_away_from_all_that_can_touch(
    seed, depth, touching, ahead, aside
):
    """Points of the core are beyond `depth` along n, and within `touching`."""
    if not is_retreat(depth, touching, ahead, aside):
        return
    rng = np.random.default_rng(seed)
    points = rng.uniform(-touching, touching, (200, 3))
    points[:, 2] = rng.uniform(depth, max(depth, touching), 200)
    points = points[np.linalg.norm(points, axis=1) <= touching]
    turn = rng.uniform(0, 2 * np.pi)
    motion = [aside * np.cos(turn), aside * np.sin(turn), ahead]
    assert (points @ motion <= 1e-12).all()


def test_what_is_no_retreat():
    assert is_retreat(0.1, 0.2, -1.0, 0.0)
    assert not is_retreat(0.1, 0.2, 0.1, 0.0)  # towards it
    assert not is_retreat(0.1, 0.2, -1.0, 1.0)  # too much aside
    assert not is_retreat(-0.1, 0.2, -1.0, 0.0)  # within it: whither?


@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("radius", -0.1),
        ("radius", math.nan),
        ("half_extents", [0.1, -0.1, 0.1]),
        ("v_WM", [0, math.inf, 0]),
        ("w_WM", [0, 0]),
        ("max_speed", math.inf),
        ("max_acceleration", -1.0),
        ("velocity_error", -1.0),
        ("position_error", math.nan),
    ],
)
def test_bad_values_are_named(field, value):
    good = {"half_extents": np.zeros(3), "radius": 0.1}
    with pytest.raises(FieldError, match=f"mover 'arm': {field}: must be"):
        Mover("arm", RigidTransform(), **{**good, field: value})


def test_bad_sets_are_named():
    with pytest.raises(FieldError, match="movers: stamp: must be finite"):
        Movers(math.nan)
    one = Mover.sphere("it", [0, 0, 0], 0.1)
    with pytest.raises(FieldError, match=f"number: must be at most {MOST}"):
        Movers(0.0, [one] * (MOST + 1))
    assert len(Movers(0.0).at(1.0).radius) == 0
