"""The dynamic station's objects: gravity and contact alone move them.

The Panda's hand hangs on a hoist, over a plate.
"""

import numpy as np
import pytest
from hoist import load_hoist
from pydrake.math import RigidTransform, RollPitchYaw

from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.scene.objects.convex_hull import ConvexHull
from remosplat_drake.scene.objects.drake_shapes import object_inertia
from remosplat_drake.scene.objects.scene_object import SceneObject
from remosplat_drake.scene.primitive_scene import Box, Cylinder, PrimitiveScene
from remosplat_drake.signals.hand_reading import HandReading
from remosplat_drake.station.simulated_station import MakeSimulatedStation
from remosplat_drake.station.station_config import (
    DynamicStation,
    KinematicStation,
)

TOP = 0.15
"""Height of the plate [m]: 47 mm below the fingers' tips' frame."""

PLATE = PrimitiveScene(
    boxes=(Box(RigidTransform([0, 0, TOP - 0.02]), np.array([0.2, 0.3, 0.02])),)
)

CLOSE, FORCE = 0.02, 30.0  # [m, N]


@pytest.fixture(scope="module")
def hoist(tmp_path_factory) -> RobotModel:
    return load_hoist(tmp_path_factory.mktemp("hoist"))


def can(mass: float = 0.3, half_height: float = 0.035) -> SceneObject:
    X_WO = RigidTransform([0, 0, TOP + half_height])
    return SceneObject("can", Cylinder(X_WO, 0.03, half_height), mass)


class Lift:
    """A hand above a plate with objects."""

    def __init__(self, harness, hoist, objects, **settings):
        station = MakeSimulatedStation(
            config=DynamicStation(time_step=0.002, **settings),
            robot=hoist,
            scene=PLATE,
            q0=hoist.q_home,
            objects=objects,
        )
        self.dut = harness(station, hoist, hand=(0.08, FORCE))

    def hand(self, width: float, time: float) -> HandReading:
        self.dut.fix("hand.command", [width, FORCE])
        self.dut.advance(time)
        return HandReading.of(self.dut.eval("hand.state"))

    def lift(self, height: float, time: float) -> None:
        self.dut.command(np.array([height / time]))
        self.dut.advance(time)
        self.dut.command(np.zeros(1))

    @property
    def objects(self) -> tuple[SceneObject, ...]:
        return self.dut.eval("cheat.objects")

    @property
    def height(self) -> float:
        """Height of the first object's centre [m]."""
        return self.objects[0].X_WO.translation()[2]


def presses(reading: HandReading) -> bool:
    """Whether something stops a closing hand, which presses on it."""
    return reading.at_rest and reading.force > 0.5 * FORCE


def tilt(thing: SceneObject) -> float:
    """Angle of an object's z axis from the vertical [rad]."""
    return float(np.arccos(thing.X_WO.rotation().matrix()[2, 2]))


def test_a_can_is_lifted_held_and_dropped(hoist, harness):
    world = Lift(harness, hoist, [can()])
    reading = world.hand(CLOSE, 0.4)
    assert presses(reading)
    np.testing.assert_allclose(reading.width, 0.06, atol=2e-3)
    assert world.dut.eval("cheat.contact").objects == (
        ("panda_leftfinger", "can"),
        ("panda_rightfinger", "can"),
    )
    world.lift(0.1, 0.5)
    np.testing.assert_allclose(world.height, TOP + 0.135, atol=3e-3)
    reading = world.hand(CLOSE, 2.0)
    np.testing.assert_allclose(world.height, TOP + 0.135, atol=3e-3)
    assert presses(reading) and not reading.is_narrower(0.06)
    assert tilt(world.objects[0]) < 0.02
    assert world.dut.eval("cheat.contact").others == ()
    world.hand(0.08, 0.4)
    assert world.height < TOP + 0.07


def test_a_long_box_does_not_turn_between_the_pads(hoist, harness):
    """It is held 30 mm beside its centre of mass: 0.06 N m at 0.2 kg."""
    X_WO = RigidTransform([0.03, 0, TOP + 0.03])
    bar = SceneObject("bar", Box(X_WO, np.array([0.07, 0.02, 0.03])), 0.2)
    world = Lift(harness, hoist, [bar])
    world.hand(CLOSE, 0.5)
    world.lift(0.1, 0.5)
    np.testing.assert_allclose(world.height, TOP + 0.13, atol=5e-3)
    assert tilt(world.objects[0]) < 0.1


def random_object(rng: np.random.Generator) -> SceneObject:
    """A box, a can or a brilliant that stands below the hand, off its centre.

    It is 20 to 70 mm wide, 40 to 80 mm high, and of 0.05 to 1 kg.
    """
    half_height = rng.uniform(0.02, 0.04)
    shift = [*rng.uniform(-0.008, 0.008, 2), TOP + half_height]
    turn = RollPitchYaw(0, 0, rng.uniform(-0.15, 0.15))
    X_WO, half = RigidTransform(turn, shift), rng.uniform(0.01, 0.035)
    mass = float(np.exp(rng.uniform(np.log(0.05), np.log(1.0))))
    kind = rng.integers(3)
    if kind == 0:
        size = np.array([rng.uniform(0.01, 0.05), half, half_height])
        return SceneObject("box", Box(X_WO, size), mass)
    if kind == 1:
        return SceneObject("can", Cylinder(X_WO, half, half_height), mass)
    angles = np.arange(8) * np.pi / 4 + np.pi / 8
    ring = np.stack([np.cos(angles), np.sin(angles)], axis=1) * half
    points = [
        np.column_stack([scale * ring, np.full(8, z * half_height)])
        for scale, z in ((0.7, -1.0), (1.0, 0.2), (0.8, 1.0))
    ]
    return SceneObject("hull", ConvexHull(X_WO, np.concatenate(points)), mass)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(20))
