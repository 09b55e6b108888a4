"""The system: in the place of a target sequence, with the measured robot."""

import dataclasses as dc

import numpy as np
import pytest
from pydrake.common.value import Value
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import ConstantVectorSource

from remosplat_drake.signals.map_requests import MapRequests
from remosplat_drake.signals.operator_command import OperatorCommand
from remosplat_drake.signals.supervisor_state import (
    RUNNING,
    STOPPED,
    STOPPING,
    SupervisorState,
)
from remosplat_drake.signals.target_state import FOLLOW, HOLD
from remosplat_drake.task.target_sequence import TargetProgress
from remosplat_drake.teleop.motion_law import MotionLaw
from remosplat_drake.teleop.operator_target import OperatorTarget
from remosplat_drake.teleop.teleop_config import TeleopConfig
from remosplat_drake.teleop.trajectory_file import OperatorStep
from remosplat_drake.teleop.trajectory_operator import TrajectoryOperator

PERIOD = 0.05
Q0, Q1 = np.array([0.3, 0.5, 0.0]), np.array([-0.4, 0.8, 0.5])
UNKNOWN = np.full(3, np.nan)


class Stage:
    """A target of the three-link arm, which stands where it is put."""

    def __init__(self, robot):
        self.robot = robot
        law = MotionLaw.make(TeleopConfig(), robot, Q0, PERIOD)
        self.system = OperatorTarget(robot=robot, q0=Q0, law=law)
        self.simulator = Simulator(self.system)
        self.context = self.simulator.get_mutable_context()
        self.say(OperatorCommand())

    def say(self, command: OperatorCommand):
        port = self.system.GetInputPort("command")
        port.FixValue(self.context, Value(command))

    def stand(self, q, periods: int = 1) -> np.ndarray:
        port = self.system.GetInputPort("configuration")
        port.FixValue(self.context, q)
        time = self.context.get_time() + periods * PERIOD
        self.simulator.AdvanceTo(time)
        return self.target

    def supervise(self, mode: str) -> None:
        port = self.system.GetInputPort("supervision")
        state = SupervisorState(np.zeros(self.robot.n_u), mode)
        port.FixValue(self.context, Value(state))

    @property
    def target(self) -> np.ndarray:
        port = self.system.GetOutputPort("target")
        return port.Eval(self.context).GetAsMatrix4()


@pytest.fixture
def stage(three_link) -> Stage:
    return Stage(three_link)


def test_it_begins_where_the_robot_is_not_where_it_was_expected(stage):
    """A controller that ticks at the same instant sees no other target."""
    port = stage.system.GetInputPort("configuration")
    port.FixValue(stage.context, Q1)
    X_WE = stage.robot.end_effector_pose(Q1)
    np.testing.assert_allclose(stage.target, X_WE, atol=1e-12)
    np.testing.assert_allclose(stage.stand(Q1), X_WE, atol=1e-12)
    assert stage.system.error(stage.context).distance < 1e-12


def test_it_waits_until_the_robot_is_known(stage):
    expected = stage.robot.end_effector_pose(Q0)
    np.testing.assert_allclose(stage.stand(UNKNOWN, 3), expected, atol=1e-12)
    X_WE = stage.robot.end_effector_pose(Q1)
    np.testing.assert_allclose(stage.stand(Q1, 2), X_WE, atol=1e-12)
    # From now on it rests there, wherever the robot goes.
    np.testing.assert_allclose(stage.stand(Q0, 2), X_WE, atol=1e-12)


