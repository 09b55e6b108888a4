"""Faults of a start are reported before anything moves."""

import dataclasses as dc

import numpy as np
import pytest
from pydrake.math import RigidTransform

from remosplat_drake.app.scenario import load_scenario
from remosplat_drake.app.start import lacking, leads_out, start_gates
from remosplat_drake.app.world import World, load_world
from remosplat_drake.commands.main import USER_ERROR, main
from remosplat_drake.controller.tick.reactive_law import ReactiveLaw
from remosplat_drake.controller.tick.run_tick import run_tick
from remosplat_drake.oracle.signed_distance import SignedDistanceField
from remosplat_drake.robot.robot_model import load_robot
from remosplat_drake.safety.gates import (
    NO_WAY_OUT,
    START_BEYOND_LIMITS,
    START_TOO_NEAR,
    TARGET_OUT_OF_REACH,
)
from remosplat_drake.scene.primitive_scene import Box, PrimitiveScene

FOLDED = "[0.0044, -3.0174, -0.3891, 1.5374, 2.9742, -1.4463]"
"""A UR5e whose wrist is inside its forearm, with two of its shapes."""

BEYOND = "[0, 0, 0, -0.02, 0, 1.5, 0]"
"""A Panda's elbow, straighter than it can be."""

HINGE = """
<robot name="hinge">
  <link name="foot"/><link name="arm"/>
  <joint name="turn" type="revolute"><parent link="foot"/><child link="arm"/>
    <axis xyz="0 0 1"/>
    <limit lower="-2" upper="2" effort="1" velocity="1"/></joint>
</robot>
"""
DESCRIPTION = """
name: hinge
model: hinge.urdf
arm: {joints: [turn], mount: foot}
end_effector_frame: arm
velocity_limits: [1]
acceleration_limits: [10]
home: [0]
spheres: {covering: spheres.yaml}
"""


@pytest.fixture
def hinge(tmp_path):
    """A sphere of 5 cm that turns about a hinge in another one, 0.5 m away."""
    (tmp_path / "hinge.urdf").write_text(HINGE)
    (tmp_path / "hinge.yaml").write_text(DESCRIPTION)
    (tmp_path / "spheres.yaml").write_text(
        "spheres: {foot: [[0, 0, 0, 0.05]], arm: [[0.5, 0, 0, 0.05]]}"
    )
    return load_robot(tmp_path / "hinge.yaml")


def between_walls(robot, *sides: float) -> World:
    """Walls 10 mm from both spheres, on some sides of them."""
    half = np.array([1.0, 0.1, 1.0])
    boxes = tuple(
        Box(RigidTransform([0.5, side * 0.16, 0]), half, f"wall {side:+.0f}")
        for side in sides
    )
    scene = PrimitiveScene(boxes=boxes)
    field = SignedDistanceField(scene)
    return World(robot, None, scene, field, robot.q_home)


def test_a_start_between_two_walls_leads_nowhere(hinge):
    scenario, world = load_scenario("PandaReach"), between_walls(hinge, 1, -1)
    (gate,) = start_gates(scenario, world)
    assert gate.name == NO_WAY_OUT
    assert gate.leads_to(False) == gate.leads_to(True) == "refusal"
    assert "arm and the wall" in gate.problem and "10 mm apart" in gate.problem


def test_a_start_beside_one_wall_leads_out(hinge):
    scenario, world = load_scenario("PandaReach"), between_walls(hinge, 1)
    (gate,) = start_gates(scenario, world)
    assert gate.name == START_TOO_NEAR
    assert gate.problem == (
        "robot.arm: arm and the wall +1 are 10 mm apart; the robot must keep 21"
        " mm from the scene"
    )
    law = ReactiveLaw.make(scenario.controller, hinge, 0.01)
    assert leads_out(law, world)
    # Of the foot, the arm, and the joint.
    of_each = lacking(law, world, world.q0)
    np.testing.assert_allclose(of_each, [0.0, 0.011, 0.0], atol=1e-12)


