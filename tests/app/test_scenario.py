"""Scenarios: how they are named, laid over each other, and refused."""

from pathlib import Path

import numpy as np
import pytest
from effort import effort
from pydrake.math import RigidTransform

from remosplat_drake.app.scenario import (
    DEFAULT_SCENARIO,
    load_scenario,
    shipped_scenarios,
)
from remosplat_drake.app.world import load_world, true_scenes
from remosplat_drake.base.errors import FieldError, RemoSplatError
from remosplat_drake.commands.main import main
from remosplat_drake.oracle.oracle_config import DepthRasterization, GroundTruth
from remosplat_drake.scene.primitive_scene import Box, PrimitiveScene
from remosplat_drake.scene.rmmi import write_rmmi
from remosplat_drake.splat.formats import write_splat
from remosplat_drake.splat.gaussian_splat import GaussianSplat

TWO = """
First:
  time_limit: 3
Second:
  time_limit: 4
  oracle: !GroundTruth {rows: per_primitive}
  controller: {gains: paper, verify: true, servo: {gain: 3.5}}
"""


@pytest.fixture
def folder(tmp_path) -> Path:
    """A folder with scenarios and one scene, a box at the origin's right."""
    (tmp_path / "two.yaml").write_text(TWO)
    box = Box(RigidTransform([0, 1, 0.5]), np.array([0.2, 0.2, 0.2]))
    write_rmmi(tmp_path / "scene.json", PrimitiveScene(boxes=(box,)))
    return tmp_path


# Names


def test_a_file_stands_for_its_first_entry(folder):
    scenario = load_scenario(str(folder / "two.yaml"))
    assert scenario.time_limit == 3
    assert scenario.source == f"{folder}/two.yaml:First"
    assert scenario.folder == folder


def test_an_entry_is_chosen_by_name(folder):
    assert load_scenario(f"{folder}/two.yaml:Second").time_limit == 4


def test_folders_and_files_may_have_colons_in_their_names(folder):
    deep = folder / "run 12:30"
    deep.mkdir()
    file = deep / "a:b.yaml"
    file.write_text(TWO)
    scenario = load_scenario(f"{file}:Second")
    assert (scenario.time_limit, scenario.name) == (4, "Second")
    assert scenario.folder == deep
    assert load_scenario(str(file)).time_limit == 3
    with pytest.raises(RemoSplatError, match=r"b\.yaml: unknown scenario 'No'"):
        load_scenario(f"{file}:No")


def test_a_name_may_have_a_colon_in_it(folder):
    (folder / "odd.yaml").write_text('"At 12:30": {time_limit: 7}\n')
    scenario = load_scenario(f"{folder}/odd.yaml:At 12:30")
    assert (scenario.time_limit, scenario.name) == (7, "At 12:30")


def test_shipped_scenarios_are_found_by_name():
    shipped = shipped_scenarios()
    if not shipped:
        pytest.skip("no scenario files are installed")
    assert DEFAULT_SCENARIO in shipped
    assert load_scenario().source.endswith(f":{DEFAULT_SCENARIO}")
    for name, path in list(shipped.items())[:: effort(4, 1)]:
        assert load_scenario(name).source == f"{path}:{name}"


# Values


def test_a_field_that_is_not_given_keeps_its_default(folder):
    scenario = load_scenario(str(folder / "two.yaml"))
    assert scenario.control_period == 0.01
    assert scenario.controller.gains == "fast"
    assert scenario.robot.spheres == "covering"


def test_fields_are_laid_over_the_named_gain_set(folder):
    controller = load_scenario(f"{folder}/two.yaml:Second").controller
    assert controller.gains == "paper"
    assert controller.verify  # The paper's is off.
    assert controller.servo.gain == 3.5
    # The paper's, not the defaults.
    assert controller.servo.max_speed == 0.5
    assert controller.velocity_cost.weight == 0.01
    assert not controller.velocity_limits.acceleration
    assert not controller.self_collision.enabled


def test_text_from_the_shell_is_laid_over_the_file(folder):
    scenario = load_scenario(
        f"{folder}/two.yaml:Second",
        "{time_limit: 1.5, controller: {servo: {max_speed: 0.1}},"
        " oracle: !DepthRasterization {resolution: 40}}",
    )
    assert scenario.time_limit == 1.5
    assert scenario.controller.servo.max_speed == 0.1
    assert scenario.controller.servo.gain == 3.5
    assert scenario.oracle == DepthRasterization(resolution=40)