def test_random_objects_are_lifted_and_held(seed, hoist, harness):
    thing = random_object(np.random.default_rng(seed))
    world = Lift(harness, hoist, [thing])
    world.hand(0.005, 0.9)
    world.lift(0.1, 0.5)
    grip = world.height
    world.hand(0.005, 2.0)
    start = thing.X_WO.translation()[2]
    np.testing.assert_allclose(world.height, start + 0.1, atol=8e-3)
    assert abs(world.height - grip) < 2e-3
    world.hand(0.08, 0.4)
    assert world.height < start + 0.06


def test_a_hand_that_closes_on_nothing_says_so(hoist, harness):
    X_WO = RigidTransform([0.1, 0, TOP + 0.035])
    world = Lift(harness, hoist, [can().at(X_WO)])
    reading = world.hand(CLOSE, 0.8)
    assert reading.at_rest and reading.is_narrower(0.06)


def test_a_slippery_can_stays_on_the_plate(hoist, harness):
    """1 kg, and 2 mu 30 N = 3.5 N: the pads slide off, and meet no force."""
    world = Lift(harness, hoist, [can(mass=1.0)], object_friction=0.03)
    reading = world.hand(CLOSE, 0.4)
    held = reading.width
    assert presses(reading)
    world.lift(0.2, 0.5)
    assert world.height < TOP + 0.08
    reading = world.hand(CLOSE, 0.5)
    assert reading.is_narrower(held) and not presses(reading)


def test_objects_stand_where_they_were_put(hoist, harness):
    """A box, a can and a hull; contact with the plate is no link's."""
    hull = ConvexHull(
        RigidTransform([0, -0.15, TOP + 0.03]),
        0.03 * np.array(np.meshgrid([-1, 1], [-1, 1], [-1, 1])).reshape(3, 8).T,
    )
    box = Box(RigidTransform([0, 0.2, TOP + 0.05]), np.full(3, 0.05))
    put = [can(), SceneObject("box", box, 0.5), SceneObject("dice", hull, 0.1)]
    world = Lift(harness, hoist, put)
    world.dut.advance(0.5)
    for before, after in zip(put, world.objects, strict=True):
        shift = after.X_WO.translation() - before.X_WO.translation()
        assert np.linalg.norm(shift) < 1e-3
        assert tilt(after) < 5e-3
    contact = world.dut.eval("cheat.contact")
    assert contact.others == tuple((n, "box_0") for n in ("box", "can", "dice"))
    assert contact.objects == contact.scene == ()


def test_an_object_of_unknown_mass_is_a_place_to_stand_on(hoist, harness):
    """A block hangs in the air, with a can on it."""
    block = SceneObject(
        "block", Box(RigidTransform([0, 0.2, 0.3]), np.full(3, 0.05))
    )
    on_it = can().at(RigidTransform([0, 0.2, 0.385]))
    world = Lift(harness, hoist, [on_it, block])
    world.dut.advance(0.3)
    assert world.objects[1].X_WO.IsExactlyEqualTo(block.X_WO)
    np.testing.assert_allclose(world.height, 0.385, atol=1e-3)
    assert world.dut.eval("cheat.contact").others == (("block", "can"),)


def test_inertia_is_that_of_the_shape():
    """A box of 2 kg: m (b^2 + c^2) / 12; a wedge's centre is not its frame."""
    turned = RigidTransform(RollPitchYaw(0.1, 0.2, 0.3), [1, 2, 3])
    box = SceneObject("box", Box(turned, np.array([0.05, 0.1, 0.15])), 2.0)
    inertia = object_inertia(box)
    np.testing.assert_allclose(inertia.get_com(), 0, atol=1e-12)
    np.testing.assert_allclose(
        np.diag(inertia.CalcRotationalInertia().CopyToFullMatrix3()),
        [0.13 / 6, 0.1 / 6, 0.05 / 6],
    )
    corners = 0.04 * np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
    wedge = SceneObject("wedge", ConvexHull(turned, corners))
    np.testing.assert_allclose(object_inertia(wedge).get_com(), 0.01)


def test_the_kinematic_station_has_the_same_port(hoist):
    put = (can(),)
    station = MakeSimulatedStation(
        config=KinematicStation(),
        robot=hoist,
        scene=None,
        q0=hoist.q_home,
        objects=put,
    )
    port = station.GetOutputPort("cheat.objects")
    assert port.Eval(station.CreateDefaultContext()) == put


def test_two_objects_of_one_name_are_refused(hoist, harness):
    with pytest.raises(RemoSplatError, match="two objects are named 'can'"):
        Lift(harness, hoist, [can(), can()])
