"""Objects of a scenario: what the map shows of them, and bad ones."""

import numpy as np
import pytest
from pydrake.math import RigidTransform

from remosplat_drake.app.diagram import build
from remosplat_drake.app.map_knowledge import MapError, map_error_gates
from remosplat_drake.app.object_map import (
    own_splats,
    with_solids,
    without_objects,
)
from remosplat_drake.app.scenario import load_scenario
from remosplat_drake.app.world import load_world
from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.oracle.object_field import ObjectField
from remosplat_drake.robot.sphere_model import Spheres
from remosplat_drake.scene.objects.scene_object import SceneObject
from remosplat_drake.scene.primitive_scene import Box, Cylinder, PrimitiveScene
from remosplat_drake.splat.gaussian_splat import GaussianSplat
from remosplat_drake.task.free_places import Surroundings, free_places
from remosplat_drake.task.object_spheres import fit_object

CAN = SceneObject("can", Cylinder(RigidTransform([0, 0, 0.1]), 0.03, 0.1))


def splat_at(*p_W) -> GaussianSplat:
    n = len(p_W)
    return GaussianSplat(
        p_GK=np.array(p_W, np.float32),
        quaternions=np.tile(np.array([1, 0, 0, 0], np.float32), (n, 1)),
        scales=np.full((n, 2), 0.005, np.float32),
        opacities=np.full(n, 0.9, np.float32),
        colors=np.full((n, 3), 0.5, np.float32),
    )


def test_splats_near_its_surface_are_its_own_but_for_those_at_its_foot():
    side, top = (0.031, 0, 0.1), (0, 0, 0.205)
    foot, table, inside = (0.031, 0, 0.005), (0.2, 0, 0), (0, 0, 0.1)
    splat_W = splat_at(side, top, foot, table, inside)
    own = own_splats(splat_W, CAN, margin=0.01)
    assert own.tolist() == [True, True, False, False, False]


def test_the_true_scene_has_each_thing_once():
    crate = Box(RigidTransform(), np.ones(3), "crate")
    scene = PrimitiveScene(boxes=(crate,))
    both = with_solids(scene, [CAN, SceneObject("crate", crate)])
    assert len(both.boxes) == 1 and both.cylinders == (CAN.solid,)
    assert with_solids(None, [CAN]) is None
    named = SceneObject("crate", crate)
    assert not len(without_objects(scene, [named]))


def test_the_map_of_a_scenario_shows_an_object_by_its_shape():
    world = load_world(load_scenario("TablePick"))
    names = [each.name for each in world.objects]
    assert names == ["middle can", "left can", "table", "tray"]
    p_W = world.objects[0].X_WO.translation()
    # In the middle of the can the splat's discs are a radius away.
    found = world.field.clearances(Spheres.at(p_W))
    assert found.minimum() == pytest.approx(-0.0298, abs=1e-9)
    assert world.scene_field.clearances(Spheres.at(p_W)).minimum() > 0.05
    assert world.field.thing_at(found.p_WC[0]).name == "the middle can"
    alone = ObjectField(world.objects).clearances(Spheres.at(p_W))
    assert alone.minimum() == found.minimum()


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (
            "{objects: [{name: cup, X_WO: {translation: [1.2, 0.8, 1]},"
            " box: [0.1, 0.1, 0.1]}], tasks: []}",
            r"objects\[0\]\.X_WO: the splat shows no cup there",
        ),
        (
            "{objects: [{name: cup, box: [1, 1, 1]},"
            " {name: cup, box: [1, 1, 1]}], tasks: []}",
            r"objects\[1\]\.name: two objects are named 'cup'",
        ),
        (
            "{objects: [{name: cup}], tasks: []}",
            r"objects\[0\]: give exactly one of box, cylinder, hull, surface,"
            " region, got 0",
        ),
        (
            "{objects: [{name: cup, hull: {file: no.obj}}], tasks: []}",
            r"objects\[0\]: no\.obj: no such file",
        ),
        (
            "{objects: [{name: spot, surface: {near: [1.2, 0.6, 1.0]}}],"
            " tasks: []}",
            r"objects\[0\]\.surface\.near: the map has no surface within",
        ),
        (
            "{objects: [{name: spot, surface: {near: [1, 1, 1], reach: 9}}]}",
            r"objects\[0\]\.surface\.reach",
        ),
        (
            "{objects: [{name: cup, region: {near: [1.0, 0, 1]}}], tasks: []}",
            r"objects\[0\]\.region\.near: the map has no Gaussian within",
        ),
        (
            "{objects: [{name: cup, region: {near: [1.005, 0.12, 0.66],"
            " largest: 0.15}}], tasks: []}",
            r"objects\[0\]\.region\.near: all that the map connects with"
            r" this point is larger than 0\.15 m",
        ),
        (
            "{objects: [{name: cup, region: {largest: 9}}]}",
            r"objects\[0\]\.region\.largest",
        ),
        (
            "{objects: [{name: cup, region: {}, in_splat: false}]}",
            r"objects\[0\]\.in_splat: must be true, since a region",
        ),
        (
            "{objects: [{name: cup, region: {near: [1.005, 0.12, 0.66]}},"
            " {name: can, region: {near: [1.035, 0.1235, 0.7]}}], tasks: []}",
            r"objects\[0\]\.region\.near: the Gaussians there belong to the"
            " can; remove one of the two",
        ),
        (
            "{scene: {splat: ''}, oracle: !GroundTruth {}, tasks: [],"
            " objects: [{name: cup, region: {}}]}",
            r"objects\[0\]\.region\.near: needs a splat; set scene\.splat",
        ),
        ("{tasks: [!Pick {object: cup}]}", "unknown object 'cup'"),
        ("{tasks: [!Lift {by: [0, 0, 9]}]}", "by"),
        (
            "{tasks: [!DriveTo {base_pose: [0, 0, 90]}]}",
            "tasks.0..base_pose: the yaw is in radians, got 90",
        ),
        (
            "{tasks: [!DriveTo {}], controller: {guidance: {budget: 0}}}",
            "tasks.0.: needs planned paths: set controller.guidance.planning",
        ),
        (
            "{targets: [{translation: [1, 0, 1]}]}",
            "tasks: give `tasks` or `targets`, not both",
        ),
    ],
)
def test_bad_ones_end_in_one_line(text, message):
    with pytest.raises(RemoSplatError, match=message) as error:
        build(load_scenario("TablePick", text))
    assert "\n" not in str(error.value)


