"""Targets, one after the other, judged once a period."""

import numpy as np
import pytest
from pydrake.math import RigidTransform
from pydrake.systems.analysis import Simulator

from remosplat_drake.task.arrival import ArrivalConfig
from remosplat_drake.task.target_sequence import TargetProgress, TargetSequence

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