def test_the_gain_set_may_come_from_the_shell(folder):
    controller = load_scenario(
        str(folder / "two.yaml"), "{controller: {gains: paper}}"
    ).controller
    assert controller.velocity_cost.weight == 0.01
    assert not controller.verify


def test_an_oracle_is_chosen_by_its_tag(folder):
    oracle = load_scenario(f"{folder}/two.yaml:Second").oracle
    assert oracle == GroundTruth(rows="per_primitive")


@pytest.mark.parametrize(
    ("oracle", "file"),
    [
        (
            "!SphereToEllipsoid"
            " {min_opacity: 0, bisection_steps: 3, threads: 2}",
            "disc.ply",
        ),
        ("!DepthRasterization {resolution: 20, threads: 2}", "disc.spz"),
    ],
)
def test_an_oracle_is_built_with_its_parameters(folder, oracle, file):
    disc = GaussianSplat(
        p_GK=np.array([[1.0, 0, 0.9]]),
        quaternions=np.array([[1.0, 0, 0, 0]]),
        scales=np.array([[0.3, 0.3]]),
        opacities=np.array([0.95]),
        colors=np.array([[0.5, 0.5, 0.5]]),
    )
    write_splat(folder / file, disc)
    text = f"{{scene: {{splat: {file}}}, oracle: {oracle}}}"
    world = load_world(load_scenario(str(folder / "two.yaml"), text))
    assert world.splat_W is not None
    assert len(world.splat_W) == 1
    spheres = world.robot.spheres_at(world.q0)
    assert 0 < world.field.clearances(spheres, 0.5).minimum() < 0.5


def test_numbers_may_be_written_as_people_do(folder):
    scenario = load_scenario(
        str(folder / "two.yaml"), "{control_period: 1e-3, time_limit: 2}"
    )
    assert scenario.control_period == 1e-3
    assert scenario.time_limit == 2.0


def test_files_are_relative_to_the_scenarios_folder(folder, monkeypatch):
    monkeypatch.chdir("/")
    scenario = load_scenario(
        str(folder / "two.yaml"),
        "{scene: {truth: scene.json}, oracle: !GroundTruth {}}",
    )
    world = load_world(scenario)
    assert world.truth is not None
    assert len(world.truth) == 1
    np.testing.assert_array_equal(world.q0[:3], np.zeros(3))
    np.testing.assert_array_equal(world.q0[3:], world.robot.home)


CRATE = """<sdf version='1.7'><model name='crate'><link name='body'>
<collision name='wall'><geometry><box><size>0.1 0.1 0.1</size></box>
</geometry></collision></link></model></sdf>"""


def test_objects_of_directives_are_part_of_the_true_scene(folder):
    (folder / "crate.sdf").write_text(CRATE)
    truth = "truth: scene.json, truth_later: scene.json"
    directives = (
        "[{add_model: {name: crate, file: crate.sdf}},"
        " {add_weld: {parent: world, child: crate::body,"
        " X_PC: {translation: [0.8, 0, 0.5]}}}]"
    )
    worlds, clearances = [], []
    for extra in ("", f", directives: {directives}"):
        text = f"{{scene: {{{truth}{extra}}}, oracle: !GroundTruth {{}}}}"
        scenario = load_scenario(str(folder / "two.yaml"), text)
        worlds.append(world := load_world(scenario))
        clearances.append(
            world.field.clearances(world.robot.spheres_at(world.q0)).minimum()
        )
        lengths = [len(scene) for scene in true_scenes(scenario, world)]
        assert lengths == [1 + bool(extra)] * 2
    assert clearances[1] < clearances[0]
    with_crate = worlds[1]
    assert with_crate.truth is not None
    crate = with_crate.truth.boxes[-1]
    np.testing.assert_allclose(crate.X_WP.translation(), [0.8, 0, 0.5])
    # The robot's nearest sphere is as far from the crate as geometry says.
    spheres = with_crate.robot.spheres_at(with_crate.q0)
    q = np.abs(spheres.p_WS - [0.8, 0, 0.5]) - 0.05
    outside = np.linalg.norm(np.maximum(q, 0), axis=1)
    assert clearances[1] == pytest.approx((outside - spheres.radius).min())