def test_it_moves_and_goes_home(stage):
    stage.stand(Q0)
    goal = stage.robot.end_effector_pose(Q1)
    command = OperatorCommand(source="test", X_WT=goal, moves=1)
    stage.say(command)
    np.testing.assert_allclose(stage.stand(Q0, 200), goal, atol=1e-9)
    state = stage.system.GetOutputPort("state").Eval(stage.context)
    assert (state.mode, state.text) == (FOLLOW, "following the test")
    home = stage.robot.end_effector_pose(Q0)
    assert stage.system.error(stage.context).distance == pytest.approx(
        np.linalg.norm(goal[:3, 3] - home[:3, 3])
    )
    stage.say(dc.replace(command, homes=1))
    np.testing.assert_allclose(stage.stand(Q1, 200), home, atol=1e-9)


def test_it_stays_with_a_robot_that_is_stopped(stage):
    goal, home = map(stage.robot.end_effector_pose, (Q1, Q0))
    wish = OperatorCommand(source="test", X_WT=goal, moves=1)
    stage.stand(Q0)
    stage.say(wish)
    stage.supervise(RUNNING)
    stage.stand(Q0, 10)
    assert np.linalg.norm((stage.target - home)[:3, 3]) > 0.02
    for mode in (STOPPING, STOPPED):
        stage.supervise(mode)
        np.testing.assert_allclose(stage.stand(Q0, 2), home, atol=1e-12)
    state = stage.system.state(stage.context)
    assert (state.mode, state.text) == (HOLD, "hold: the robot is stopped")
    # It goes along where the robot is pushed; what is wished now is void.
    np.testing.assert_allclose(stage.stand(Q1, 2), goal, atol=1e-12)
    stage.say(dc.replace(wish, moves=5, X_WT=home, homes=1))
    stage.stand(Q1, 2)
    stage.supervise(RUNNING)
    np.testing.assert_allclose(stage.stand(Q1, 20), goal, atol=1e-12)
    # A wish after the release leads again.
    stage.say(dc.replace(wish, moves=6, X_WT=home, homes=1))
    np.testing.assert_allclose(stage.stand(Q1, 200), home, atol=1e-9)


def test_no_output_depends_on_the_supervisor(stage):
    system = stage.system
    port = int(system.GetInputPort("supervision").get_index())
    outputs = range(system.num_output_ports())
    assert not any(system.HasDirectFeedthrough(port, out) for out in outputs)


def test_it_never_finishes(stage):
    assert stage.system.progress(stage.context) == TargetProgress(0, 1)
    assert not stage.system.progress(stage.context).finished


def test_map_requests_pass_through(stage):
    stage.stand(Q0)
    port = stage.system.GetOutputPort("map_requests")
    assert port.Eval(stage.context) == MapRequests()
    stage.system.GetInputPort("map_requests").FixValue(
        stage.context, Value(MapRequests(frames=2, undos=1))
    )
    assert port.Eval(stage.context) == MapRequests(frames=2, undos=1)


def test_it_obeys_a_script_in_a_diagram(three_link):
    builder = DiagramBuilder()
    q = builder.AddSystem(ConstantVectorSource(Q0))
    steps = [
        OperatorStep(0.2, translation=[0.5, 0.0, 0.8], press="frame"),
        OperatorStep(0.6, press="hold"),
    ]
    script = builder.AddSystem(TrajectoryOperator(steps=steps))
    target = OperatorTarget.AddToBuilder(
        builder,
        configuration=q.get_output_port(),
        command=script.GetOutputPort("command"),
        map_requests=script.GetOutputPort("map_requests"),
        robot=three_link,
        q0=Q0,
        law=MotionLaw.make(TeleopConfig(), three_link, Q0, PERIOD),
    )
    simulator = Simulator(builder.Build())
    context = target.GetMyContextFromRoot(simulator.get_context())
    simulator.AdvanceTo(0.5)
    assert target.state(context).mode == FOLLOW
    requests = target.GetOutputPort("map_requests").Eval(context)
    assert requests == MapRequests(frames=1)
    simulator.AdvanceTo(0.7)
    assert target.state(context).mode == HOLD
    np.testing.assert_allclose(
        target.state(context).X_WT, three_link.end_effector_pose(Q0)
    )
