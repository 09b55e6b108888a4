"""Several sources: the newest wish wins, buttons add up."""

import dataclasses as dc

import numpy as np
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder

from remosplat_drake.signals.map_requests import MapRequests
from remosplat_drake.signals.operator_command import OperatorCommand
from remosplat_drake.teleop.command_merger import CommandMerger
from remosplat_drake.teleop.merging import MergedCommand, merge_commands
from remosplat_drake.teleop.trajectory_file import OperatorStep
from remosplat_drake.teleop.trajectory_operator import TrajectoryOperator

PAGE = OperatorCommand(source="page")
STREAM = OperatorCommand(source="stream")


class Sources:
    """The page and a stream."""

    def __init__(self):
        self.page, self.stream = PAGE, STREAM
        self.merged = MergedCommand.silent(2)

    def say(self, page=None, stream=None) -> OperatorCommand:
        self.page = dc.replace(self.page, **(page or {}))
        self.stream = dc.replace(self.stream, **(stream or {}))
        self.merged = merge_commands(self.merged, [self.page, self.stream])
        return self.merged.command


def pose(x: float) -> np.ndarray:
    X = np.eye(4)
    X[0, 3] = x
    return X


def test_the_newest_wish_leads():
    sources = Sources()
    command = sources.say(page={"X_WT": pose(1), "moves": 1})
    assert (command.source, command.moves) == ("page", 1)
    command = sources.say(stream={"X_WT": pose(2), "moves": 1})
    assert (command.source, command.moves) == ("stream", 2)
    assert command.X_WT is sources.stream.X_WT
    command = sources.say(page={"X_WT": pose(3), "moves": 2})
    assert (command.source, command.X_WT) == ("page", sources.page.X_WT)


def test_what_is_taken_is_what_was_requested_last():
    sources = Sources()
    sources.say(page={"thing": "can", "takes": 1})
    command = sources.say(stream={"thing": "box", "takes": 1})
    assert (command.thing, command.takes) == ("box", 2)
    # A request of another kind changes neither object nor place.
    p_W = np.array([1.0, 0.0, 0.5])
    sources.say(page={"support": "tray", "p_WNear": p_W, "places": 1})
    command = sources.say(stream={"holds": 1})
    assert (command.thing, command.support) == ("box", "tray")
    assert command.p_WNear is p_W
    assert (command.takes, command.places, command.holds) == (2, 1, 1)
    sources.say(page={"p_WFind": p_W, "finds": 1})
    command = sources.say(stream={"holds": 2})
    assert command.finds == 1 and command.p_WFind is p_W


def test_a_stream_does_not_lead_on_after_a_hold():
    sources = Sources()
    sources.say(stream={"X_WT": pose(2), "moves": 1})
    held = sources.say(page={"holds": 1})
    after = sources.say(stream={"X_WT": pose(4)})
    assert (held.holds, after.source) == (1, "page")
    assert (after.moves, after.X_WT) == (held.moves, None)


def test_only_the_leaders_trouble_counts():
    sources = Sources()
    sources.say(stream={"X_WT": pose(2), "moves": 1})
    assert sources.say(stream={"trouble": "silent"}).trouble == "silent"
    command = sources.say(page={"X_WT": pose(1), "moves": 1})
    assert command.trouble == ""


def test_the_dead_man_button_leads_when_it_is_pressed():
    sources = Sources()
    sources.say(stream={"X_WT": pose(2), "moves": 1})
    command = sources.say(page={"V_W": np.ones(6)})
    np.testing.assert_array_equal(command.V_W, np.ones(6))
    assert sources.say(page={"V_W": None}).V_W is None


def test_a_picked_pose_keeps_its_name():
    sources = Sources()
    command = sources.say(
        page={"homes": 1}, stream={"pose": "shelf", "poses": 1}
    )
    assert (command.homes, command.pose, command.poses) == (1, "shelf", 1)
    assert sources.say(page={"homes": 2}).pose == "shelf"


def test_a_press_for_the_hand_takes_no_lead():
    sources = Sources()
    sources.say(stream={"X_WT": pose(2), "moves": 1})
    command = sources.say(page={"closes": 1})
    assert command.closes == 1 and command.X_WT[0, 3] == 2


def test_the_system_adds_up_what_scripts_ask():
    builder = DiagramBuilder()
    scripts = [
        [OperatorStep(0.0, press="frame"), OperatorStep(1.0, press="home")],
        [OperatorStep(0.5, translation=[1, 0, 0.5], press="frame")],
    ]
    sources = []
    for i, steps in enumerate(scripts):
        source = TrajectoryOperator(steps=steps)
        source.set_name(f"script {i}")
        sources.append(builder.AddSystem(source))
    merger = CommandMerger.AddToBuilder(builder, sources=sources, period=0.1)
    simulator = Simulator(builder.Build())
    context = merger.GetMyContextFromRoot(simulator.get_mutable_context())

    def at(time: float):
        simulator.AdvanceTo(time)
        return (
            merger.GetOutputPort("command").Eval(context),
            merger.GetOutputPort("map_requests").Eval(context),
        )

    command, requests = at(0.3)
    assert (command.moves, requests) == (0, MapRequests(frames=1))
    command, requests = at(0.7)
    assert (command.moves, requests) == (1, MapRequests(frames=2))
    assert command.X_WT[0, 3] == 1
    command, _ = at(1.2)
    assert (command.moves, command.homes, command.X_WT) == (1, 1, None)


def test_one_source_is_enough():
    merger = CommandMerger(count=1, period=0.1)
    assert merger.num_input_ports() == 2
    assert MergedCommand.silent(1).command.moves == 0
