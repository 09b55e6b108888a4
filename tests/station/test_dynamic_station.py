"""Inertia, motors and contact of the dynamic station."""

import shutil
from pathlib import Path

import numpy as np
import pytest
from pydrake.math import RigidTransform

from remosplat_drake.robot.robot_model import load_robot
from remosplat_drake.scene.primitive_scene import Box, PrimitiveScene
from remosplat_drake.station.simulated_station import MakeSimulatedStation
from remosplat_drake.station.station_config import DynamicStation

DATA = Path(__file__).resolve().parents[1] / "data"


def make(robot, harness, q0, scene=None, hand=None, **settings):
    station = MakeSimulatedStation(
        config=DynamicStation(**settings),
        robot=robot,
        scene=scene,
        q0=q0,
    )
    return harness(station, robot, hand=hand)


def start(robot) -> np.ndarray:
    q0 = np.zeros(robot.n_q)
    q0[robot.n_q - len(robot.home) :] = robot.home
    return q0


@pytest.fixture(params=["frankie", "three_link"])
def robot(request):
    return request.getfixturevalue(request.param)


def test_it_starts_at_q0_and_stays_there(robot, harness):
    """Nothing touches, nothing sags: the arm carries its own weight."""
    q0 = start(robot)
    dut = make(robot, harness, q0)
    np.testing.assert_array_equal(dut.q, q0)
    dut.advance(0.2)
    np.testing.assert_allclose(dut.q, q0, atol=1e-9)
    contact = dut.eval("cheat.contact")
    assert contact.scene == contact.robot == ()


def test_commanded_velocities_are_reached_within_50_ms(robot, harness):
    """A step to a third of each limit, the base's what 400 N allow."""
    signs = np.where(np.arange(robot.n_u) % 2, -1.0, 1.0)
    u = signs * robot.velocity_limit / 3
    if robot.n_base:
        u[:2] = 0.1, 0.3
    dut = make(robot, harness, start(robot))
    dut.command(u)
    dut.advance(0.05)
    np.testing.assert_allclose(dut.u, u, rtol=1e-3)


FLANGE = """
  <link name="flange">
    <inertial><mass value="0.1"/>
      <inertia ixx="1e-4" iyy="1e-4" izz="1e-4" ixy="0" ixz="0" iyz="0"/>
    </inertial>
    <collision><geometry><box size="0.1 0.08 0.08"/></geometry></collision>
  </link>
  <joint name="fix" type="fixed">
    <parent link="wrist"/><child link="flange"/>
  </joint>
"""
"""A link that is fixed to the wrist, and overlaps the forearm before it."""


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("</robot>", f"{FLANGE}</robot>"),
        ('<axis xyz="1 0 0"/>', '<axis xyz="1 0 0"/><dynamics damping="5"/>'),
    ],
    ids=["overlap", "friction"],
)
def test_neither_coarse_shapes_nor_friction_hold_a_joint(
    old, new, tmp_path, harness
):
    """As those of a TIAGo's arm did."""
    for name in ("three_link.yaml", "three_link_spheres.yaml"):
        shutil.copy(DATA / name, tmp_path)
    text = (DATA / "three_link.urdf").read_text()
    assert old in text
    (tmp_path / "three_link.urdf").write_text(text.replace(old, new))
    robot = load_robot(tmp_path / "three_link.yaml")
    dut = make(robot, harness, start(robot))
    dut.command(np.array([0.0, 0.0, 0.5]))
    dut.advance(0.1)
    np.testing.assert_allclose(dut.u, [0, 0, 0.5], atol=0.006)
    assert dut.eval("cheat.contact").robot == ()


def test_a_full_base_command_is_held_back_by_the_motors(frankie, harness):
    """80 kg at 320 N: 0.5 m/s takes 125 ms, not one step."""
    dut = make(frankie, harness, start(frankie))
    dut.command(frankie.velocity_limit * np.eye(9)[0])
    dut.advance(0.05)
    assert 0.1 < dut.u[0] < 0.3
    dut.advance(0.15)
    np.testing.assert_allclose(dut.u[0], 0.5, rtol=0.02)


def test_the_base_does_not_slip_sideways(frankie, harness):
    """A circle at full speed: the velocity stays along the heading."""
    dut = make(frankie, harness, start(frankie))
    u = frankie.velocity_limit * [1, 1, 0, 0, 0, 0, 0, 0, 0]
    dut.command(u)
    dut.advance(0.5)
    dt, q = 0.02, dut.q
    for _ in range(10):
        dut.advance(dt)
        step = dut.q[:2] - q[:2]
        heading = (dut.q[2] + q[2]) / 2
        sideways = -np.sin(heading) * step[0] + np.cos(heading) * step[1]
        assert abs(sideways) / dt < 5e-4  # [m/s], at 0.5 m/s forward.
        q = dut.q


def test_the_path_is_near_the_kinematic_one(frankie, harness):
    dut = make(frankie, harness, start(frankie))
    u = 0.2 * frankie.velocity_limit
    dut.command(u)
    dut.advance(0.5)
    q = frankie.advance(start(frankie), u, 0.5)
    np.testing.assert_allclose(dut.q, q, atol=0.01)


KERB = PrimitiveScene(
    boxes=(Box(RigidTransform([0.7, 0, 0.1]), np.array([0.1, 1, 0.1])),)
)
"""A low block whose face is 0.6 m ahead: the arm passes over it."""