def test_the_wrist_camera_may_be_drakes(folder):
    text = (
        "{wrist_camera: !CameraConfig {width: 320, height: 240, fps: 10,"
        " focal: !FovDegrees {y: 50}, z_near: 0.2, z_far: 3, name: eye,"
        " X_PB: {base_frame: wrist_camera, translation: [0, 0, 0.01],"
        " rotation: !Rpy {deg: [0, 3, 90]}}}}"
    )
    camera = load_scenario(str(folder / "two.yaml"), text).camera
    assert camera is not None
    assert (camera.frame, camera.width, camera.height) == (
        "wrist_camera",
        320,
        240,
    )
    assert (camera.min_depth, camera.max_depth) == (0.2, 3.0)
    assert camera.fov_y_deg == pytest.approx(50)
    assert camera.translation == [0, 0, 0.01]
    assert camera.rpy_deg == pytest.approx([0, 3, 90])


@pytest.mark.parametrize(
    ("text", "field", "problem"),
    [
        ("fps: 30", "fps", "does not support it"),
        ("rgb: false", "rgb", "does not support it"),
        ("center_x: 3", "center_x", "does not support it"),
        ("X_PB: {base_frame: null}", "X_PB.base_frame", "frame of the robot"),
        ("focal: !FovDegrees {x: 60}", "focal", "pixels must be square"),
        ("focal: !FovDegrees {y: null}", "focal", "must"),
        ("z_far: 200", "z_far", "(0, 100]"),
        ("width: -3", "width", "[1, 8192]"),
    ],
)
def test_what_the_wrist_camera_cannot_be_is_refused(
    folder, text, field, problem
):
    frame = "" if "X_PB" in text else "X_PB: {base_frame: wrist_camera}, "
    text = f"{{wrist_camera: !CameraConfig {{{frame}{text}}}}}"
    with pytest.raises(FieldError) as caught:
        load_scenario(str(folder / "two.yaml"), text)
    assert caught.value.where == "--scenario-text:1"
    assert caught.value.field == f"wrist_camera.{field}"
    assert problem in caught.value.problem


@pytest.mark.parametrize(
    ("text", "field", "problem"),
    [
        ("lcm: {lcm_url: tcp}", "lcm.lcm_url", "expected udpm://"),
        (
            "lcm_url: 'memq://', lcm: {lcm_url: 'udpm://239.1.1.1:7667'}",
            "lcm.lcm_url",
            "differs from lcm_url 'memq://': set only one of them",
        ),
        (
            f"lcm: {{channel_suffix: {'x' * 60}}}",
            "lcm.channel_suffix",
            "longer than 63",
        ),
        (
            "lcm: {defer_initialization: true}",
            "lcm.defer_initialization",
            "must be false",
        ),
    ],
)
def test_lcm_settings_that_cannot_be_are_refused(folder, text, field, problem):
    with pytest.raises(FieldError) as caught:
        load_scenario(str(folder / "two.yaml"), f"{{hardware: {{{text}}}}}")
    assert caught.value.where == "--scenario-text:1"
    assert caught.value.field == f"hardware.{field}"
    assert problem in caught.value.problem


# Bad input: text laid over a good scenario, and what the one line must say.

SCENE = "scene: {truth: scene.json}, oracle: !GroundTruth {}"
TARGET = "targets: [{translation: [0.6, 0, 0.6]}]"

