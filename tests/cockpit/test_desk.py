"""Requests are counted, also if several clients ask at the same time."""

from threading import Thread

import numpy as np
import pytest

from remosplat_drake.cockpit.cockpit_operator import command_now, map_requests
from remosplat_drake.cockpit.desk import SOURCE, Desk
from remosplat_drake.scene.primitive_scene import PrimitiveScene
from remosplat_drake.teleop.gamepad import SILENCE


@pytest.fixture
def told():
    return []


@pytest.fixture
def desk(told) -> Desk:
    return Desk(told.append)


def test_a_pose_is_told_with_its_source(desk, told):
    X_WT = np.eye(4)
    X_WT[:3, 3] = [1, 2, 3]
    desk.move(X_WT)
    X_WT[0, 3] = 9.0  # What the caller does with it afterwards is not told.
    (wishes,) = told
    assert wishes.command.source == SOURCE and wishes.command.moves == 1
    np.testing.assert_array_equal(wishes.command.X_WT[:3, 3], [1, 2, 3])


@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_a_pose_that_is_not_finite_is_none(desk, told, bad):
    desk.move(np.full((4, 4), bad))
    assert not told


def test_every_press_counts(desk, told):
    for name in ("holds", "homes", "scans", "opens", "closes"):
        desk.press(name)
    for name in ("frames", "refines", "undos", "saves", "saves"):
        desk.request(name)
    desk.pick("shelf")
    desk.stop()
    desk.release()
    desk.change_scene()
    wishes = desk.wishes
    assert told[-1] is wishes and len(told) == 14
    command, requests = wishes.command, wishes.requests
    assert (command.holds, command.homes, command.scans) == (1, 1, 1)
    assert (command.opens, command.closes) == (1, 1)
    assert (command.poses, command.pose) == (1, "shelf")
    assert (requests.frames, requests.refines) == (1, 1)
    assert (requests.undos, requests.saves) == (1, 2)
    assert (wishes.operator.stops, wishes.operator.releases) == (1, 1)
    assert wishes.scene_changes == 1


def test_no_press_is_lost_among_threads(desk):
    def press():
        for _ in range(500):
            desk.stop()

    threads = [Thread(target=press) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert desk.wishes.operator.stops == 2000


def test_scenes_take_turns(desk):
    scenes = PrimitiveScene(name="before"), PrimitiveScene(name="later")
    assert map_requests(desk.wishes, scenes).scene is None
    desk.change_scene()
    assert map_requests(desk.wishes, scenes).scene is scenes[1]
    desk.change_scene()
    assert map_requests(desk.wishes, scenes).scene is scenes[0]
    assert map_requests(desk.wishes, ()).scene is None


def test_choosing_a_hand_forgets_the_pose_of_the_one_before(desk, told):
    desk.move(np.eye(4))
    desk.choose("right")
    command = told[-1].command
    assert (command.effector, command.choices) == ("right", 1)
    assert command.X_WT is None and command.moves == 1


def test_a_velocity_that_is_not_renewed_ends(desk, told, monkeypatch):
    now = 10.0
    monkeypatch.setattr("remosplat_drake.cockpit.desk.monotonic", lambda: now)
    desk.lead(None)
    desk.expire()
    assert not told  # There was none.
    desk.lead(np.ones(6))
    now += 0.9 * SILENCE
    desk.expire()
    assert desk.wishes.command.V_W is not None
    now += 0.2 * SILENCE
    desk.expire()
    assert desk.wishes.command.V_W is None


def test_a_velocity_ends_when_the_process_is_silent(desk):
    desk.lead(np.ones(6))
    assert command_now(desk.wishes, 0.9 * SILENCE).V_W is not None
    assert command_now(desk.wishes, 1.1 * SILENCE).V_W is None


def test_without_an_operator_the_target_holds(desk):
    desk.lead(np.ones(6))
    desk.let_go()
    command = desk.wishes.command
    assert command.V_W is None and command.holds == 1
