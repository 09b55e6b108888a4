"""A base that stops unnoticed, and some that only drive: pure simulation."""

import functools
from collections.abc import Iterable

import numpy as np
import pytest
from effort import effort
from hypothesis import given
from hypothesis import strategies as st

from apps.studies.base_stops import (
    Base,
    driven,
    false_alarms,
    random_commands,
    time_to_alarm,
)
from remosplat_drake.hardware.client import base_residual_kernel as kernel
from remosplat_drake.hardware.client import base_residual_reference as slow
from remosplat_drake.hardware.client.base_residual import (
    SLACK,
    BaseSample,
    BaseSamples,
    CommandedPath,
    follow_problem,
    speed_problem,
)
from remosplat_drake.hardware.hardware_config import HardwareConfig

DELAY = HardwareConfig.base_delay


def gathered(samples: Iterable[BaseSample]) -> BaseSamples:
    return functools.reduce(BaseSamples.with_sample, samples, BaseSamples())


@given(st.integers(0, 2**32 - 1))
def test_the_kernel_says_what_the_reference_says(seed):
    random = np.random.default_rng(seed)
    n, k = random.integers(1, 4), random.integers(1, 40)
    rows = random.normal(0, 0.5, (k, random.choice([7, 11])))
    rows[:, 0] = np.sort(random.uniform(0, 2, k))
    rows[:, 4:7] *= random.random() < 0.9  # Some stand.
    start = random.uniform(-0.5, 2.5, n)
    end = start + random.uniform(0, 2, n)
    moved = random.normal(0, 0.3, (n, 3))
    if random.random() < 0.2:
        moved[random.integers(n), random.integers(3)] = np.nan
    late = np.linspace(0, random.uniform(0, 0.4), 6)
    np.testing.assert_allclose(
        kernel.path_motions(rows, 0.1, start, end),
        slow.path_motions(rows, 0.1, start, end),
        atol=1e-12,
    )
    asked = rows, 0.1, start, end, moved, late, SLACK, 0.06
    fast, reference = kernel.path_residuals(*asked), slow.path_residuals(*asked)
    np.testing.assert_allclose(fast[1], reference[1], rtol=1e-9)
    # Of delays that fit equally well either may be told.
    told = kernel.path_motions(
        rows,
        0.1,
        (start[:, None] - late).ravel(),
        (end[:, None] - late).ravel(),
    ).reshape(n, len(late), 3)
    for i in range(n):
        assert np.abs(told[i] - fast[0][i]).max(axis=1).min() < 1e-12


def test_the_commanded_path_is_made_of_arcs():
    path = CommandedPath()
    for i in range(101):
        path.append(10 + 0.01 * i, np.array([0.5, 0.0, 1.0]))
    motion = path.arcs.motions(np.array([10.0]), np.array([11.0]))[0]
    expected = [0.5 * np.sin(1.0), 0.5 * (1 - np.cos(1.0)), 1.0]
    np.testing.assert_allclose(motion, expected, atol=1e-9)
    # Drivers let a command expire.
    late = path.arcs.motions(np.array([11.0]), np.array([20.0]))[0]
    assert np.hypot(*late[:2]) == pytest.approx(0.05, rel=0.01)


def test_a_base_goes_sideways_along_its_arc():
    """As ahead, a quarter turn to the left."""
    ahead, aside = CommandedPath(), CommandedPath()
    for i in range(101):
        ahead.append(0.01 * i, np.array([0.5, 0.0, 1.0]))
        aside.append(0.01 * i, np.array([0.0, 0.5, 1.0]))
    span = np.array([0.0]), np.array([1.0])
    x, y, yaw = ahead.arcs.motions(*span)[0]
    np.testing.assert_allclose(aside.arcs.motions(*span)[0], [-y, x, yaw])


def test_a_path_forgets_and_goes_on():
    path = CommandedPath()
    for i in range(20_000):
        path.append(0.001 * i, np.array([1.0, 0.0, 0.0]))
    motion = path.arcs.motions(np.array([18.0]), np.array([19.0]))[0]
    np.testing.assert_allclose(motion, [1.0, 0.0, 0.0], atol=1e-9)


@pytest.mark.parametrize("speed", [-0.05, 0.05, 0.2, 0.5])
@pytest.mark.parametrize("delay", [0.0, 0.1, 0.2])
def test_a_stop_is_found_within_its_delay_and_three_tenths(speed, delay):
    random, base = np.random.default_rng(0), Base(delay, 0.03, np.ones(2))
    assert 0 < time_to_alarm(random, speed, base) < delay + 0.3


def test_noisy_driving_raises_no_alarm():
    """Some minutes; `apps.studies.base_stops` drives for ten hours."""
    minutes = effort(3, 6)
    random = np.random.default_rng(1)
    assert false_alarms(random, minutes / 60) == (0, minutes)


def test_the_station_asks_as_the_study_does():
    """Message by message, the fault is found at the same one."""
    random = np.random.default_rng(2)
    commands = random_commands(random, 800)
    commands[:, 0] = 0.1
    base = Base(0.1, 0.03, np.ones(2))
    drive = driven(random, base, commands, stops_at=5.0)
    samples = gathered(
        BaseSample(t, t, pose, np.zeros(3))
        for t, pose in zip(drive.stamp, drive.pose, strict=True)
    )
    found = [
        t
        for i, t in enumerate(samples.stamp)
        if t > 3.0
        and follow_problem(drive.path, samples.where(slice(i + 1)), DELAY)
    ]
    assert found[0] == drive.first_alarm(DELAY)


@pytest.mark.parametrize("drifts", [False, True])
@pytest.mark.parametrize("seed", range(3))
def test_a_pose_is_held_against_speeds_that_are_told_late(seed, drifts):
    random = np.random.default_rng(seed)
    commands = 0.3 * random_commands(random, 3000)
    drive = driven(random, Base(0.1, 0.05, np.ones(2)), commands)
    sample = BaseSample(0.0, 0.0, np.zeros(3), np.zeros(3))
    samples, found = gathered([sample]), []
    heard = zip(drive.stamp, drive.pose, drive.speed, strict=True)
    for t, pose, speed in heard:
        off = np.array([0.02 * t * drifts, 0.0, 0.0])
        sample = sample.then(t, t, pose + off, speed)
        samples = samples.where(slice(-100, None)).with_sample(sample)
        if speed_problem(samples):
            found.append(t)
    assert bool(found) == drifts, found
    if drifts:
        assert found[0] < 4.0


def test_what_others_had_the_base_do_before_is_no_fault():
    path = CommandedPath()
    moved = gathered(
        BaseSample(t, t, np.array([0.3 * t, 0, 0]), np.array([0.3, 0, 0]))
        for t in np.arange(0, 2, 0.03)
    )
    path.append(1.99, np.zeros(3))
    assert follow_problem(path, moved, DELAY) == ""
