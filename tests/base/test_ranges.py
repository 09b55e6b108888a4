"""Every number has a range, and no way into a program goes past it."""

import ast
import dataclasses as dc
import math
import pickle
import typing
from collections.abc import Iterator
from typing import Annotated

import numpy as np
import pytest
from annotated_types import Ge, Gt, Interval, Le, Len, Lt
from pydrake.common.schema import Transform
from pydrake.multibody.parsing import ModelDirective
from pydrake.systems.analysis import SimulatorConfig
from pydrake.systems.sensors import CameraConfig
from sources import modules, nodes

from remosplat_drake.app.diagram import build
from remosplat_drake.app.scenario import Scenario, load_scenario
from remosplat_drake.app.world import load_world
from remosplat_drake.base.errors import FieldError
from remosplat_drake.base.ranges import (
    Config,
    OneOf,
    Unbounded,
    check_ranges,
    choices,
    field_types,
    split,
)
from remosplat_drake.base.strict_yaml import dump, load_strict, load_text
from remosplat_drake.benchmark.scan_suite import ScannedScene
from remosplat_drake.benchmark.splat_recipe import SplatRecipe
from remosplat_drake.controller.controller_config import (
    ReactiveControllerConfig,
)
from remosplat_drake.controller.ingredients import ServoTrackingConfig
from remosplat_drake.controller.tick.reactive_law import ReactiveLaw
from remosplat_drake.hardware.client.robot_link import RobotLink
from remosplat_drake.hardware.hardware_config import HardwareConfig
from remosplat_drake.oracle.oracle_config import SphereToEllipsoid, make_field
from remosplat_drake.reconstruction.report.quality_report import QualityReport
from remosplat_drake.robot.robot_description import RobotDescription
from remosplat_drake.robot.sphere_model import SphereFile
from remosplat_drake.robot.visuals import VisualTable
from remosplat_drake.safety.supervision import SupervisorLaw
from remosplat_drake.safety.supervisor_config import SupervisorConfig
from remosplat_drake.teleop.trajectory_file import TrajectoryFile

SCHEMAS = (
    Scenario,
    RobotDescription,
    SphereFile,
    VisualTable,
    QualityReport,
    TrajectoryFile,
    ScannedScene,
    SplatRecipe,
)
"""What files are read into."""

BOUNDS = (Interval, Gt, Ge, Lt, Le, Unbounded)


def numbers_in(expected, markers=()) -> Iterator[tuple]:
    """The numbers that a value of a type holds, with their markers.

    Not those of Drake's structs: which are valid is for Drake to say, and
    their documentation is where users look it up.
    """
    base, own = split(expected)
    options = choices(base)
    if len(options) > 1 or options[0] is not base:
        for option in options:
            yield from numbers_in(option)
    elif typing.get_origin(base) in (list, dict):
        yield from numbers_in(typing.get_args(base)[-1])
    elif base in (int, float):
        yield base, (*markers, *own)


def all_schemas() -> Iterator[type]:
    """The schemas and those within them, each once."""
    found = list(SCHEMAS)
    for schema in found:
        yield schema
        for expected in field_types(schema).values():
            todo = [expected]
            while todo:
                base, _ = split(todo.pop())
                inner = [*choices(base), *typing.get_args(base)]
                todo += [each for each in inner if each is not base]
                if dc.is_dataclass(base) and base not in found:
                    found.append(base)


def test_every_number_of_every_schema_has_a_range():
    without = [
        f"{schema.__name__}.{name}"
        for schema in all_schemas()
        for name, expected in field_types(schema).items()
        for _, markers in numbers_in(expected)
        if not any(isinstance(marker, BOUNDS) for marker in markers)
    ]
    assert not without


def test_every_schema_is_checked_wherever_it_is_made():
    schemas = list(all_schemas())
    assert len(schemas) > 40
    assert not [s.__name__ for s in schemas if not issubclass(s, Config)]


def test_no_file_is_read_into_anything_else():
    names = {schema.__name__ for schema in SCHEMAS}
    read = set()
    for module in modules():
        for node in nodes(module):
            if isinstance(node, ast.Call) and (
                ast.unparse(node.func) in ("load_strict", "load_text")
            ):
                read.add(ast.unparse(node.args[0]))
    # Tables of links are read by one function, for spheres and for looks.
    read = read - {"schema"} | {"SphereFile", "VisualTable"}
    assert read == names


# The walker.


@dc.dataclass
class Wheel(Config):
    radius: Annotated[float, Interval(gt=0, le=1)] = 0.1


