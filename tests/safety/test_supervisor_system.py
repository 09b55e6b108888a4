"""The supervisor in the wired diagram: no delay, and safe stops."""

import dataclasses as dc
from pathlib import Path

import numpy as np
import pytest
from effort import effort
from pydrake.common.value import Value
from pydrake.math import RigidTransform
from pydrake.systems.analysis import ApplySimulatorConfig, Simulator

from remosplat_drake.app.diagram import Application, build
from remosplat_drake.app.run_result import REACHED
from remosplat_drake.app.scenario import load_scenario
from remosplat_drake.app.simulation import run
from remosplat_drake.app.world import load_world
from remosplat_drake.generation.scene_generators import generate
from remosplat_drake.oracle.signed_distance import SignedDistanceField
from remosplat_drake.scene.primitive_scene import Box, PrimitiveScene
from remosplat_drake.scene.rmmi import write_rmmi
from remosplat_drake.signals.operator_requests import OperatorRequests
from remosplat_drake.signals.supervisor_state import (
    RUNNING,
    STOPPED,
    STOPPING,
    SupervisorState,
)
from remosplat_drake.station.station_config import kinematic_simulator_config

DT = 0.02


@pytest.fixture
def folder(tmp_path) -> Path:
    """A table with things on it, by its true geometry."""
    write_rmmi(tmp_path / "scene.json", generate("table", 4))
    (tmp_path / "test.yaml").write_text(
        "Test:\n"
        "  scene: {truth: scene.json}\n"
        "  oracle: !GroundTruth {}\n"
        f"  control_period: {DT}\n"
        "  time_limit: 3\n"
    )
    return tmp_path


def make_application(folder: Path, text: str = "") -> Application:
    scenario = load_scenario(f"{folder}/test.yaml", text)
    return build(scenario, load_world(scenario))


class Stepper:
    """Runs an application tick by tick."""

    def __init__(self, application: Application):
        self.application = application
        self.simulator = Simulator(application.diagram)
        ApplySimulatorConfig(kinematic_simulator_config(DT), self.simulator)
        self.root = self.simulator.get_mutable_context()
        self.supervisor = application.supervisor
        assert self.supervisor is not None
        self.context = self.supervisor.GetMyMutableContextFromRoot(self.root)
        self.k = 0

    def advance(self, ticks: int = 1) -> SupervisorState:
        """Up to just before the tick that follows."""
        self.k += ticks
        self.simulator.AdvanceTo(self.k * DT - 1e-6)
        return self.state

    @property
    def state(self) -> SupervisorState:
        return self.supervisor.supervision(self.context)

    @property
    def q(self) -> np.ndarray:
        port = self.application.configuration
        system = port.get_system()
        return np.array(port.Eval(system.GetMyContextFromRoot(self.root)))

    def stop(self):
        self.supervisor.request_stop(self.context, "test")

    def ask(self, requests: OperatorRequests):
        port = self.supervisor.GetInputPort("operator")
        port.FixValue(self.context, Value(requests))

    def release(self):
        self.supervisor.request_release(self.context)


@pytest.mark.parametrize(
    ("gains", "station"),
    [
        ("tuned", "!DynamicStation"),
        ("paper", "!KinematicStation"),
        pytest.param("tuned", "!KinematicStation", marks=pytest.mark.slow),
        pytest.param("paper", "!DynamicStation", marks=pytest.mark.slow),
    ],
)
def test_a_supervised_run_is_the_same_to_the_last_bit(folder, gains, station):
    text = f"controller: {{gains: {gains}}}, station: {station} {{}}"
    with_it, without = (
        run(
            make_application(
                folder,
                f"{{{text}, time_limit: 0.8,"
                f" supervisor: {{enabled: {enabled}}}}}",
            )
        ).trajectory
        for enabled in ("true", "false")
    )
    assert np.abs(with_it.u).max() > 0.3
    np.testing.assert_array_equal(with_it.u, without.u)
    np.testing.assert_array_equal(with_it.q, without.q)


def test_a_command_acts_from_the_tick_that_decided_it(folder):
    """The state reached is the one that the controller verified."""
    dut = Stepper(make_application(folder))
    robot = dut.application.world.robot
    q = dut.q
    for _ in range(50):
        command = dut.advance().command
        q = robot.advance(q, command, DT)
        # It is looked at a microsecond before the tick ends.
        np.testing.assert_allclose(dut.q, q, atol=3e-6)
    assert dut.state.mode == RUNNING


