"""Requests for a map of things that stay put."""

import dataclasses as dc

import numpy as np
import pytest
from pydrake.math import RigidTransform

from remosplat_drake.camera.wrist_camera_config import WristCameraConfig
from remosplat_drake.detection.settled_things import SettledThings
from remosplat_drake.detection.unseen_space import UNSEEN
from remosplat_drake.scene.mover import Mover, Movers
from remosplat_drake.scene.mover_camera import MoverCamera

CAMERA = MoverCamera(
    "room", RigidTransform(), -np.ones(2), np.ones(2), 0.1, 4.0, 0.0
)


def seen(x: float, cameras=(CAMERA,), name="seen 1") -> Movers:
    """A box of two parts beside each other, the first one's centre at x."""
    parts = [
        Mover.sphere(f"{name}.{i + 1}", [x + 0.1 * i, 0, 1], 0.1)
        for i in range(2)
    ]
    return Movers(0.0, parts, cameras)


def asked(places, in_view=lambda p_W: True, cameras=(CAMERA,)) -> list[float]:
    """Times at which a map is asked, looking every 0.5 s."""
    things, times = SettledThings(), []
    for i, x in enumerate(places):
        before = things.asked
        things = things.after(seen(x, cameras), 0.5 * i, in_view, 1.5)
        times += [0.5 * i] * (things.asked - before)
    return times


def test_what_stays_is_asked_for_once_in_a_while():
    assert asked([0.0] * 30) == [1.5, 11.5]


def test_what_moves_is_not_until_it_stays():
    assert asked([0.2 * i for i in range(20)]) == []
    assert asked([0.2, 0.0, 0.01, 0.02, 0.0, 0.0]) == [2.0]


def test_it_is_asked_for_where_the_camera_of_the_map_sees_it():
    looked_at = []

    def in_view(p_W: np.ndarray) -> bool:
        looked_at.append(p_W)
        return len(looked_at) > 3

    assert asked([0.0] * 12, in_view) == [3.0]
    assert looked_at[0] == pytest.approx([0.05, 0, 1])


def test_what_is_known_otherwise_is_no_business_of_the_map():
    assert asked([0.0] * 12, cameras=()) == []


def test_what_has_gone_and_come_again_is_another_thing():
    things = SettledThings()
    for time, movers in ((0, seen(0)), (1, Movers(1, (), [CAMERA]))):
        things = things.after(movers, time, lambda p_W: True, 1.5)
    things = things.after(seen(0), 2, lambda p_W: True, 1.5)
    assert not things.asked


def test_a_camera_sees_what_is_in_its_image():
    camera = WristCameraConfig(width=100, height=100, fov_y_deg=90)
    camera = dc.replace(camera, min_depth=0.2, max_depth=3.0)
    X_WC = np.eye(4)
    X_WC[:3, 3] = [0, 0, 1]
    for p_W, is_seen in (
        ([0, 0, 2], True),
        ([0.9, -0.9, 2], True),
        ([1.1, 0, 2], False),
        ([0, 0, 1.1], False),
        ([0, 0, 4.5], False),
        ([0, 0, 0], False),
    ):
        assert camera.sees(X_WC, np.array(p_W)) == is_seen


def test_what_has_not_settled_passes():
    things = SettledThings()
    unseen = Mover.sphere(UNSEEN, np.zeros(3), 1.0)
    both = seen(0.0)
    both = dc.replace(both, movers=[*both, unseen])
    for i in range(4):
        assert things.passing(both).movers == both.movers[:2]
        things = things.after(both, 0.5 * i, lambda p_W: False, 1.5)
    assert not len(things.passing(both))
    things = things.after(seen(0.3), 2.0, lambda p_W: False, 1.5)
    assert len(things.passing(seen(0.3))) == 2


def test_what_is_known_otherwise_passes_always():
    known = seen(0.0, cameras=())
    things = SettledThings().after(known, 9.0, lambda p_W: True, 1.5)
    assert things.passing(known).movers == known.movers
