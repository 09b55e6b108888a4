"""An operator's script: the file, and what it asks at which time."""

import numpy as np
import pytest
from pydrake.systems.analysis import Simulator

from remosplat_drake.base.errors import FieldError, FileError
from remosplat_drake.scene.primitive_scene import PrimitiveScene
from remosplat_drake.signals.map_requests import MapRequests
from remosplat_drake.teleop.trajectory_file import (
    OperatorStep,
    accumulate_requests,
    load_operator_steps,
)
from remosplat_drake.teleop.trajectory_operator import TrajectoryOperator

SCRIPT = """
steps:
- {time: 0, press: scan}
- {time: 1, translation: [1, 0, 0.7], rpy_deg: [180, 0, 90]}
- {time: 2, press: frame}
- {time: 2, press: frame}
- {time: 2.5, translation: [1, 0.2, 0.7], press: refine}
- {time: 3, pick: shelf}
- {time: 4, press: hold}
"""


def write(folder, text: str):
    path = folder / "script.yaml"
    path.write_text(text)
    return path


class Script:
    def __init__(self, path, start: float = 0.0):
        self.system = TrajectoryOperator(
            steps=load_operator_steps(path, ["shelf"])
        )
        simulator = Simulator(self.system)
        self.context = simulator.get_mutable_context()
        self.context.SetTime(start)
        simulator.Initialize()
        self.start = start

    def command(self, time: float):
        self.context.SetTime(self.start + time)
        return self.system.GetOutputPort("command").Eval(self.context)

    def map_requests(self, time: float):
        self.context.SetTime(self.start + time)
        return self.system.GetOutputPort("map_requests").Eval(self.context)


@pytest.mark.parametrize("start", [0.0, 1.7e9])
def test_each_step_is_asked_in_its_time(tmp_path, start):
    script = Script(write(tmp_path, SCRIPT), start)
    assert script.command(0.5).scans == 1
    assert script.command(0.5).X_WT is None
    at_one = script.command(1.01)
    assert (at_one.moves, at_one.source) == (1, "trajectory")
    np.testing.assert_allclose(at_one.X_WT[:3, 0], [0, 1, 0], atol=1e-12)
    at_end = script.command(9.0)
    assert (at_end.moves, at_end.holds, at_end.homes) == (2, 1, 0)
    assert (at_end.pose, at_end.poses) == ("shelf", 1)
    np.testing.assert_allclose(at_end.X_WT[:3, 3], [1, 0.2, 0.7])
    # The rotation is that of the pose before.
    np.testing.assert_allclose(at_end.X_WT[:3, :3], at_one.X_WT[:3, :3])
    assert script.map_requests(1.9) == MapRequests()
    assert script.map_requests(9.0) == MapRequests(frames=2, refines=1)


def test_a_step_is_due_at_its_time_though_ticks_are_sums(tmp_path):
    script = Script(write(tmp_path, SCRIPT))
    time = 0.0
    for _ in range(10):  # `sum` rounds once since Python 3.12.
        time += 0.1
    assert time < 1.0
    assert script.command(time).moves == 1


def test_steps_can_be_made_by_a_program():
    system = TrajectoryOperator(steps=[OperatorStep(press="home")])
    context = system.CreateDefaultContext()
    assert system.GetOutputPort("command").Eval(context).homes == 1


def test_something_is_put_there_and_taken_away_again(tmp_path):
    scenes = PrimitiveScene(name="bare"), PrimitiveScene(name="laden")
    presses = "{time: 1, press: scene}, {time: 2, press: scene}"
    path = write(tmp_path, f"steps: [{presses}]")
    steps = load_operator_steps(path, [], scenes)
    asked = accumulate_requests(steps, scenes)
    shown = [ask.map_requests.scene for ask in asked]
    assert shown == [None, scenes[1], scenes[0]]


def test_objects_are_taken_and_put_down(tmp_path):
    text = """
    steps:
    - {time: 1, take: can}
    - {time: 2, put_on: tray, near: [1.0, 0.2, 0.5]}
    - {time: 3, find: [1.0, 0.4, 0.6]}
    - {time: 4, take: object 1}
    """
    path = write(tmp_path, text)
    steps = load_operator_steps(path, [], objects=["can", "tray"])
    last = accumulate_requests(steps)[-1].command
    assert (last.thing, last.takes) == ("object 1", 2)
    assert last.finds == 1
    np.testing.assert_array_equal(last.p_WFind, [1.0, 0.4, 0.6])
    assert (last.support, last.places) == ("tray", 1)
    np.testing.assert_array_equal(last.p_WNear, [1.0, 0.2, 0.5])


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("steps: [{time: 1, take: can}]", "steps[0].take: needs a simulation"),
        ("steps: [{time: 1, put_on: tray}]", "steps[0].put_on"),
        ("steps: [{time: 1, find: [1, 0, 0]}]", "steps[0].find: needs a sim"),
        ("steps: [{near: [1, 0, 0], press: home}]", "needs the field put_on"),
        ("steps: []", "steps: there are none"),
        ("steps: [{time: -1, press: home}]", "steps[0].time"),
        (
            "steps: [{time: 2, press: home}, {time: 1, press: home}]",
            "must not be before 2, got 1",
        ),
        ("steps: [{time: 1, press: hom}]", "did you mean 'home'?"),
        ("steps: [{time: 1, pick: self}]", "did you mean 'shelf'?"),
        ("steps: [{time: 1, translation: [1]}]", "expected 3 entries"),
        ("steps: [{time: 1, rpy_deg: [1, 2, 3]}]", "needs a translation"),
        ("steps: [{time: 1}]", "requests nothing"),
        ("steps: [{time: 1, presses: home}]", "unknown field 'presses'"),
        ("steps: [{time: 1, press: scene}]", "truth_later"),
        ("steps: [{time: .nan, press: home}]", "must be finite"),
    ],
)
def test_mistakes_are_named(tmp_path, text, problem):
    with pytest.raises(FieldError) as error:
        load_operator_steps(write(tmp_path, text), ["shelf"])
    assert problem in str(error.value)
    assert "script.yaml" in str(error.value)


def test_a_missing_file(tmp_path):
    with pytest.raises(FileError):
        load_operator_steps(tmp_path / "none.yaml", [])
