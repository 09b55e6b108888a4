"""Requests are counted, also if several clients ask at the same time."""

from threading import Thread

import numpy as np
import pytest

from remosplat_drake.cockpit.cockpit_operator import command_now, map_requests
from remosplat_drake.cockpit.operator_input import SOURCE, OperatorInput
from remosplat_drake.scene.primitive_scene import PrimitiveScene
from remosplat_drake.teleop.gamepad import SILENCE


@pytest.fixture
def told():
    return []


@pytest.fixture
def inputs(told) -> OperatorInput:
    return OperatorInput(told.append)


def test_a_pose_is_told_with_its_source(inputs, told):
    X_WT = np.eye(4)
    X_WT[:3, 3] = [1, 2, 3]
    inputs.move(X_WT)
    X_WT[0, 3] = 9.0  # What the caller does with it afterwards is not told.
    (requests,) = told
    assert requests.command.source == SOURCE and requests.command.moves == 1
    np.testing.assert_array_equal(requests.command.X_WT[:3, 3], [1, 2, 3])


@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_a_pose_that_is_not_finite_is_none(inputs, told, bad):
    inputs.move(np.full((4, 4), bad))
    assert not told


def test_every_press_counts(inputs, told):
    for name in ("holds", "homes", "scans", "opens", "closes"):
        inputs.press(name)
    for name in ("frames", "refines", "undos", "saves", "saves"):
        inputs.request(name)
    inputs.pick("shelf")
    inputs.stop()
    inputs.release()
    inputs.change_scene()
    requests = inputs.requests
    assert told[-1] is requests and len(told) == 14
    command, on_map = requests.command, requests.map_requests
    assert (command.holds, command.homes, command.scans) == (1, 1, 1)
    assert (command.opens, command.closes) == (1, 1)
    assert (command.poses, command.pose) == (1, "shelf")
    assert (on_map.frames, on_map.refines) == (1, 1)
    assert (on_map.undos, on_map.saves) == (1, 2)
    assert (requests.operator.stops, requests.operator.releases) == (1, 1)
    assert requests.scene_changes == 1


def test_no_press_is_lost_among_threads(inputs):
    def press():
        for _ in range(500):
            inputs.stop()

    threads = [Thread(target=press) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert inputs.requests.operator.stops == 2000


def test_scenes_take_turns(inputs):
    scenes = PrimitiveScene(name="before"), PrimitiveScene(name="later")
    assert map_requests(inputs.requests, scenes).scene is None
    inputs.change_scene()
    assert map_requests(inputs.requests, scenes).scene is scenes[1]
    inputs.change_scene()
    assert map_requests(inputs.requests, scenes).scene is scenes[0]
    assert map_requests(inputs.requests, ()).scene is None


def test_choosing_a_hand_forgets_the_previous_pose(inputs, told):
    inputs.move(np.eye(4))
    inputs.choose("right")
    command = told[-1].command
    assert (command.effector, command.choices) == ("right", 1)
    assert command.X_WT is None and command.moves == 1


def test_a_velocity_that_is_not_renewed_ends(inputs, told, monkeypatch):
    now = 10.0
    monkeypatch.setattr(
        "remosplat_drake.cockpit.operator_input.monotonic", lambda: now
    )
    inputs.lead(None)
    inputs.expire()
    assert not told  # There was none.
    inputs.lead(np.ones(6))
    now += 0.9 * SILENCE
    inputs.expire()
    assert inputs.requests.command.V_W is not None
    now += 0.2 * SILENCE
    inputs.expire()
    assert inputs.requests.command.V_W is None


def test_a_velocity_ends_when_the_process_is_silent(inputs):
    inputs.lead(np.ones(6))
    assert command_now(inputs.requests, 0.9 * SILENCE).V_W is not None
    assert command_now(inputs.requests, 1.1 * SILENCE).V_W is None


def test_without_an_operator_the_target_holds(inputs):
    inputs.lead(np.ones(6))
    inputs.let_go()
    command = inputs.requests.command
    assert command.V_W is None and command.holds == 1