FOUND = "{objects: [%s, {name: board, surface: {near: [1.05, 0.2, 0.54]}}]}"


def test_a_surface_is_found_in_the_splat():
    """The lower board of the bookshelf, in a trained splat."""
    cup = "{name: cup, X_WO: {translation: [0.4, 1, 0.6]}, in_splat: false,"
    cup += " cylinder: {radius: 0.033, height: 0.12}}"
    text = FOUND % cup
    world = load_world(load_scenario("ShelfPlace", f"{text[:-1]}, tasks: []}}"))
    cup, board = world.objects
    assert board.top == pytest.approx(0.53584, abs=0.003)
    lower, upper = board.corners + board.X_WO.translation()
    # The board of the true scene, as far as the search goes.
    assert (lower[:2] >= [0.9 - 0.02, -0.1 - 0.02]).all()
    assert (upper[:2] <= [1.35 + 0.02, 0.5 + 0.02]).all()
    assert (upper - lower)[:2].min() > 0.15
    # It is an object: the map without objects lacks its splats.
    p_W = np.array([1.05, 0.2, board.top])
    assert abs(world.field.clearances(Spheres.at(p_W)).minimum()) < 0.001
    assert world.scene_field.clearances(Spheres.at(p_W)).minimum() > 0.03
    around = Surroundings(world.scene_field, 0.021)
    places = free_places(cup, fit_object(cup), board, around)
    assert places and places[0].translation()[2] == pytest.approx(
        board.top + 0.06, abs=1e-6
    )


REGIONS = """{tasks: [], objects: [
 {name: middle can, region: {near: [%s]}, mass: 0.3},
 {name: left can, region: {near: [0.95, 0.24, 0.7]}}]}"""


@pytest.mark.parametrize(
    "near", ["1.005, 0.12, 0.66", "1.035, 0.1235, 0.715", "1.06, 0.12, 0.58"]
)
def test_cans_are_found_in_the_splat(near):
    """Their shapes are those of `TablePick`, which are the true ones."""
    known = load_world(load_scenario("TablePick"))
    world = load_world(load_scenario("TablePick", REGIONS % near))
    for found, true in zip(world.objects, known.objects, strict=False):
        assert found.name == true.name and found.mass == true.mass
        np.testing.assert_allclose(
            found.X_WO.translation(), true.X_WO.translation(), atol=0.001
        )
        assert isinstance(found.solid, Cylinder)
        assert 0.0 < found.solid.radius - true.solid.radius < 0.0015
        off = found.solid.half_height - true.solid.half_height
        assert 0.0 < off < 0.0015
    # As with written shapes, only these splats are no longer the scene's.
    assert world.splat_W is not None and world.scene_splat_W is not None
    field = ObjectField(world.objects)
    left = len(world.splat_W) - len(world.scene_splat_W)
    p_W = np.array(world.splat_W.p_GK, float)
    inside = field.clearances(Spheres.at(p_W)).distance < 0
    high = p_W[:, 2] > 0.5558 + 0.008
    assert 2000 < left <= np.count_nonzero(inside & high)
    # And none of the two is left in the map without objects.
    rest = np.array(world.scene_splat_W.p_GK, float)
    rest = rest[rest[:, 2] > 0.5558 + 0.01]
    assert field.clearances(Spheres.at(rest)).minimum() > 0.01


def test_things_that_touch_each_other_are_one_object():
    text = "{tasks: [], objects: [{name: cans, region: {near: %s}}]}"
    front, rear = (
        load_world(load_scenario("TablePick", text % near)).objects[0]
        for near in ("[1.04, -0.31, 0.7]", "[1.149, -0.211, 0.82]")
    )
    assert isinstance(front.solid, Box) and isinstance(rear.solid, Box)
    assert front.top == rear.top == pytest.approx(0.8206, abs=0.0015)


def test_what_reaches_through_a_board_is_no_object():
    text = "{tasks: [], objects: [{name: can, region: {near: %s}}]}"
    near = "[0.93, -0.13, 0.7]"
    with pytest.raises(RemoSplatError, match=r"larger than 0\.4 m"):
        load_world(load_scenario("ShelfPlace", text % near))


def test_a_pair_s_own_distance_exceeds_the_map_s_error():
    scenario = load_scenario("TablePick")
    assert not map_error_gates(scenario, MapError(0.0099))
    (gate,) = map_error_gates(scenario, MapError(0.012))
    assert "tasks[0].touch[0].stopping: 0.012 is too small" in gate.problem