def test_what_no_command_moves_does_not_count(hinge):
    """The arm has turned away; the foot stays where it is."""
    world = between_walls(hinge, 1)
    still = dc.replace(world, robot=hinge, q0=np.array([-0.5]))
    assert not start_gates(load_scenario("PandaReach"), still)


def test_a_joint_beyond_its_limits_is_named():
    text = f"{{robot: {{arm: {BEYOND}}}}}"
    scenario = load_scenario("PandaReach", text)
    gates = start_gates(scenario, load_world(scenario))
    assert [gate.name for gate in gates] == [START_BEYOND_LIMITS]
    assert gates[0].problem.startswith("robot.arm: panda_joint4 is beyond")


def test_copied_numbers_are_within_the_limits():
    text = "{robot: {arm: [0, 0, 0, -0.06975, 0, 1.5, 0]}}"
    scenario = load_scenario("PandaReach", text)
    world = load_world(scenario)
    assert world.q0[3] == world.robot.position_upper[3]
    assert not start_gates(scenario, world)


def run(name: str, text: str) -> int:
    return main(["run", name, "--headless", "--scenario-text", text])


def test_a_folded_arm_is_told_so_and_moves_out(capfd):
    text = f"{{time_limit: 0.2, robot: {{arm: {FOLDED}}}}}"
    assert run("Ur5eReach", text) == 1
    captured = capfd.readouterr()
    assert (
        f"warning: {START_TOO_NEAR}: robot.arm: forearm and flange overlap by"
        " 11 mm; links must keep 10 mm from each other" in captured.err
    )
    assert "moving out: " in captured.out


def test_a_target_out_of_reach_is_told_with_its_field(capfd):
    text = "{time_limit: 0.1, targets: [{translation: [3, 0, 0.5]}]}"
    assert run("PandaReach", text) == 1
    said = capfd.readouterr().err
    assert f"warning: {TARGET_OUT_OF_REACH}: targets[0].translation: " in said
    assert "m out of reach of the arm, which is " in said


def test_each_arm_has_a_reach_of_its_own():
    """The left one's target is beyond it, though the right one is as long."""
    near, far = "[0.5, -0.3, 0.5]", "[0.5, 2.5, 0.5]"
    scenario = load_scenario(
        "TwoPandasReach",
        "{targets: [{effector: right, translation: " + near + "},"
        " {effector: left, translation: " + far + "}]}",
    )
    gates = start_gates(scenario, load_world(scenario))
    assert [g.name for g in gates] == [TARGET_OUT_OF_REACH]
    assert gates[0].problem.startswith("targets[1].translation: ")


def test_a_real_robot_is_refused_unless_it_is_accepted(capfd):
    text = f"{{robot: {{arm: {BEYOND}}}}}"
    code = main(
        [
            *("run", "TableReach", "--hardware", "--rehearsal", "--headless"),
            *("--without-doctor", "--scenario-text", text),
        ]
    )
    assert code == USER_ERROR
    said = capfd.readouterr().err.splitlines()[-1]
    assert "robot.arm: panda_joint4 is beyond its limits" in said
    assert f"--accept {START_BEYOND_LIMITS}" in said


def test_a_folded_arm_gets_out():
    """Nothing that is too near comes nearer, and all of it parts."""
    scenario = load_scenario("Ur5eReach", f"{{robot: {{arm: {FOLDED}}}}}")
    scenario.controller.solver = "active_set"
    world = load_world(scenario)
    robot, q, u = world.robot, world.q0, np.zeros(world.robot.n_u)
    law = ReactiveLaw.make(scenario.controller, robot, 0.01)
    at_start = lacking(law, world, q)
    X_WE = robot.end_effector_pose(q)
    assert at_start.max() > 0.02
    for tick in range(800):
        near = world.field.clearances(robot.spheres_at(q), 0.5)
        report = run_tick(law, 0.01 * tick, q, X_WE, near, world.field, u)
        u = report.command
        q = robot.advance(q, u, 0.01)
        now = lacking(law, world, q)
        assert (now <= at_start + 1e-9).all()
        if now.max() < 1e-6:
            return
    pytest.fail(f"{1e3 * now.max():.2f} mm are lacking still")