@dc.dataclass
class Cart(Config):
    speed: Annotated[float, Interval(ge=0, lt=3)] = 1.0
    height: Annotated[float, Interval(ge=-2, le=0.5)] = 0.0
    count: Annotated[int, Ge(1)] = 2
    weight: Annotated[float, Gt(0)] = 1.0
    depth: Annotated[float, Lt(3)] = 1.0
    offset: Annotated[float, Unbounded("a number for its own sake")] = 0.0
    kind: Annotated[str, OneOf(("cart", "trolley"), "kind")] = "cart"
    home: Annotated[list[Annotated[float, Le(9)]], Len(2, 2)] = dc.field(
        default_factory=lambda: [0.0, 0.0]
    )
    limit: Annotated[float, Gt(0)] | None = None
    wheels: list[Wheel] = dc.field(default_factory=list)
    spare: dict[str, Wheel] = dc.field(default_factory=dict)
    front: Wheel = dc.field(default_factory=Wheel)

    def check(self) -> Iterator[tuple[str, str]]:
        if self.speed > self.weight:
            yield "speed", f"is too much for a weight of {self.weight}"


BAD = [
    ("speed", -1, "must not be negative, got -1"),
    ("speed", 3, "must lie in [0, 3), got 3"),
    ("speed", math.nan, "must be finite, got nan"),
    ("speed", math.inf, "must be finite, got inf"),
    ("speed", 10**400, "must be finite, got 1000000"),
    ("speed", "fast", "expected a number, got 'fast'"),
    ("speed", True, "expected a number, got True"),
    ("speed", None, "expected a number, got None"),
    ("speed", 2, "is too much for a weight of 1.0"),
    ("height", 1, "must lie in [-2, 0.5], got 1"),
    ("count", 0, "must be at least 1, got 0"),
    ("count", 1.5, "expected a whole number, got 1.5"),
    ("weight", 0, "must be positive, got 0"),
    ("depth", 3, "must be below 3, got 3"),
    ("kind", "crat", "unknown kind 'crat' (did you mean 'cart'?)"),
    ("home", [1.0], "expected 2 entries, got 1"),
    ("home", "ab", "expected a list, got 'ab'"),
    ("home", [1.0, 10.0], "must be at most 9, got 10.0"),
    ("limit", 0, "must be positive, got 0"),
    ("front", 3, "expected Wheel, got 3"),
]


@pytest.mark.parametrize(("field", "value", "problem"), BAD)
def test_a_bad_value_is_refused_when_made_and_when_assigned(
    field, value, problem
):
    with pytest.raises(FieldError) as caught:
        Cart(**{field: value})
    assert caught.value.where == "Cart"
    assert caught.value.field.startswith(field)
    assert caught.value.problem.startswith(problem)
    cart = Cart()
    setattr(cart, field, value)
    with pytest.raises(FieldError) as caught:
        check_ranges(cart, "a.yaml", "cart")
    assert str(caught.value).startswith(f"a.yaml: cart.{field}")


@pytest.mark.parametrize(
    ("text", "line", "field", "problem"),
    [
        ("speed: 3", 1, "speed", "must lie in [0, 3), got 3"),
        ("\nhome: [1,\n 10]", 3, "home[1]", "must be at most 9, got 10"),
        ("home: [1]", 1, "home", "expected 2 entries, got 1"),
        ("limit: -1", 1, "limit", "must be positive, got -1"),
        ("wheels:\n- {}\n- {radius: 2}", 3, "wheels[1].radius", "(0, 1]"),
        ("spare:\n a: {radius: 0}", 2, "spare.a.radius", "positive"),
        ("weight: 0.5\nspeed: 2", 2, "speed", "too much for a weight of 0.5"),
        ("count: 1\nweight: 0.5", 1, "speed", "too much for a weight of 0.5"),
    ],
)
def test_in_a_file_the_line_is_named(tmp_path, text, line, field, problem):
    path = tmp_path / "cart.yaml"
    path.write_text(text)
    with pytest.raises(FieldError) as caught:
        load_strict(Cart, path)
    assert caught.value.where == f"{path}:{line}"
    assert caught.value.field == field
    assert problem in caught.value.problem


def test_text_laid_over_a_file_is_blamed_with_its_own_line(tmp_path):
    path = tmp_path / "cart.yaml"
    path.write_text("speed: 0.5\nweight: 0.6\n")
    for text in ("{count: 3,\n speed: 7}", "{count: 3,\n speed: 0.7}"):
        with pytest.raises(FieldError, match=r"^--scenario-text:2: speed: "):
            load_strict(Cart, path, override=text)


def test_numbers_of_numpy_and_tuples_are_as_good():
    Cart(speed=np.float64(0.5), count=np.int64(3), home=np.zeros(2))
    Cart(home=(1.0, 2.0))


