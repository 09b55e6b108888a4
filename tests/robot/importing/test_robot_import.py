"""From a ROS package to a robot of ours, with nothing written by hand."""

import shutil
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("trimesh")

from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import MultibodyPlant
from toy_robot import toy_urdf, write_toy

from remosplat_drake.base.errors import FieldError, FileError, RemoSplatError
from remosplat_drake.robot.importing.findings import Findings
from remosplat_drake.robot.importing.packages import Packages
from remosplat_drake.robot.importing.robot_import import (
    ImportRequest,
    import_robot,
)
from remosplat_drake.robot.importing.sources import read_robot
from remosplat_drake.robot.robot_model import RobotModel, load_robot
from remosplat_drake.station.motors import make_motors
from remosplat_drake.station.station_config import DynamicStation

TOLERANCE = 0.03

GEARED = """
  <transmission name="geared">
    <type>transmission_interface/SimpleTransmission</type>
    <joint name="joint_1">
      <hardwareInterface>EffortJointInterface</hardwareInterface>
    </joint>
    <actuator name="motor"><mechanicalReduction>100</mechanicalReduction>
    </actuator>
  </transmission>"""
"""A transmission as robots' files have them, with what Drake does not know."""


def imported(
    folder: Path, text: str | None = None, **request
) -> tuple[RobotModel, Findings, Path]:
    source = write_toy(folder, text)
    out, findings = folder / "out", Findings()
    out.mkdir()
    wanted = ImportRequest(source, tolerance=TOLERANCE, **request)
    robot = import_robot(wanted, out, findings)
    # What was made stands alone.
    shutil.rmtree(source.parents[1])
    return robot, findings, out


@pytest.fixture(scope="module")
def toy(tmp_path_factory) -> tuple[RobotModel, Findings, Path]:
    return imported(tmp_path_factory.mktemp("toy"), toy_urdf(GEARED))


def test_the_folder_can_be_moved(toy, tmp_path, monkeypatch):
    robot, _, out = toy
    shutil.copytree(out, tmp_path / "elsewhere")
    monkeypatch.chdir(tmp_path)
    again = load_robot("elsewhere/toy.yaml")
    np.testing.assert_array_equal(
        again.end_effector_pose(again.q_home),
        robot.end_effector_pose(robot.q_home),
    )


def test_it_moves_as_the_file_it_came_from(toy, tmp_path):
    robot, _, _ = toy
    # Drake reads the original but for its mesh, which is in millimetres.
    plant = MultibodyPlant(time_step=0.0)
    text = toy_urdf()
    start, end = text.index("<mesh"), text.index("/>", text.index("<mesh")) + 2
    text = text[:start] + '<sphere radius="0.05"/>' + text[end:]
    Parser(plant).AddModelsFromString(text, "urdf")
    plant.WeldFrames(plant.world_frame(), plant.GetFrameByName("pedestal"))
    plant.Finalize()
    context = plant.CreateDefaultContext()
    rng = np.random.default_rng(0)
    for q in rng.uniform(-2, 2, (10, 6)):
        plant.SetPositions(context, q)
        X_WE = plant.GetFrameByName("tool0").CalcPoseInWorld(context)
        np.testing.assert_allclose(
            robot.end_effector_pose(q), X_WE.GetAsMatrix4(), atol=1e-12
        )


def test_what_was_found_and_what_was_guessed_are_told_apart(toy):
    robot, findings, out = toy
    found, guessed = dict(findings.found), dict(findings.guessed)
    assert found["velocity limits"].startswith("2, 2")
    assert robot.velocity_limit.tolist() == [2, 2, 2, 2, 3, 2]
    assert robot.acceleration_limit.tolist() == [8, 8, 8, 8, 12, 8]
    for what in ("acceleration limits", "home", "base", "end effector"):
        assert what in guessed
    text = (out / "toy.yaml").read_text()
    for value in guessed.values():
        assert value in text


@pytest.mark.slow
def test_links_that_do_not_meet_are_doubted(toy, tmp_path):
    assert not toy[1].doubted
    # The shoulder, four times as far from the pedestal.
    near, far = '<origin xyz="0 0 0.1"/><axis', '<origin xyz="0 0 0.4"/><axis'
    text = toy_urdf().replace(near, far, 1)
    _, findings, out = imported(tmp_path, text)
    ((what, value),) = findings.doubted
    assert what == "joint joint_1"
    assert value.startswith("shoulder is 300 mm away from pedestal")
    assert f"# DOUBTFUL: {what}: {value}" in (out / "toy.yaml").read_text()


def test_the_spheres_enclose_the_links_within_the_tolerance(toy):
    robot, _, _ = toy
    # Points of the upper arm, a cylinder of radius 4 cm and length 35 cm.
    spheres = robot.spheres.on_link("upper_arm")
    z, angle = np.meshgrid(np.linspace(0, 0.35, 40), np.linspace(0, 6.28, 40))
    points = np.stack([0.04 * np.cos(angle), 0.04 * np.sin(angle), z], axis=-1)
    assert spheres.outside(points.reshape(-1, 3)).max() <= 0
    assert spheres.radius.max() < 0.04 + 2 * TOLERANCE
    # The hand is a box of 6 by 4 by 8 cm, and twice as tight.
    hand = robot.spheres.on_link("hand")
    half = np.array([0.03, 0.02, 0.04])
    corners = [0, 0, 0.04] + half * [[1, 1, 1], [-1, -1, -1]]
    assert hand.outside(corners).max() <= 0


