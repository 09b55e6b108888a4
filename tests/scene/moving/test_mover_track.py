"""Movers of scenarios move as they say, and keep the bounds that they tell."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from remosplat_drake.base.errors import FieldError
from remosplat_drake.scene.moving.mover_track import (
    MoverConfig,
    MoverTrack,
    WaypointConfig,
)
from remosplat_drake.scene.moving.track import movers_at

DOOR = MoverConfig(
    name="door",
    half_extents=[0.4, 0.02, 1.0],
    radius=0.0,
    waypoints=[
        WaypointConfig(time=1.0),
        WaypointConfig(
            time=2.0, translation=[0.2, 0.1, 0.0], rpy_deg=[0, 0, 40]
        ),
        WaypointConfig(
            time=4.0, translation=[0.1, 0.5, 0.0], rpy_deg=[0, 0, 90]
        ),
    ],
)


def test_it_is_at_its_waypoints_in_time():
    track = MoverTrack(DOOR)
    for waypoint in DOOR.waypoints:
        X_WM = track.at(waypoint.time).X_WM
        assert X_WM.IsNearlyEqualTo(waypoint.X_WM, 1e-12)
    for time in (0.0, 0.999, 4.001, 9.0):
        mover = track.at(time)
        assert not mover.v_WM.any() and not mover.w_WM.any()


@pytest.mark.parametrize("time", np.linspace(1.01, 3.99, 23))
def test_velocities_are_those_of_the_motion(time):
    track, h = MoverTrack(DOOR), 1e-6
    now, before, after = (track.at(t) for t in (time, time - h, time + h))
    moved = after.X_WM.translation() - before.X_WM.translation()
    np.testing.assert_allclose(now.v_WM, moved / (2 * h), atol=1e-6)
    turned = after.X_WM.rotation() @ before.X_WM.rotation().inverse()
    w_WM = Rotation.from_matrix(turned.matrix()).as_rotvec() / (2 * h)
    np.testing.assert_allclose(now.w_WM, w_WM, atol=1e-6)


def test_no_point_exceeds_its_bounds():
    track, h = MoverTrack(DOOR), 1e-3
    corners = [[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]
    times = np.arange(0.9, 4.1, h)
    corner = np.array(corners) * DOOR.half_extents
    p_W = np.array([track.at(t).X_WM.multiply(corner.T) for t in times])
    v_W = np.diff(p_W, axis=0) / h
    a_W = np.diff(v_W, axis=0) / h
    mover = track.at(0.0)
    speed = np.linalg.norm(v_W, axis=1).max()
    push = np.linalg.norm(a_W, axis=1).max()
    assert 0.95 * mover.max_speed < speed <= mover.max_speed
    assert 0.95 * mover.max_acceleration < push <= mover.max_acceleration


def test_a_single_waypoint_stays():
    rock = MoverConfig(name="rock", waypoints=[WaypointConfig(time=3.0)])
    movers = movers_at([MoverTrack(rock), MoverTrack(DOOR)], 2.0)
    assert movers.stamp == 2.0
    still, door = movers
    assert not still.v_WM.any() and still.max_speed == 0.0
    assert door.name == "door"


def test_bounds_may_be_wider_than_the_motion():
    calm = MoverConfig(max_speed=2.0, max_acceleration=5.0)
    mover = MoverTrack(calm).at(0.0)
    assert (mover.max_speed, mover.max_acceleration) == (2.0, 5.0)


@pytest.mark.parametrize(
    ("fields", "problem"),
    [
        ({"radius": 0.0}, "radius: must exceed 0 unless"),
        ({"radius": -1.0}, "radius"),
        ({"waypoints": []}, "waypoints"),
        (
            {"waypoints": [WaypointConfig(time=1), WaypointConfig(time=1)]},
            r"waypoints\[1\].time: must exceed the one before",
        ),
    ],
)
def test_bad_configurations_are_named(fields, problem):
    with pytest.raises(FieldError, match=problem):
        MoverConfig(**fields)