def test_what_a_mutated_object_holds_is_found_deep_inside():
    cart = Cart(wheels=[Wheel(), Wheel()])
    cart.wheels[1].radius = 7.0
    with pytest.raises(FieldError, match=r"Cart: wheels\[1\].radius: "):
        check_ranges(cart)


def test_the_defaults_of_a_text_are_not_touched():
    defaults = Cart(wheels=[Wheel(0.2)])
    cart = load_text(Cart, "speed: 0.1", "here", defaults)
    cart.wheels[0].radius = 0.3
    assert defaults.wheels[0].radius == 0.2


# The programs.


def test_a_gain_from_python_is_refused():
    with pytest.raises(FieldError, match="ServoTrackingConfig: gain: "):
        ReactiveControllerConfig(servo=ServoTrackingConfig(gain=-1))


def test_a_field_that_is_assigned_later_is_found_where_it_is_used(frankie):
    scenario = load_scenario("TableReach")
    scenario.supervisor.max_status_age = 1e9
    match = "TableReach: supervisor.max_status_age: must lie in"
    with pytest.raises(FieldError, match=match):
        load_world(scenario)
    controller = ReactiveControllerConfig()
    controller.servo.gain = -1
    with pytest.raises(FieldError, match=r"servo\.gain: must be positive"):
        ReactiveLaw.make(controller, frankie, 0.01)
    with pytest.raises(FieldError, match="max_status_age"):
        SupervisorLaw.make(
            scenario.supervisor, frankie, 0.01, smallest_stopping=0.02
        )
    oracle = SphereToEllipsoid()
    oracle.n_sigma = -1.0
    with pytest.raises(FieldError, match=r"here: oracle\.n_sigma"):
        make_field(oracle, None, None, "here")
    hardware = HardwareConfig(lcm_url="memq://")
    hardware.base_forward_upper = -1
    with pytest.raises(FieldError, match=r"hardware\.base_forward_upper"):
        RobotLink(hardware, frankie)


def test_a_built_world_is_not_enough():
    scenario = load_scenario("TableGroundTruth")
    world = load_world(scenario)
    scenario.controller.velocity_cost.weight = 0.0
    with pytest.raises(FieldError, match=r"controller\.velocity_cost\.weight"):
        build(scenario, world)


@pytest.mark.parametrize("dt", [0.0, -0.01, 0.2, math.nan])
def test_verified_control_has_a_longest_period(frankie, dt):
    with pytest.raises(FieldError, match="dt: must lie in"):
        ReactiveLaw.make(ReactiveControllerConfig(), frankie, dt)


@pytest.mark.parametrize(
    ("text", "field"),
    [
        ("{scene: {map_error: -1}}", "scene.map_error"),
        ("{scene: {floor_height: 50}}", "scene.floor_height"),
        ("{control_period: 1e-300}", "control_period"),
        ("{control_period: 1e6}", "control_period"),
        ("{control_period: 0.2}", "control_period"),
        ("{oracle: {n_sigma: -1}}", "oracle.n_sigma"),
        ("{oracle: {bisection_steps: 100000000000000000000}}", "bisection"),
        (
            "{oracle: !DepthRasterization {resolution: 1" + "0" * 30 + "}}",
            "res",
        ),
        ("{station: !DynamicStation {time_step: 1e300}}", "station.time_step"),
        ("{station: !DynamicStation {time_step: -1}}", "station.time_step"),
        ("{wrist_camera: {width: -1}}", "wrist_camera.width"),
        ("{targets: [{translation: [1e308, 0, 0]}]}", "translation[0]"),
        ("{robot: {base_pose: [0, 1e308, 0]}}", "robot.base_pose[1]"),
        ("{seed: -1}", "seed"),
        *(
            (f"{{supervisor: {{{field.name}: 1e9}}}}", field.name)
            for field in dc.fields(SupervisorConfig)
            if "float" in str(field.type)
        ),
    ],
)
def test_numbers_that_disarm_gates(text, field):
    with pytest.raises(FieldError) as caught:
        load_scenario("TableReach", text)
    assert caught.value.where == "--scenario-text:1"
    assert field in caught.value.field
    assert len(str(caught.value)) < 200


# Drake's structs.


@dc.dataclass
class Rig(Config):
    camera: CameraConfig = dc.field(default_factory=CameraConfig)
    settings: SimulatorConfig | None = None
    pose: Wheel | Transform = dc.field(default_factory=Transform)
    models: list[ModelDirective] = dc.field(default_factory=list)


