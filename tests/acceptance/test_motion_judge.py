"""Standstill, stillness and clearance of recorded motions, by hand."""

import math

import numpy as np
import pytest

from remosplat_drake.acceptance.motion_judge import (
    TrueRun,
    distance_moved,
    first_standstill,
    judge_stop,
    true_clearance,
)
from remosplat_drake.oracle.signed_distance import SignedDistanceField

PERIOD = 0.01


def driven(forward: np.ndarray, home: np.ndarray) -> TrueRun:
    """A base that drives at the given speeds, one a sample."""
    n = len(forward)
    q = np.tile(np.concatenate([np.zeros(3), home]), (n, 1))
    q[1:, 0] = PERIOD * np.cumsum(forward)[:-1]
    u = np.zeros((n, 9))
    u[:, 0] = forward
    return TrueRun(100.0 + PERIOD * np.arange(n), q, u)


def test_a_stop_is_timed_from_the_fault(frankie):
    run = driven(np.r_[np.full(20, 0.5), np.zeros(20)], frankie.home)
    stop = judge_stop(run, 100.05, frankie)
    assert stop.time_to_zero == pytest.approx(0.15)
    assert stop.moved_after == pytest.approx(0.0, abs=1e-12)
    assert stop.stays


def test_a_robot_that_moves_again_is_found_out(frankie):
    speeds = np.r_[np.full(9, 0.5), np.zeros(9), np.full(9, 0.5), np.zeros(9)]
    stop = judge_stop(driven(speeds, frankie.home), 100.0, frankie)
    assert stop.time_to_zero == pytest.approx(0.09)
    assert stop.moved_after == pytest.approx(9 * PERIOD * 0.5)
    assert not stop.stays


def test_a_robot_that_passes_through_zero_does_not_stand(frankie):
    speeds = np.r_[np.full(9, 0.5), np.zeros(2), np.full(9, -0.5)]
    run = driven(speeds, frankie.home)
    assert first_standstill(run, 100.0) is None
    stop = judge_stop(run, 100.0, frankie)
    assert math.isnan(stop.time_to_zero)
    assert not stop.stays


def test_a_run_is_cut_in_two_at_a_time(frankie):
    """A stop, a release at 0.2 s, and 0.1 s at 0.5 m/s."""
    speeds = np.r_[np.full(9, 0.5), np.zeros(11), np.full(10, 0.5), 0.0]
    run = driven(speeds, frankie.home)
    released = 100.195
    before, after = run.until(released), run.since(released)
    assert len(before.time) == 20
    assert len(before.time) + len(after.time) == len(run.time)
    assert judge_stop(before, 100.0, frankie).stays
    assert distance_moved(after, frankie) == pytest.approx(0.05)
    assert distance_moved(run.since(200.0), frankie) == 0.0


def test_the_clearance_is_that_of_the_closest_moment(frankie, scene):
    truth = SignedDistanceField(scene)
    run = driven(np.r_[np.full(20, 0.5), np.full(40, -0.5)], frankie.home)
    clearance = [
        truth.clearances(frankie.spheres_at(q)).minimum() for q in run.q
    ]
    assert true_clearance(run, frankie, truth) == pytest.approx(min(clearance))
    assert min(clearance) < min(clearance[0], clearance[-1])