BAD_FIELDS = {
    "unknown key": ("{time_limits: 5}", ["time_limits", "time_limit"]),
    "unknown nested key": (
        "{controller: {servo: {gian: 1}}}",
        ["controller.servo.gian", "gain"],
    ),
    "wrong type": ("{time_limit: [1]}", ["time_limit", "number"]),
    "text for a number": ("{time_limit: soon}", ["time_limit", "soon"]),
    "number for a switch": (
        "{controller: {verify: 1}}",
        ["controller.verify", "true or false"],
    ),
    "NaN": ("{control_period: .nan}", ["control_period", "finite"]),
    "infinite": ("{time_limit: .inf}", ["time_limit", "finite"]),
    "quoted number": ("{time_limit: '2'}", ["time_limit", "'2'"]),
    "unknown oracle": (
        "{oracle: !GroundTruht {}}",
        ["oracle", "GroundTruht", "GroundTruth"],
    ),
    "unknown station": (
        "{station: !Hardwear {}}",
        ["station", "Hardwear", "KinematicStation"],
    ),
    "unknown gain set": (
        "{controller: {gains: papre}}",
        ["controller.gains", "papre", "paper"],
    ),
    "unknown solver": (
        "{controller: {solver: clarable}}",
        ["--scenario-text:1", "controller.solver", "clarable", "clarabel"],
    ),
    "unknown direction": (
        "{targets: [{free: [yaw]}]}",
        ["targets[0].free[0]", "'yaw'", "rz"],
    ),
    "two free turns": (
        "{targets: [{free: [rx, rz]}]}",
        ["targets[0].free", "none, one or all"],
    ),
    "nothing asked for": (
        "{targets: [{free: [rx, ry, rz, x, y, z]}]}",
        ["targets[0].free", "all six directions are free"],
    ),
    "weight of an unknown direction": (
        "{targets: [{weights: {w: 2}}]}",
        ["targets[0].weights", "'w'", "rz"],
    ),
    "weight of what is free": (
        "{targets: [{free: [x], weights: {x: 2}}]}",
        ["targets[0].weights.x", "is a free direction"],
    ),
    "no weight": (
        "{targets: [{weights: {x: 0}}]}",
        ["targets[0].weights.x", "positive"],
    ),
    "last target passed": (
        "{targets: [{pass_within: 0.1}]}",
        ["targets[0].pass_within", "must be absent at the last target"],
    ),
    "line without speed": (
        "{targets: [{line_speed: 0}]}",
        ["targets[0].line_speed", "positive"],
    ),
    "negative period": (
        "{control_period: -0.01}",
        ["--scenario-text:1", "control_period", "[0.001, 1]"],
    ),
    "no time": ("{time_limit: 0}", ["time_limit", "positive"]),
    "negative gain": (
        "{controller: {servo: {gain: -1}}}",
        ["controller.servo.gain", "positive"],
    ),
    "stopping beyond influence": (
        "{controller: {collision: {stopping: 0.6}}}",
        ["controller.collision.influence", "0.6"],
    ),
    "guidance that starts too far away": (
        "{controller: {collision: {stopping: 0.15}}}",
        ["controller.guidance.enabled", "collision.stopping", "0.15"],
    ),
    "tiers that do not fall": (
        "{controller: {guidance: {tiers: [0.01, 0.02]}}}",
        ["controller.guidance.tiers", "0.021"],
    ),
    "a tier that touches": (
        "{controller: {guidance: {tiers: [0.01, 0.0]}}}",
        ["controller.guidance.tiers", "positive"],
    ),
    "no time to look ahead": (
        "{controller: {guidance: {budget_ms: 0}}}",
        ["controller.guidance.budget_ms", "positive"],
    ),
    "no rotation": (
        "{targets: [{rotation: [[1, 0, 0], [0, 1, 0], [0, 0, -1]]}]}",
        ["targets[0].rotation", "rotation matrix"],
    ),
    "stretched rotation": (
        "{targets: [{}, {rotation: [[2, 0, 0], [0, 1, 0], [0, 0, 1]]}]}",
        ["targets[1].rotation", "rotation matrix"],
    ),
    "two rotations": (
        "{targets: [{rpy_deg: [0, 0, 0],"
        " rotation: [[1, 0, 0], [0, 1, 0], [0, 0, 1]]}]}",
        ["targets[0]", "not both"],
    ),
    "short translation": (
        "{targets: [{translation: [1, 2]}]}",
        ["targets[0].translation", "3 entries"],
    ),
    "unknown arrival rule": (
        "{arrival: {rule: txet}}",
        ["arrival.rule", "txet", "text"],
    ),
    "no tolerance": ("{arrival: {position: 0}}", ["arrival.position"]),
    "short base pose": (
        "{robot: {base_pose: [0, 0]}}",
        ["robot.base_pose", "3 entries"],
    ),
    "not YAML": ("{time_limit: [", ["not YAML"]),
    "not a mapping": ("[1, 2]", ["mapping"]),
}