RIG = """
camera:
  width: 320
  focal: !FovDegrees {y: 50}
  X_PB: {translation: [1, 2, 3], rotation: !Rpy {deg: [0, 90, 0]}}
  renderer_class: !RenderEngineVtkParams {exposure: 0.5}
settings: {accuracy: 1e-3}
pose: !Transform {base_frame: tip, rotation: !AngleAxis {angle_deg: 3}}
models:
- add_model:
    name: box
    file: box.sdf
    default_joint_positions: {hinge: [0.5]}
- add_weld: {parent: world, child: "box::base", X_PC: {translation: [1, 0, 0]}}
"""


def test_drakes_structs_are_read_and_written(tmp_path):
    path = tmp_path / "rig.yaml"
    path.write_text(RIG)
    rig = load_strict(Rig, path)
    for _ in range(2):
        assert (rig.camera.width, rig.camera.height) == (320, 480)
        assert rig.camera.focal_y() == pytest.approx(240 / math.tan(0.436332))
        X_PB = rig.camera.X_PB.GetDeterministicValue()
        np.testing.assert_allclose(X_PB.translation(), [1, 2, 3])
        np.testing.assert_allclose(
            X_PB.rotation().matrix() @ [1, 0, 0], [0, 0, -1], atol=1e-15
        )
        assert rig.camera.renderer_class.exposure == 0.5
        assert rig.settings.accuracy == 1e-3
        assert rig.settings.max_step_size == SimulatorConfig().max_step_size
        assert rig.pose.base_frame == "tip"
        assert rig.pose.rotation.value.angle_deg == 3
        assert rig.models[0].add_model.default_joint_positions["hinge"] == 0.5
        assert rig.models[0].add_weld is None
        assert rig.models[1].add_weld.child == "box::base"
        np.testing.assert_array_equal(
            rig.models[1].add_weld.X_PC.translation, [1, 0, 0]
        )
        path.write_text(dump("rig", rig))
        rig = load_strict(Rig, path, "rig")


def test_a_layer_is_laid_over_drakes_structs(tmp_path):
    path = tmp_path / "rig.yaml"
    path.write_text(RIG)
    rig = load_strict(Rig, path, override="camera: {height: 240}")
    assert (rig.camera.width, rig.camera.height) == (320, 240)


@pytest.mark.parametrize(
    ("text", "line", "field", "problem"),
    [
        ("camera:\n widht: 1", 2, "camera.widht", "did you mean 'width'?"),
        (
            "camera: {width: 1.5}",
            1,
            "camera.width",
            "a whole number, got '1.5'",
        ),
        (
            "camera: {width: 1" + 30 * "0",
            1,
            "camera.width",
            "Drake does not accept 1",
        ),
        ("camera:\n z_near: .inf", 2, "camera.z_near", "must be finite"),
        ("camera: {focal: !Fov {}}", 1, "camera.focal", "unknown tag 'Fov'"),
        ("camera: {X_PB: {translation: [1]}}", 1, "translation", "3 entries"),
        (
            "camera: {X_PB: {rotation: !Uniform {}}}",
            1,
            "camera.X_PB.rotation",
            "unknown tag 'Uniform'; valid: AngleAxis, Identity, Rpy",
        ),
        (
            "camera: {X_PB: {rotation: !Rpy {deg: [0, .nan, 0]}}}",
            1,
            "camera.X_PB.rotation.deg[1]",
            "must be finite",
        ),
        ("models: [{add: 1}]", 1, "models[0].add", "unknown field 'add'"),
        ("models: {}", 1, "models", "expected a list"),
    ],
)
def test_what_no_struct_of_drake_can_hold_is_refused(
    tmp_path, text, line, field, problem
):
    path = tmp_path / "rig.yaml"
    path.write_text(text + "}" * (text.count("{") - text.count("}")))
    with pytest.raises(FieldError) as caught:
        load_strict(Rig, path)
    assert caught.value.where == f"{path}:{line}"
    assert field in caught.value.field
    assert problem in caught.value.problem
    assert "\n" not in str(caught.value)


def test_a_struct_of_drake_is_checked_where_it_is_used():
    rig = Rig()
    rig.camera.z_far = math.nan
    with pytest.raises(FieldError, match=r"Rig: camera\.z_far: must be finite"):
        check_ranges(rig)
    with pytest.raises(FieldError, match="expected CameraConfig, got 3"):
        Rig(camera=3)


def test_a_struct_of_drake_can_be_sent_to_another_process(tmp_path):
    path = tmp_path / "rig.yaml"
    path.write_text(RIG)
    rig = load_strict(Rig, path)
    assert dump("rig", pickle.loads(pickle.dumps(rig))) == dump("rig", rig)
