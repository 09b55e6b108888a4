"""A distance field as a Drake system: cached, swappable, never copied."""

import copy

import numpy as np
import pytest
from pydrake.common.value import Value
from pydrake.math import RigidTransform

from remosplat_drake.oracle.distance_oracle import DistanceOracle
from remosplat_drake.oracle.signed_distance import SignedDistanceField
from remosplat_drake.scene.primitive_scene import Box, PrimitiveScene
from remosplat_drake.signals.distance_field import Clearances


class CountingField(SignedDistanceField):
    queries = 0

    def clearances(self, spheres, max_distance=np.inf):
        self.queries += 1
        return super().clearances(spheres, max_distance)


def slab(top: float) -> CountingField:
    box = Box(RigidTransform([0, 0, top - 1]), np.array([3.0, 3.0, 1.0]))
    return CountingField(PrimitiveScene(boxes=(box,)))


class Bench:
    """An oracle over a slab, whose inputs are set by hand."""

    def __init__(self, robot):
        self.field = slab(0.5)
        self.system = DistanceOracle(
            robot=robot, field=self.field, max_distance=0.45
        )
        self.context = self.system.CreateDefaultContext()
        self.pose(np.zeros(robot.n_q))

    def pose(self, q) -> None:
        self.system.GetInputPort("configuration").FixValue(self.context, q)

    def give(self, field) -> None:
        port = self.system.GetInputPort("distance_field")
        port.FixValue(self.context, Value[object](field))

    def clearances(self) -> Clearances:
        return self.system.GetOutputPort("clearances").Eval(self.context)


@pytest.fixture
def bench(three_link) -> Bench:
    return Bench(three_link)


def test_it_answers_for_the_measured_configuration(bench, three_link):
    # The arm is level, 0.5 m above the slab; its spheres are 0.11 m and
    # 0.04 m thick, and what is farther than 0.45 m is left out.
    answer = bench.clearances()
    thick = np.flatnonzero(three_link.spheres.radius > 0.1)
    np.testing.assert_array_equal(answer.sphere[: len(thick)], thick)
    np.testing.assert_allclose(answer.distance[: len(thick)], 0.39)
    assert (answer.distance < 0.45).all()
    assert answer.revision == bench.field.revision


def test_a_configuration_is_asked_about_once(bench):
    first = bench.clearances()
    assert bench.clearances() is first
    assert bench.field.queries == 1
    bench.pose(np.array([0.1, 0, 0]))
    assert bench.clearances() is not first
    assert bench.field.queries == 2


def test_a_new_map_takes_over_at_once(bench):
    before = bench.clearances()
    higher = slab(0.6)
    bench.give(higher)
    after = bench.clearances()
    assert after.revision == higher.revision != before.revision
    assert after.minimum() == pytest.approx(before.minimum() - 0.1)
    port = bench.system.GetOutputPort("distance_field")
    assert port.Eval(bench.context) is higher


def test_the_map_is_handed_on_uncopied(bench):
    port = bench.system.GetOutputPort("distance_field")
    assert port.Eval(bench.context) is bench.field
    assert copy.deepcopy(bench.field) is bench.field
    answer = bench.clearances()
    assert copy.deepcopy(answer) is answer


def test_nothing_is_known_of_an_unknown_configuration(bench, three_link):
    bench.pose(np.full(3, np.nan))
    answer = bench.clearances()
    assert len(answer) == len(three_link.spheres)
    assert np.isnan(answer.distance).all()
    assert bench.field.queries == 0
