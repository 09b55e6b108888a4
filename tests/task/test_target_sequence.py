"""Targets, one after the other, judged once a period."""

import numpy as np
import pytest
from pydrake.common.value import Value
from pydrake.math import RigidTransform
from pydrake.systems.analysis import Simulator

from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.signals.target import Target
from remosplat_drake.task.arrival import ArrivalConfig
from remosplat_drake.task.target_sequence import (
    TargetProgress,
    TargetSequence,
    with_ways_onward,
)

PERIOD = 0.1


class Stage:
    """A sequence of two tip poses of the three-link arm, posed by hand."""

    Q_A, Q_B = np.array([0.3, 0.5, 0.0]), np.array([-0.4, 0.8, 0.5])

    def __init__(self, robot):
        self.poses = [
            RigidTransform(robot.end_effector_pose(q))
            for q in (self.Q_A, self.Q_B)
        ]
        self.system = TargetSequence(
            robot=robot,
            X_WTs=self.poses,
            arrival=ArrivalConfig(),
            period=PERIOD,
        )
        self.simulator = Simulator(self.system)
        self.context = self.simulator.get_mutable_context()

    def hold(self, q, periods: int = 1) -> TargetProgress:
        self.system.GetInputPort("configuration").FixValue(self.context, q)
        time = self.context.get_time() + periods * PERIOD
        self.simulator.AdvanceTo(time)
        return self.system.progress(self.context)

    def target(self) -> np.ndarray:
        port = self.system.GetOutputPort("target")
        return port.Eval(self.context).GetAsMatrix4()


@pytest.fixture
def stage(three_link) -> Stage:
    return Stage(three_link)


def test_the_first_target_stays_until_it_is_reached(stage):
    assert stage.hold(np.zeros(3), 3) == TargetProgress(0, 2)
    # Being at the second one does not count yet.
    assert stage.hold(stage.Q_B, 3) == TargetProgress(0, 2)
    np.testing.assert_allclose(stage.target(), stage.poses[0].GetAsMatrix4())


def test_each_arrival_hands_out_the_next_target(stage):
    assert stage.hold(stage.Q_A, 2) == TargetProgress(1, 2)
    np.testing.assert_allclose(stage.target(), stage.poses[1].GetAsMatrix4())
    progress = stage.hold(stage.Q_B, 2)
    assert progress == TargetProgress(2, 2)
    assert progress.finished


def test_after_the_last_target_it_keeps_that_one(stage):
    stage.hold(stage.Q_A, 2)
    stage.hold(stage.Q_B, 2)
    assert stage.hold(np.zeros(3), 3) == TargetProgress(2, 2)
    np.testing.assert_allclose(stage.target(), stage.poses[1].GetAsMatrix4())


def test_the_error_is_to_the_present_target(stage):
    stage.hold(stage.Q_A, 2)
    assert stage.system.error(stage.context).distance == pytest.approx(
        np.linalg.norm(
            stage.poses[0].translation() - stage.poses[1].translation()
        )
    )


def test_an_unknown_configuration_reaches_nothing(stage):
    assert stage.hold(np.full(3, np.nan), 3) == TargetProgress(0, 2)


def test_progress_is_exported(stage):
    stage.hold(stage.Q_A, 2)
    port = stage.system.GetOutputPort("progress")
    assert port.Eval(stage.context) == TargetProgress(1, 2)


class TestWays:
    """Lines begin where the tip is, and what is passed knows the way on."""

    def sequence(self, robot, *targets) -> tuple[TargetSequence, Simulator]:
        system = TargetSequence(robot=robot, X_WTs=targets, period=PERIOD)
        return system, Simulator(system)

    def aim(self, system, context) -> Target:
        return system.GetOutputPort("aim").Eval(context).first

    def test_the_way_behind_what_is_passed_ends_at_a_stop(self):
        def at(x, **how):
            X_WT = np.eye(4)
            X_WT[0, 3] = x
            return Target(X_WT, **how)

        targets = [
            at(0.0, passed_within=0.1),
            at(1.0, passed_within=0.1),
            at(3.0),
            at(9.0, passed_within=0.1),
        ]
        ways = [target.onward for target in with_ways_onward(targets)]
        assert ways == [3.0, 2.0, 0.0, 0.0]

    def test_a_line_begins_where_its_turn_comes(self, three_link):
        poses = [
            three_link.end_effector_pose(q) for q in (Stage.Q_A, Stage.Q_B)
        ]
        line = Target(poses[1]).on_line(poses[1], 0.1)
        system, simulator = self.sequence(
            three_link, Target(poses[0], passed_within=0.2), line
        )
        context = simulator.get_mutable_context()
        assert self.aim(system, context).onward > 0.0
        q = Stage.Q_A + np.array([0.0, 0.02, 0.0])
        system.GetInputPort("configuration").FixValue(context, q)
        simulator.AdvanceTo(1.5 * PERIOD)
        begun = self.aim(system, context)
        assert begun.line is not None
        np.testing.assert_allclose(
            begun.line.X_WA, three_link.end_effector_pose(q)
        )
        # It stays there while the tip goes on.
        system.GetInputPort("configuration").FixValue(context, Stage.Q_A)
        simulator.AdvanceTo(3.5 * PERIOD)
        assert self.aim(system, context).equals(begun)

    def test_a_line_at_once_begins_at_the_start(self, three_link):
        X_WT = three_link.end_effector_pose(Stage.Q_B)
        system, simulator = self.sequence(
            three_link, Target(X_WT).on_line(X_WT, 0.1)
        )
        context = simulator.get_mutable_context()
        system.GetInputPort("configuration").FixValue(context, Stage.Q_A)
        at_once = self.aim(system, context)
        assert at_once.line is not None
        np.testing.assert_allclose(
            at_once.line.X_WA, three_link.end_effector_pose(Stage.Q_A)
        )
        simulator.AdvanceTo(PERIOD)
        assert self.aim(system, context).equals(at_once)


