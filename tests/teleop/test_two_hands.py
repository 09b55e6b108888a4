"""Of several hands an operator moves one, and the others stay."""

import dataclasses as dc

import numpy as np
import pytest
from pydrake.common.value import Value
from pydrake.systems.analysis import Simulator

from remosplat_drake.signals.operator_command import OperatorCommand
from remosplat_drake.signals.supervisor_state import STOPPED, SupervisorState
from remosplat_drake.signals.target_state import FOLLOW, HOLD
from remosplat_drake.teleop.merging import MergedCommand, merge_commands
from remosplat_drake.teleop.motion_law import MotionLaw
from remosplat_drake.teleop.operator_target import OperatorTarget
from remosplat_drake.teleop.teleop_config import TeleopConfig

PERIOD = 0.05
LEFT, RIGHT = 0, 1


class Stage:
    """The targets of two arms, which stand where they are put."""

    def __init__(self, robot):
        self.robot, q0 = robot, robot.q_home
        laws = [
            MotionLaw.make(TeleopConfig(), robot, q0, PERIOD, effector=i)
            for i in (LEFT, RIGHT)
        ]
        self.system = OperatorTarget(robot=robot, q0=q0, law=laws)
        self.simulator = Simulator(self.system)
        self.context = self.simulator.get_mutable_context()
        self.command = OperatorCommand()
        self.say()
        self.stand(q0)

    def say(self, **changes):
        self.command = dc.replace(self.command, **changes)
        port = self.system.GetInputPort("command")
        port.FixValue(self.context, Value(self.command))

    def choose(self, effector: str, **changes):
        choices = self.command.choices + 1
        self.say(effector=effector, choices=choices, **changes)

    def move(self, effector: int, step: float):
        X_WT = self.robot.end_effector_pose(self.robot.q_home, effector)
        X_WT[2, 3] += step
        self.say(X_WT=X_WT, moves=self.command.moves + 1)
        return X_WT

    def stand(self, q: np.ndarray, periods: int = 1):
        port = self.system.GetInputPort("configuration")
        port.FixValue(self.context, q)
        time = self.context.get_time() + periods * PERIOD
        self.simulator.AdvanceTo(time)

    @property
    def state(self):
        return self.system.GetOutputPort("state").Eval(self.context)

    @property
    def targets(self) -> list[np.ndarray]:
        aim = self.system.GetOutputPort("aim").Eval(self.context)
        return [target.X_WT for target in aim.targets]


@pytest.fixture
def stage(two_arms) -> Stage:
    return Stage(two_arms)


def home(stage: Stage) -> np.ndarray:
    return stage.robot.end_effector_poses(stage.robot.q_home)


def test_each_hand_has_a_target_from_the_start(stage):
    np.testing.assert_allclose(stage.targets, home(stage), atol=1e-12)
    assert stage.state.effector == LEFT
    np.testing.assert_allclose(stage.state.X_WTs, home(stage), atol=1e-12)


def test_the_first_moves_and_the_other_stays(stage):
    X_WT = stage.move(LEFT, -0.1)
    stage.stand(stage.robot.q_home, periods=60)
    left, right = stage.targets
    np.testing.assert_allclose(left, X_WT, atol=1e-3)
    np.testing.assert_allclose(right, home(stage)[RIGHT], atol=1e-12)


def test_a_chosen_hand_moves_and_the_one_before_holds_where_it_is(stage):
    stage.move(LEFT, -0.1)
    stage.stand(stage.robot.q_home, periods=3)
    stage.choose("right", X_WT=None)
    stage.stand(stage.robot.q_home)
    assert (stage.state.effector, stage.state.mode) == (RIGHT, HOLD)
    # What was wished for of the left hand is void: it is held where it is.
    np.testing.assert_allclose(stage.targets, home(stage), atol=1e-12)
    X_WT = stage.move(RIGHT, -0.1)
    stage.stand(stage.robot.q_home, periods=60)
    left, right = stage.targets
    np.testing.assert_allclose(right, X_WT, atol=1e-3)
    np.testing.assert_allclose(left, home(stage)[LEFT], atol=1e-12)
    port = stage.system.GetOutputPort("target")
    np.testing.assert_allclose(
        port.Eval(stage.context).GetAsMatrix4(), X_WT, atol=1e-3
    )


def test_presses_for_one_hand_are_not_made_up_for_by_the_other(stage):
    """A press of Home is the left hand's, though the right one is next."""
    stage.say(homes=1)
    stage.stand(stage.robot.q_home)
    stage.choose("right")
    stage.stand(stage.robot.q_home, periods=2)
    assert stage.state.mode == HOLD
    stage.choose("left")
    stage.stand(stage.robot.q_home, periods=2)
    assert stage.state.mode == HOLD


def test_a_choice_and_a_wish_at_once_are_the_chosen_hands(stage):
    X_WT = home(stage)[RIGHT].copy()
    X_WT[0, 3] += 0.05
    stage.choose("right", X_WT=X_WT, moves=1)
    stage.stand(stage.robot.q_home)
    assert (stage.state.effector, stage.state.mode) == (RIGHT, FOLLOW)


def test_a_stop_holds_all_hands_where_they_are(stage):
    stage.move(LEFT, -0.1)
    stage.stand(stage.robot.q_home, periods=3)
    stopped = SupervisorState(np.zeros(stage.robot.n_u), STOPPED)
    port = stage.system.GetInputPort("supervision")
    port.FixValue(stage.context, Value(stopped))
    q = stage.robot.q_home + 0.1
    stage.stand(q)
    X_WEs = stage.robot.end_effector_poses(q)
    np.testing.assert_allclose(stage.targets, X_WEs, atol=1e-12)
    assert "stopped" in stage.state.text


def test_of_several_sources_the_newest_choice_counts():
    page = OperatorCommand(source="page", effector="right", choices=1)
    script = OperatorCommand(source="script")
    merged = merge_commands(MergedCommand.silent(2), [page, script])
    assert (merged.command.effector, merged.command.choices) == ("right", 1)
    # Moving without a choice leaves it.
    script = dc.replace(script, X_WT=np.eye(4), moves=1)
    merged = merge_commands(merged, [page, script])
    assert merged.command.source == "script"
    assert (merged.command.effector, merged.command.choices) == ("right", 1)
    script = dc.replace(script, effector="left", choices=1)
    merged = merge_commands(merged, [page, script])
    assert (merged.command.effector, merged.command.choices) == ("left", 2)
