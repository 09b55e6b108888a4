"""The next tick, and the summary of a log of ticks."""

import math
import os
import time

import numpy as np
import pytest

from remosplat_drake.base.clock import next_tick, sleep_until
from remosplat_drake.base.real_time import (
    CONTROLLER_PRIORITY,
    KEPT,
    LoopLog,
    Spread,
    realtime_priority,
)


@pytest.mark.parametrize(
    ("now", "tick"),
    [
        (10.0, 102),  # Tick 101 is done at once: 102 is next.
        (10.14, 102),
        (10.21, 102),  # It may start a little late.
        (10.26, 103),  # Too late for 102.
        (12.0, 120),
        (9.0, 102),  # The clock was set back.
    ],
)
def test_the_next_tick(now, tick):
    assert next_tick(now, 0.1, latest=101) == tick


def test_ticks_are_multiples_of_the_period_since_1970():
    now = 1_700_000_000.0137
    assert next_tick(now, 0.01, 0) * 0.01 == pytest.approx(1_700_000_000.01)


def test_a_sleep_is_never_long():
    start = time.monotonic()
    sleep_until(time.time() + 1000, longest=0.01)
    sleep_until(time.time() - 1000, longest=0.01)
    assert time.monotonic() - start < 10


def test_the_spread_of_a_hundred_numbers():
    spread = Spread.of(np.arange(101.0))
    assert (spread.p50, spread.p99, spread.max) == (50, 99, 100)
    assert math.isnan(Spread.of(np.array([])).max)


def test_a_log_of_three_ticks():
    log = LoopLog(0.01)
    assert math.isnan(log.age)
    for sent in (5.001, 5.011, 5.023):
        log.record(stamp=sent - 0.002, heard=sent - 0.001, sent=sent)
    log.missed = 1
    quality = log.quality()
    assert log.age == pytest.approx(0.002)
    assert (quality.ticks, quality.missed, quality.unheard) == (3, 1, 0)
    assert quality.age.p50 == pytest.approx(0.002)
    assert quality.work.max == pytest.approx(0.001)
    assert quality.jitter.max == pytest.approx(0.002)
    assert 0 <= quality.busy.max < 10
    assert quality.image_to_command is None


def test_an_image_counts_at_the_first_command_that_rests_on_it():
    log = LoopLog(0.01)
    for sent, image in ((5.0, 4.9), (5.01, 4.98), (5.02, 4.98), (5.03, 5.01)):
        log.record(stamp=sent, heard=sent, sent=sent, image=image)
    image_to_command = log.quality().image_to_command
    assert image_to_command is not None
    assert image_to_command.p50 == pytest.approx(0.025)
    assert image_to_command.max == pytest.approx(0.03)


def test_in_long_runs_the_latest_ticks_count():
    log = LoopLog(0.01)
    for tick in range(KEPT + 10):
        # The first ones are slow; so is one period, which is forgotten, too.
        age = 0.005 if tick < 10 else 0.002
        sent = 0.01 * tick + (0.5 if tick > 5 else 0.0)
        log.record(stamp=sent - age, heard=sent - 0.001, sent=sent)
    quality = log.quality()
    assert quality.ticks == KEPT + 10
    assert log.age == pytest.approx(0.002)
    assert quality.age.max == pytest.approx(0.002)
    assert quality.jitter.max == pytest.approx(0, abs=1e-9)


def test_realtime_priority_ends_with_its_block():
    before = os.sched_getscheduler(0)
    with realtime_priority(CONTROLLER_PRIORITY):
        assert os.sched_getscheduler(0) in (before, os.SCHED_RR)
    assert os.sched_getscheduler(0) == before
