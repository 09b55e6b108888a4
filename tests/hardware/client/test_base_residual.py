"""A base that stops unnoticed, and many that only drive: pure simulation."""

import numpy as np
import pytest
from noisy_base import NoisyBase, random_commands

from remosplat_drake.hardware.client.base_residual import (
    BaseSample,
    CommandedPath,
    follow_problem,
)

DELAY = 0.25
"""Longest delay that the residual allows for [s]."""


def test_the_commanded_path_is_made_of_arcs():
    path = CommandedPath()
    for i in range(101):
        path.append(10 + 0.01 * i, np.array([0.5, 1.0]))
    motion = path.motions(np.array([10.0]), np.array([11.0]))[0]
    expected = [0.5 * np.sin(1.0), 0.5 * (1 - np.cos(1.0)), 1.0]
    np.testing.assert_allclose(motion, expected, atol=1e-9)
    # Drivers let a command expire.
    late = path.motions(np.array([11.0]), np.array([20.0]))[0]
    assert np.hypot(*late[:2]) == pytest.approx(0.05, rel=0.01)


def test_a_path_forgets_and_goes_on():
    path = CommandedPath()
    for i in range(20_000):
        path.append(0.001 * i, np.array([1.0, 0.0]))
    motion = path.motions(np.array([18.0]), np.array([19.0]))[0]
    np.testing.assert_allclose(motion, [1.0, 0.0, 0.0], atol=1e-9)


@pytest.mark.parametrize("speed", [0.05, -0.05, 0.2, 0.5])
@pytest.mark.parametrize("delay", [0.0, 0.1, 0.25])
def test_a_stop_is_noticed_within_its_delay_and_three_tenths(speed, delay):
    base = NoisyBase(np.random.default_rng(0), delay=delay)
    commands = np.tile([speed, 0.0], (600, 1))
    commands[:50] *= np.linspace(0, 1, 50)[:, None]
    alarm = base.first_alarm(commands, DELAY, stops_at=4.0)
    assert 4.0 < alarm < 4.0 + delay + 0.3


@pytest.mark.parametrize("seed", range(4))
def test_noisy_driving_alarms_nobody(seed):
    """Three minutes; `apps.studies.base_stops` drives for ten hours."""
    random = np.random.default_rng(seed)
    base = NoisyBase(random)
    assert base.first_alarm(random_commands(random, 4500), DELAY) == np.inf


def test_what_others_had_the_base_do_before_is_no_fault():
    path = CommandedPath()
    moved = [
        BaseSample(t, t, np.array([0.3 * t, 0, 0]), np.array([0.3, 0]))
        for t in np.arange(0, 2, 0.03)
    ]
    path.append(1.99, np.zeros(2))
    assert follow_problem(path, moved, DELAY) == ""