def test_the_home_is_able_clear_and_inside_the_limits(toy):
    robot, _, _ = toy
    q = robot.q_home
    assert (q > robot.position_lower).all()
    assert (q < robot.position_upper).all()
    state = robot.state(q)
    J = np.concatenate([state.Jv_WE, state.Jw_WE])
    assert np.linalg.svd(J, compute_uv=False).min() > 0.02
    assert state.X_WE[0, 3] > 0


def test_a_simulated_robot_of_it_has_motors(toy):
    robot, _, out = toy
    motors = make_motors(robot, (), robot.q_home, DynamicStation())
    assert list(motors.joints) == robot.joint_names
    # Those of its file, with gears that Drake has not, are gone.
    text = (out / "toy.urdf").read_text()
    assert text.count("<transmission") == len(robot.joint_names)
    assert "EffortJointInterface" not in text


@pytest.mark.slow
def test_a_differential_base_drives_on_the_floor(tmp_path):
    # The pedestal's lowest point is its origin; the robot is put 5 cm higher.
    text = toy_urdf().replace('xyz="0 0 0.05"', 'xyz="0 0 0.1"', 1)
    robot, findings, _ = imported(tmp_path, text, base="differential")
    assert robot.n_base == 2
    assert robot.description.floor_links == ["pedestal"]
    low = robot.spheres_at(np.zeros(robot.n_q))
    on = [link == "pedestal" for link in robot.spheres.links]
    bottom = (low.p_WS[:, 2] - low.radius)[on].min()
    assert -0.05 < bottom <= 0.001
    assert "0.050 m" in dict(findings.guessed)["floor"].replace("-", "")
    q = robot.advance(robot.q_home, np.array([1.0, 0, *[0] * 6]), 1.0)
    assert q[0] == 1.0


@pytest.mark.slow
def test_an_omnidirectional_base_slides_to_the_side(tmp_path):
    robot, _, _ = imported(tmp_path, base="omni")
    assert robot.n_u == 9
    u = np.zeros(9)
    u[1] = 0.4
    before = robot.end_effector_pose(robot.q_home)
    after = robot.end_effector_pose(robot.advance(robot.q_home, u, 1.0))
    np.testing.assert_allclose(after[:3, 3] - before[:3, 3], [0, 0.4, 0])


def test_a_missing_package_is_told_before_anything_is_made(tmp_path):
    source = write_toy(tmp_path)
    text = source.read_text().replace("toy_description", "lost/elsewhere")
    source.write_text(text)
    out = tmp_path / "out"
    out.mkdir()
    with pytest.raises(
        FieldError,
        match=r"link 'hand' <collision> <mesh>: no package 'lost'.*"
        r"--package lost=DIR",
    ):
        import_robot(ImportRequest(source), out, Findings())


@pytest.mark.parametrize(
    ("name", "text", "message"),
    [
        ("none.urdf", None, "no such file"),
        ("arm.txt", "x", "expected URDF, xacro, SDFormat, MJCF"),
        ("arm.urdf", b"\xff\xfe\x00", "cannot be read"),
    ],
)
def test_files_that_are_no_robot_are_told(tmp_path, name, text, message):
    path = tmp_path / name
    if text is not None:
        path.write_bytes(text if isinstance(text, bytes) else text.encode())
    with pytest.raises(FileError, match=message):
        import_robot(ImportRequest(path), tmp_path, Findings())


@pytest.mark.slow
def test_a_package_that_a_xacro_needs_is_asked_for_once(tmp_path):
    pytest.importorskip("xacro")
    source = write_toy(tmp_path).with_name("toy.xacro")
    source.write_text(
        '<robot name="toy" xmlns:xacro="http://wiki.ros.org/xacro">'
        '<xacro:include filename="$(find elsewhere)/a.xacro"/></robot>'
    )
    with pytest.raises(FieldError) as caught:
        import_robot(ImportRequest(source), tmp_path, Findings())
    said = str(caught.value)
    assert said.startswith(f"{source}: $(find elsewhere): no package")
    assert said.count("give --package elsewhere=DIR") == 1


def test_xacro_is_expanded_with_packages_and_arguments(tmp_path):
    pytest.importorskip("xacro")
    source = write_toy(tmp_path)
    macro = source.with_name("reach.xacro")
    macro.write_text(
        '<robot xmlns:xacro="http://wiki.ros.org/xacro">'
        '<xacro:property name="reach" value="2.5"/></robot>'
    )
    xacro = source.with_name("toy.xacro")
    xacro.write_text(
        source.read_text()
        .replace(
            '<robot name="toy">',
            '<robot name="toy" xmlns:xacro="http://wiki.ros.org/xacro">'
            '<xacro:arg name="speed" default="2"/>'
            '<xacro:include filename="$(find '
            'toy_description)/urdf/reach.xacro"/>',
        )
        .replace(
            'upper="2.6" velocity="2"',
            'upper="${reach}" velocity="$(arg speed)"',
        )
    )
    packages = Packages(xacro, variables={})
    urdf, _ = read_robot(xacro, packages, {"speed": "1.5"}, Findings())
    assert urdf.joints["joint_1"].upper == 2.5
    assert urdf.joints["joint_1"].velocity == 1.5


def test_broken_xacro_is_one_line(tmp_path):
    pytest.importorskip("xacro")
    path = tmp_path / "arm.xacro"
    path.write_text(
        '<robot xmlns:xacro="http://wiki.ros.org/xacro">'
        '<link name="${nothing}"/></robot>'
    )
    with pytest.raises(RemoSplatError, match=r"arm.xacro: xacro: ") as caught:
        import_robot(ImportRequest(path), tmp_path, Findings())
    assert "\n" not in str(caught.value)