def drive_against_the_kerb(frankie, harness, **settings):
    dut = make(frankie, harness, start(frankie), KERB, **settings)
    dut.command(0.25 * np.eye(9)[0])
    dut.advance(1.5)
    return dut


def test_contact_stops_the_base(frankie, harness):
    """The nose is 0.353 m ahead of B: 0.247 m to go, not 0.375 m."""
    dut = drive_against_the_kerb(frankie, harness)
    np.testing.assert_allclose(dut.q[:3], [0.247, 0, 0], atol=2e-3)
    np.testing.assert_allclose(dut.u[:2], 0, atol=1e-3)
    assert dut.eval("cheat.contact").scene == (("base_link", "box_0"),)


def test_without_collision_it_drives_through(frankie, harness):
    dut = drive_against_the_kerb(frankie, harness, collide_with_scene=False)
    np.testing.assert_allclose(dut.q[0], 0.375, atol=0.015)
    assert dut.eval("cheat.contact").scene == ()


def test_contact_stops_a_fixed_arm(three_link, harness):
    """The arm is swung down onto a block whose far edge is 0.75 m out.

    The forearm is 25 mm thick and the block 0.2 m below the shoulder: it
    rests where 0.75 tan(q) + 0.025 / cos(q) = 0.2, at q = 0.229, not 1 rad.
    """
    block = PrimitiveScene(
        boxes=(Box(RigidTransform([0.7, 0, 0.75]), np.full(3, 0.05)),)
    )
    dut = make(three_link, harness, np.zeros(3), block)
    dut.command(np.array([1.0, 0, 0]))
    dut.advance(1.0)
    np.testing.assert_allclose(dut.q[0], 0.229, atol=0.01)
    assert dut.eval("cheat.contact").scene == (("forearm", "box_0"),)


def test_the_grip_is_as_strong_as_commanded(frankie, harness):
    """Fingers close on a bar 30 mm thick, held by the world, with 15 N."""
    q0 = start(frankie)
    X_WE = RigidTransform(frankie.end_effector_pose(q0))
    bar = PrimitiveScene(boxes=(Box(X_WE, np.array([0.1, 0.015, 0.005])),))
    close = X_WE.rotation().col(1)
    dut = make(frankie, harness, q0, bar, hand=(0.0, 15.0))
    dut.advance(1.0)
    width, rate, force = dut.eval("hand.state")
    np.testing.assert_allclose([width, rate], [0.03, 0], atol=1e-3)
    np.testing.assert_allclose(force, 15.0, rtol=0.01)
    assert dut.eval("cheat.contact").scene == (
        ("panda_leftfinger", "box_0"),
        ("panda_rightfinger", "box_0"),
    )
    plant = dut.station.GetSubsystemByName("plant")
    results = plant.get_contact_results_output_port().Eval(
        plant.GetMyContextFromRoot(dut.context)
    )
    strength = {}
    for i in range(results.num_hydroelastic_contacts()):
        info = results.hydroelastic_contact_info(i)
        surface = info.contact_surface()
        pair = {surface.id_M(), surface.id_N()}
        for name in ("panda_leftfinger", "panda_rightfinger"):
            body = plant.GetBodyByName(name)
            if pair & set(plant.GetCollisionGeometriesForBody(body)):
                force = info.F_Ac_W().translational()
                strength[name] = strength.get(name, 0) + abs(force @ close)
    np.testing.assert_allclose(list(strength.values()), 15.0, rtol=0.05)


def test_the_hand_opens_and_closes(frankie, harness):
    dut = make(frankie, harness, start(frankie), hand=(0.0, 20.0))
    np.testing.assert_allclose(dut.eval("hand.state"), [0.08, 0, 0])
    dut.advance(0.2)
    np.testing.assert_allclose(dut.eval("hand.state")[1], -0.1, rtol=0.01)
    dut.advance(1.2)
    np.testing.assert_allclose(dut.eval("hand.state")[:2], 0, atol=1e-4)
    dut.fix("hand.command", [0.05, 20.0])
    dut.advance(1.0)
    np.testing.assert_allclose(dut.eval("hand.state")[:2], [0.05, 0], atol=1e-4)


def test_each_hand_has_motors_of_its_own(two_pandas, harness):
    dut = make(two_pandas, harness, two_pandas.q_home)
    dut.fix("left_hand.command", [0.03, 20.0])
    dut.advance(1.0)
    for side, width in (("left", 0.03), ("right", 0.08)):
        reading = dut.eval(f"{side}_hand.state")
        np.testing.assert_allclose(reading[:2], [width, 0], atol=1e-4)
    np.testing.assert_allclose(dut.q, two_pandas.q_home, atol=1e-3)


def test_without_a_hand_command_the_width_stays(frankie, harness):
    dut = make(frankie, harness, start(frankie))
    dut.advance(0.2)
    np.testing.assert_allclose(dut.eval("hand.state"), [0.08, 0, 0], atol=1e-9)


def test_a_command_that_is_not_finite_stops_the_robot(frankie, harness):
    dut = make(frankie, harness, start(frankie))
    dut.command(0.1 * frankie.velocity_limit)
    dut.advance(0.1)
    dut.command(np.full(9, np.nan))
    dut.advance(0.1)
    q = dut.q
    dut.advance(0.1)
    status = dut.eval("status")
    assert status.mode == "stopped"
    assert "base.velocity_commanded, panda" in status.stop_reason
    np.testing.assert_allclose(dut.q, q, atol=1e-4)
    assert np.isfinite(dut.q).all()
