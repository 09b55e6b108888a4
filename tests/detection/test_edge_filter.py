"""Velocities by the motion of outlines."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from remosplat_drake.detection.edge_filter import Edges, outline

FRAME, PUSH, FAST, NOISE = 1 / 30, 5.0, 2.0, 0.008


def watched(rng, lower, upper, count, share=(1.0, 1.0)) -> Edges:
    """Follows faces that move with `lower` and `upper`, functions of time."""
    edges = None
    for i in range(count):
        t = i * FRAME
        place = np.array([lower(t), upper(t)])
        place = place + NOISE * rng.standard_normal((2, 3))
        if edges is None:
            edges = Edges.first(place, NOISE, FAST, t)
        else:
            edges = edges.after(t, PUSH).seen(place, NOISE, FAST)
    assert edges is not None
    return edges


@given(seed=st.integers(0, 2**32 - 1))
@settings(max_examples=40)
def test_a_thing_that_swings_within_its_bounds_is_within_the_error(seed):
    rng = np.random.default_rng(seed)
    rate = rng.uniform(0.5, 4.0)
    size = min(FAST / rate, PUSH / rate**2) * rng.uniform(0.2, 0.95)
    axis = rng.normal(size=3)
    axis /= np.linalg.norm(axis)
    phase, count = rng.uniform(0, 6), int(rng.integers(2, 60))

    def lower(t):
        return size * np.sin(rate * t + phase) * axis

    edges = watched(rng, lower, lambda t: lower(t) + 0.3, count)
    t = (count - 1) * FRAME
    v, error = edges.velocity(FAST)
    true = size * rate * np.cos(rate * t + phase) * axis
    assert np.linalg.norm(v - true) <= error


def test_what_goes_on_evenly_is_known_better_and_better():
    rng = np.random.default_rng(0)

    def lower(t):
        return np.array([0.0, t, 0.0])

    errors = [
        watched(rng, lower, lambda t: lower(t) + 0.3, n).velocity(FAST)[1]
        for n in (1, 2, 4, 12)
    ]
    assert errors[0] == FAST
    assert errors[0] > errors[1] > 1.2 * errors[3]
    assert errors[-1] < 0.8


def test_a_thing_of_which_more_and_more_is_seen_may_have_either_speed():
    """It comes out from behind a wall: one face stands at the wall."""
    rng = np.random.default_rng(1)

    def upper(t):
        return np.array([0.5 * t, 0.2, 0.2])

    edges = watched(rng, lambda t: np.zeros(3), upper, 30)
    v, error = edges.velocity(FAST)
    assert np.linalg.norm(v - [0.5, 0, 0]) < error
    assert np.linalg.norm(v) < error


def test_outlines_do_not_follow_a_stray_point():
    rng = np.random.default_rng(2)
    points = rng.uniform(0, 1, (200, 3))
    points[0] = 3.0
    assert outline(points)[1] == pytest.approx(1.0, abs=0.3)
