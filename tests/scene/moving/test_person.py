"""A person who walks and reaches moves smoothly, within the stated bounds."""

from pathlib import Path

import numpy as np
import pytest

from remosplat_drake.base.errors import FieldError
from remosplat_drake.scene.mover import Mover
from remosplat_drake.scene.moving.gait import RADIUS, Reach, Step
from remosplat_drake.scene.moving.person import Person
from remosplat_drake.scene.moving.rods import Rods

POINT = [0.45, 1.3, 1.1]
PERSON = Person(
    name="Ada",
    walk=[
        Step(0.0, [0.0, -2.0]),
        Step(4.0, [0.0, 1.0]),
        Step(8.0, [0.0, 1.0], 0.0),
    ],
    reaches=[Reach(5.0, 1.0, 0.8, POINT)],
)


@pytest.fixture(scope="module")
def track() -> Rods:
    return PERSON.make(Path())


def ends(mover: Mover) -> np.ndarray:
    """The upper and the lower end of a capsule's axis, shape (2, 3)."""
    half = mover.half_extents
    p_W = mover.X_WM.multiply(np.stack([half, -half]).T).T
    return p_W[np.argsort(-p_W[:, 2])]


def test_it_has_all_its_parts(track):
    names = [mover.name for mover in track.movers(0.0)]
    assert names == [f"Ada's {part}" for part in RADIUS]


@pytest.mark.parametrize("time", [0.0, 4.0, 8.0])
def test_the_body_is_above_the_steps_in_time(track, time):
    body = track.movers(time)[0]
    there = next(s.position for s in PERSON.walk if s.time == time)
    np.testing.assert_allclose(body.X_WM.translation()[:2], there, atol=1e-9)


def test_legs_swing_against_each_other_and_stop(track):
    def ahead(time: float) -> np.ndarray:
        """How far the feet are before the hips on the way, along y."""
        _, _, left, right, *_ = track.movers(time)
        return np.array(
            [-np.diff(ends(leg)[::-1, 1])[0] for leg in (left, right)]
        )

    swings = np.array([ahead(t) for t in np.arange(1.0, 3.0, 0.05)])
    assert swings.min() < -0.2 and swings.max() > 0.2
    np.testing.assert_allclose(swings[:, 0], -swings[:, 1], atol=0.02)
    np.testing.assert_allclose(ahead(0.0), 0.0, atol=1e-3)


def test_the_hand_is_where_it_reaches(track):
    arm = track.movers(6.3)[-1]
    off = np.linalg.norm(ends(arm) - POINT, axis=1).min()
    assert off < 0.05
    # A limb is as long as it is.
    lengths = [2 * track.movers(t)[-1].half_extents[2] for t in (0.0, 6.3)]
    assert lengths[0] == lengths[1] == pytest.approx(0.2 * 1.75, abs=0.01)


def test_velocities_are_those_of_the_motion(track):
    h = 1e-5
    for time in np.linspace(0.1, 7.9, 40):
        before, now, after = (
            track.movers(t) for t in (time - h, time, time + h)
        )
        for a, m, b in zip(before, now, after, strict=True):
            p = m.half_extents
            moved = (b.X_WM @ p - a.X_WM @ p) / (2 * h)
            # Where along its axis it is turned does not matter to a capsule.
            v_W = m.v_WM + np.cross(m.w_WM, m.X_WM.rotation() @ p)
            np.testing.assert_allclose(v_W, moved, atol=1e-4)


def test_no_part_exceeds_its_bounds(track):
    h = 2e-3
    times = np.arange(0.0, 8.0, h)
    ends_W = np.array(
        [[m.X_WM @ m.half_extents for m in track.movers(t)] for t in times]
    )
    v_W = np.diff(ends_W, axis=0) / h
    a_W = np.diff(v_W, axis=0) / h
    for i, mover in enumerate(track.movers(0.0)):
        assert np.linalg.norm(v_W[:, i], axis=1).max() < mover.max_speed
        assert np.linalg.norm(a_W[:, i], axis=1).max() < mover.max_acceleration


def test_bounds_may_be_told():
    (body, *_) = (
        Person(max_speed=1.5, max_acceleration=6.0).make(Path()).movers(0)
    )
    assert (body.max_speed, body.max_acceleration) == (1.5, 6.0)
    assert not body.v_WM.any()


@pytest.mark.parametrize(
    ("fields", "problem"),
    [
        ({"walk": [Step(1.0), Step(1.0)]}, r"walk\[1\]\.time.*exceed"),
        ({"reaches": [Reach(1.0), Reach(2.0)]}, r"reaches\[1\]\.time.*4\.0"),
        ({"walk": []}, "walk"),
        ({"height": 5.0}, "height"),
    ],
)
def test_what_cannot_be_walked_is_refused(fields, problem):
    with pytest.raises(FieldError, match=problem):
        Person(**fields)