def test_end_effectors_do_not_wait_for_each_other(two_arms):
    q = two_arms.q_home
    left, right = two_arms.end_effector_poses(q)
    elsewhere = left.copy()
    elsewhere[:3, 3] += 0.5
    system = TargetSequence(
        robot=two_arms,
        X_WTs={
            "left": [Target(elsewhere), Target(left)],
            "right": [Target(right), Target(elsewhere)],
        },
        period=PERIOD,
    )
    simulator = Simulator(system)
    context = simulator.get_mutable_context()
    system.GetInputPort("configuration").FixValue(context, q)
    simulator.AdvanceTo(1.5 * PERIOD)
    assert system.progress(context) == TargetProgress(1, 4)
    aim = system.GetOutputPort("aim").Eval(context)
    for _, target in aim.items:
        np.testing.assert_array_equal(target.X_WT, elsewhere)
    far = np.linalg.norm(elsewhere[:3, 3] - right[:3, 3])
    assert system.error(context).distance == pytest.approx(
        max(far, np.sqrt(3) * 0.5)
    )


def test_all_is_reached_when_all_are_there_at_once(two_arms):
    """A hand that has left its last target again has not reached it."""
    there = two_arms.q_home
    only_left, only_right = there.copy(), there.copy()
    only_left[7:], only_right[1:7] = 0.1, 0.1
    X_WTs = two_arms.end_effector_poses(there)
    system = TargetSequence(
        robot=two_arms,
        X_WTs={"left": [Target(X_WTs[0])], "right": [Target(X_WTs[1])]},
        period=PERIOD,
    )
    simulator = Simulator(system)
    context = simulator.get_mutable_context()
    reached = []
    for i, q in enumerate((only_left, only_right, there, only_left)):
        system.GetInputPort("configuration").FixValue(context, q)
        simulator.AdvanceTo((i + 0.5) * PERIOD)
        reached.append(system.progress(context).index)
    assert reached == [1, 1, 2, 2]


def test_who_is_asked_for_nothing_has_no_target(two_arms):
    X_WT = two_arms.end_effector_pose(two_arms.q_home, 1)
    system = TargetSequence(robot=two_arms, X_WTs={"right": [Target(X_WT)]})
    context = system.CreateDefaultContext()
    system.GetInputPort("configuration").FixValue(context, two_arms.q_home)
    aim = system.GetOutputPort("aim").Eval(context)
    assert [i for i, _ in aim.items] == [1]


def test_an_end_effector_that_is_not_there_is_named(two_arms):
    with pytest.raises(RemoSplatError, match=r"'middle'.*left"):
        TargetSequence(robot=two_arms, X_WTs={"middle": [Target(np.eye(4))]})
    with pytest.raises(RemoSplatError, match="needs at least one target"):
        TargetSequence(robot=two_arms, X_WTs={"left": []})


def test_an_operator_replaces_the_present_target(stage):
    stage.hold(stage.Q_A, 2)
    q = np.array([0.1, -0.3, 0.4])
    X_WT = stage.system._robot.end_effector_pose(q)
    instead = stage.system.GetInputPort("instead")
    instead.FixValue(stage.context, Value[object]((Target(X_WT),)))
    assert stage.hold(np.zeros(3), 2) == TargetProgress(1, 2, replaced=1)
    np.testing.assert_allclose(stage.target(), X_WT)
    # The target that was replaced does not count any more.
    assert stage.hold(stage.Q_B, 2).index == 1
    assert stage.hold(q, 2) == TargetProgress(2, 2, replaced=1)
