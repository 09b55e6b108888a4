"""Motions from random poses, whose base is where its localisation says."""

import dataclasses as dc
import json

import numpy as np
import pytest

from apps.studies.strokes.localized_station import LocalizedBase
from apps.studies.strokes.report import table
from apps.studies.strokes.trial import (
    BASE_STEP,
    CLEARANCE,
    STROKE,
    Result,
    Start,
    restored,
    run_trial,
    starts,
)
from remosplat_drake.robot.planar_pose import composed, relative

X_WB = np.array([0.4, -0.3, 2.0])


def off(true: np.ndarray, told: np.ndarray) -> np.ndarray:
    """Distance and angle between two poses of a base."""
    x, y, turn = relative(true, told)
    return np.array([np.hypot(x, y), abs(turn)])


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_a_moving_base_stays_within_its_bound(seed):
    """Its odometry alone does not."""
    base, pose = LocalizedBase(X_WB, seed), X_WB.copy()
    speed = np.array([0.3, 0.0, 0.2])
    worst = 0.0
    for _ in range(300):
        base.step(pose, speed)
        pose = composed(pose, 0.01 * speed)
        told = base.measurement.base_pose(base.time + 0.01, 0.1)
        bound = base.measurement.base_track.uncertainty
        worst = max(worst, float((off(pose, told) / bound).max()))
    assert 0.0 < worst <= 1.0
    assert base.measurement.base is not None
    assert off(pose, base.measurement.base.pose)[0] > 0.3


def test_it_is_read_as_identify_reads_it(frankie):
    base = LocalizedBase(X_WB, seed=3)
    reading = base.reading(frankie.home, frankie)
    np.testing.assert_array_equal(reading.q_W[3:], frankie.home)
    bound = reading.measurement.base_track.uncertainty
    assert (off(X_WB, reading.q_W[:3]) <= bound).all()
    assert (off(X_WB, reading.q[:3]) > bound).any()


def test_every_robot_moves_and_bases_move_twice():
    chosen = list(starts(2, seed=5))
    assert len({start.key for start in chosen}) == len(chosen)
    assert {start.scenario for start in chosen} == set(CLEARANCE)
    mobile = {s.scenario for s in chosen if s.is_localized}
    assert mobile == {"TableGroundTruth", "FetchReach", "RidgebackReach"}
    assert {s.scenario for s in chosen if s.motion == BASE_STEP} == mobile
    assert len(chosen) == 2 * (3 * 4 + 3)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("motion", "seed", "number"),
    [
        (STROKE, 0, 0),
        (BASE_STEP, 0, 0),
        # The base turns faster and faster between measurements of its speed.
        (STROKE, 2, 5),
    ],
)
def test_a_localised_robot_moves_and_touches_nothing(motion, seed, number):
    result = run_trial(Start("TableGroundTruth", motion, True, seed, number))
    assert not (result.error or result.no_room or result.stopped)
    assert not result.touched
    assert result.wrong_places == 0
    assert 0.0 < result.error_share < 1.0
    line = json.loads(json.dumps(dc.asdict(result)))
    assert restored(line) == result


def test_contacts_and_wrong_places_are_counted():
    key = Start("PandaReach", STROKE, False, 0, 0).key
    good = Result(key, own=0.02, scene=0.1)
    bad = Result(key, own=0.01, scene=-0.001, wrong_places=2)
    assert (good.touched, bad.touched) == (False, True)
    (row,) = table([good, bad, Result(key, no_room="a wall")]).rows
    assert row[:8] == (
        "PandaReach, stroke, not localised",
        *("3", "1", "0", "0", "0", "1", "2"),
    )
    assert row[-2:] == ("10.0", "-1.0")