@pytest.mark.parametrize("tick", effort([15, 65], [15, 40, 65, 90]))
def test_a_stop_at_any_tick_keeps_the_clearance(folder, tick):
    """The ramp is the one that verification has checked."""
    application = make_application(folder)
    robot, field = application.world.robot, application.world.field
    n = len(robot.spheres)

    def clearance():
        return field.clearances(robot.spheres_at(dut.q)).per_sphere(n)

    dut = Stepper(application)
    start = clearance()
    dut.advance(tick)
    dut.stop()
    speed = dut.state.command
    ticks = 0
    while dut.advance().mode == STOPPING:
        ticks += 1
        floor = np.minimum(
            application.scenario.controller.collision.stopping, start
        )
        assert (clearance() >= floor - 1e-6).all()
    limit = robot.acceleration_limit
    assert ticks * DT <= (np.abs(speed) / limit).max()
    assert dut.state.mode == STOPPED
    rest = dut.q
    dut.advance(50)
    np.testing.assert_array_equal(dut.q, rest)


def test_after_a_release_the_controller_starts_from_rest(folder):
    dut = Stepper(make_application(folder))
    limit = dut.application.world.robot.acceleration_limit
    dut.advance(40)
    dut.stop()
    dut.advance(60)
    assert dut.state.mode == STOPPED
    assert dut.state.reason == "test"
    dut.release()
    before = np.zeros(len(limit))
    for _ in range(20):
        command = dut.advance().command
        assert (np.abs(command - before) <= limit * DT * (1 + 1e-9)).all()
        before = command
    assert dut.state.mode == RUNNING
    assert np.abs(before).max() > 0.1


def test_a_stop_button_that_is_not_heard_stops_and_keeps_the_robot(folder):
    dut = Stepper(make_application(folder))
    dut.advance(20)
    deaf = OperatorRequests(trouble="STOP is not heard")
    dut.ask(deaf)
    dut.advance(60)
    assert (dut.state.mode, dut.state.reason) == (STOPPED, deaf.trouble)
    dut.ask(dc.replace(deaf, releases=1))
    dut.advance(5)
    assert dut.state.mode == STOPPED
    assert dut.state.refusal == f"not released: {deaf.trouble}"
    dut.ask(OperatorRequests(releases=1))
    dut.advance(5)
    assert dut.state.mode == STOPPED
    dut.ask(OperatorRequests(releases=2))
    dut.advance(60)
    assert dut.state.mode == RUNNING


def test_the_command_changes_at_ticks_only(folder):
    """A request between two ticks waits for the next one."""
    dut = Stepper(make_application(folder))
    dut.advance(20)
    command = dut.state.command
    dut.stop()
    np.testing.assert_array_equal(dut.state.command, command)
    dut.release()
    np.testing.assert_array_equal(dut.state.command, command)
    assert dut.state.mode == RUNNING


@pytest.mark.parametrize("start", [0.005, 0.01, 0.015])
def test_a_run_that_starts_too_near_arrives(frankie, tmp_path, start):
    """A plate stands behind a careful base, the target before it."""

    def scene(x: float) -> PrimitiveScene:
        plate = Box(RigidTransform([x, 0, 0.5]), np.array([0.02, 1, 1]))
        X_WT = RigidTransform(frankie.end_effector_pose(frankie.q_home))
        X_WT = RigidTransform([0.6, 0, 0]) @ X_WT
        return PrimitiveScene(boxes=(plate,), X_WE_target=X_WT)

    spheres = frankie.spheres_at(frankie.q_home)
    gap = SignedDistanceField(scene(-1.0)).clearances(spheres).minimum()
    write_rmmi(tmp_path / "scene.json", scene(-1.0 + gap - start))
    (tmp_path / "test.yaml").write_text(
        "Test:\n"
        "  scene: {truth: scene.json}\n"
        "  oracle: !GroundTruth {}\n"
        "  controller:\n"
        "    guidance: {enabled: false}\n"
        "    velocity_limits: {fraction: 0.1}\n"
        f"  control_period: {DT}\n"
        "  time_limit: 30\n"
    )
    application = make_application(tmp_path)
    field, q = application.world.field, application.world.q0
    d_0 = field.clearances(frankie.spheres_at(q)).minimum()
    assert d_0 == pytest.approx(start, abs=1e-6)
    result = run(application)
    assert result.outcome == REACHED
    least = min(
        field.clearances(frankie.spheres_at(q)).minimum()
        for q in result.trajectory.q
    )
    assert least >= d_0 - 1e-9