BAD_WORLDS = {
    "missing splat": (
        "{scene: {splat: nowhere.ply}}",
        ["two.yaml", "scene.splat", "nowhere.ply", "no such file"],
    ),
    "a folder for a splat": ("{scene: {splat: .}}", ["folder", "meta.json"]),
    "missing truth": (
        "{scene: {truth: nowhere.json}}",
        ["two.yaml", "scene.truth", "nowhere.json", "no such file"],
    ),
    "no splat at all": ("{}", ["oracle", "scene.splat"]),
    "no truth at all": ("{oracle: !GroundTruth {}}", ["oracle", "scene.truth"]),
    "two directives in one": (
        "{scene: {directives: [{add_model: {}, add_weld: {}}]}}",
        ["--scenario-text:1", "scene.directives[0]", "got 2"],
    ),
    "a directive without its file": (
        "{scene: {directives: [{add_model: {name: a, file: nowhere.sdf}}]}}",
        ["two.yaml", "scene.directives", "nowhere.sdf", "no such file"],
    ),
    "unknown rows": (
        "{scene: {truth: scene.json}, oracle: !GroundTruth {rows: all}}",
        ["oracle.rows", "per_primitive"],
    ),
    "unknown robot": (
        f"{{{SCENE}, robot: {{model: franky}}}}",
        ["franky", "frankie"],
    ),
    "unknown spheres": (
        f"{{{SCENE}, robot: {{spheres: covring}}}}",
        ["spheres", "covring", "covering"],
    ),
    "start in the scene": (
        f"{{{SCENE}, robot: {{base_pose: [0, 0.9, 0]}}}}",
        ["two.yaml", "robot.base_pose", "inside the scene", "mm"],
    ),
    "short arm": (
        f"{{{SCENE}, robot: {{arm: [0, 0]}}}}",
        ["robot.arm", "7 numbers"],
    ),
    "arm beyond its limits": (
        f"{{{SCENE}, robot: {{arm: [0, 0, 0, 1, 0, 0, 0]}}}}",
        ["robot.arm", "panda_joint4", "limits"],
    ),
    "gripper that does not move": (
        f"{{{SCENE}, {TARGET}, station: !KinematicStation {{hand_speed: 0}}}}",
        ["station.hand_speed", "positive"],
    ),
    "camera without pixels": (
        f"{{{SCENE}, {TARGET}, wrist_camera: {{width: 0}}}}",
        ["wrist_camera.width", "[1, 8192]"],
    ),
    "end effector of a robot with one": (
        f"{{{SCENE}, targets: [{{effector: left, translation: [1, 0, 1]}}]}}",
        ["targets[0].effector", "one end effector", "leave this field out"],
    ),
    "no target": (f"{{{SCENE}}}", ["targets", "none given"]),
}


@pytest.mark.parametrize("case", BAD_FIELDS)
def test_an_unusable_field_is_named(folder, case):
    text, mentions = BAD_FIELDS[case]
    with pytest.raises(RemoSplatError) as caught:
        load_scenario(str(folder / "two.yaml"), text)
    message = str(caught.value)
    assert "\n" not in message
    assert all(mention in message for mention in mentions), message


@pytest.mark.parametrize("case", [*BAD_FIELDS, *BAD_WORLDS])
def test_the_command_line_says_it_in_one_line(folder, capfd, case):
    text, mentions = {**BAD_FIELDS, **BAD_WORLDS}[case]
    code = main(
        [
            "run",
            str(folder / "two.yaml"),
            "--headless",
            "--scenario-text",
            text,
        ]
    )
    assert code == 2
    lines = capfd.readouterr().err.strip().splitlines()
    message = lines[-1]
    assert message.startswith("remosplat: ")
    assert all(mention in message for mention in mentions), message
    assert not [line for line in lines if "Traceback" in line]
    # A first run may announce that it compiles; nothing else speaks.
    assert len([line for line in lines if "compil" not in line]) == 1


@pytest.mark.parametrize(
    ("spec", "mentions"),
    [
        ("nowhere.yaml", ["nowhere.yaml", "no such file"]),
        ("{folder}/two.yaml:Secnd", ["two.yaml", "Secnd", "Second"]),
        ("TabelReach", ["TabelReach"]),
        ("{folder}/empty.yaml", ["empty.yaml", "empty"]),
        ("{folder}/list.yaml", ["list.yaml", "mapping"]),
        ("{folder}/binary.yaml", ["binary.yaml", "not a text file"]),
        ("{folder}/none.yaml", ["none.yaml", "no scenarios"]),
    ],
)
def test_a_scenario_that_cannot_be_found(folder, spec, mentions):
    (folder / "empty.yaml").write_text("# nothing\n")
    (folder / "list.yaml").write_text("- one\n")
    (folder / "none.yaml").write_text("{}\n")
    (folder / "binary.yaml").write_bytes(b"\xff\xfe\x00\xd8")
    with pytest.raises(RemoSplatError) as caught:
        load_scenario(spec.format(folder=folder))
    message = str(caught.value)
    assert "\n" not in message
    assert all(mention in message for mention in mentions), message


def test_errors_name_the_line_of_the_file(folder):
    file = folder / "bad.yaml"
    file.write_text("Bad:\n  time_limit: 3\n  controler: {}\n")
    with pytest.raises(RemoSplatError, match=r"bad\.yaml:3: controler"):
        load_scenario(str(file))
