"""A map that lies elsewhere: no nearer than the margin says, for any pose."""

import dataclasses as dc

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import ConstantVectorSource

from remosplat_drake.oracle.composite import CompositeDistanceField
from remosplat_drake.oracle.distance_oracle import DistanceOracle
from remosplat_drake.oracle.signed_distance import SignedDistanceField
from remosplat_drake.oracle.uncertain_placement import UncertainPlacement
from remosplat_drake.robot.planar_pose import matrix
from remosplat_drake.robot.sphere_model import Spheres
from remosplat_drake.signals.distance_field import Clearances, DistanceField

SHIFT, TURN = 0.02, 0.03


def moved(p_WS: np.ndarray, p_WB: np.ndarray, error: np.ndarray) -> np.ndarray:
    """Where points of a robot truly are whose base is off by an error."""
    around = matrix(np.array([*p_WB, 0.0]))
    X = around @ matrix(error) @ np.linalg.inv(around)
    return p_WS @ X[:3, :3].T + X[:3, 3]


@settings(max_examples=100)
@given(st.integers(0, 2**32 - 1))
def test_no_error_within_the_bounds_comes_nearer(scene, seed):
    random = np.random.default_rng(seed)
    field = SignedDistanceField(scene)
    p_WB = random.uniform(-1, 1, 2)
    p_WS = random.uniform([-1, -1, 0], [2, 1, 1.5], (20, 3))
    way = random.uniform(0, 2 * np.pi)
    shift = SHIFT * np.array([np.cos(way), np.sin(way)])
    error = np.array([*shift, random.choice([-TURN, TURN])])
    uncertain = UncertainPlacement(field, p_WB, SHIFT, TURN)
    told = uncertain.clearances(Spheres.at(p_WS)).per_sphere(20)
    true = field.clearances(Spheres.at(moved(p_WS, p_WB, error)))
    outside = told > 0
    assert (told[outside] <= true.per_sphere(20)[outside] + 1e-9).all()


def test_the_margin_is_that_of_each_lever_arm(scene):
    field = SignedDistanceField(scene)
    uncertain = UncertainPlacement(field, np.array([1.0, 2.0]), SHIFT, TURN)
    p_WS = np.array([[1.0, 2.0, 5.0], [1.0, 4.0, 0.0]])
    np.testing.assert_allclose(uncertain.margin(p_WS), [0.02, 0.02 + 0.06])


class UnknownField(DistanceField):
    """A map that does not know where one sphere stands."""

    revision = "unknown"
    is_lipschitz = True

    def __init__(self, sphere: int):
        self._sphere = sphere

    def clearances(self, spheres, max_distance=np.inf):
        answer = Clearances.unknown(len(spheres))
        distance = np.full(len(spheres), 0.1)
        distance[self._sphere] = np.nan
        answer = dc.replace(answer, distance=distance)
        return answer.within(max_distance)


def test_what_is_not_known_stays_so(scene):
    """It must not count as far away, or the robot would not brake for it."""
    spheres = Spheres.at([[0.0, 0.0, 1.0], [5.0, 0.0, 1.0]])
    for field in (
        UncertainPlacement(UnknownField(1), np.zeros(2), SHIFT, TURN),
        CompositeDistanceField([SignedDistanceField(scene), UnknownField(1)]),
    ):
        found = field.clearances(spheres, 0.05)
        np.testing.assert_array_equal(found.sphere, [1])
        assert np.isnan(found.minimum())


@settings(max_examples=50)
@given(st.integers(0, 2**32 - 1))
def test_it_stays_lipschitz(scene, seed):
    random = np.random.default_rng(seed)
    field = SignedDistanceField(scene)
    uncertain = UncertainPlacement(field, np.zeros(2), SHIFT, 0.3)
    p = random.uniform([-1, -1, 0], [2, 1, 1.5], (2, 20, 3))
    a, b = (uncertain.clearances(Spheres.at(x)).per_sphere(20) for x in p)
    assert (np.abs(a - b) <= np.linalg.norm(p[0] - p[1], axis=1) + 1e-9).all()


def test_rows_within_the_reach_are_all_there(scene):
    field = SignedDistanceField(scene)
    uncertain = UncertainPlacement(field, np.zeros(2), SHIFT, TURN)
    spheres = Spheres.at(np.random.default_rng(0).uniform(0, 1.5, (50, 3)))
    near = uncertain.clearances(spheres, 0.2)
    every = uncertain.clearances(spheres).within(0.2)
    np.testing.assert_array_equal(near.sphere, every.sphere)
    np.testing.assert_array_equal(near.distance, every.distance)


@pytest.mark.parametrize("uncertainty", [(0.0, 0.0), (SHIFT, TURN)])
def test_the_oracle_tells_what_is_left(frankie, scene, uncertainty):
    builder = DiagramBuilder()
    q = builder.AddSystem(ConstantVectorSource(frankie.q_home))
    field = SignedDistanceField(scene)
    oracle = DistanceOracle.AddToBuilder(
        builder,
        robot=frankie,
        field=field,
        configuration=q.get_output_port(),
        max_distance=5.0,
    )
    diagram = builder.Build()
    root = diagram.CreateDefaultContext()
    context = oracle.GetMyContextFromRoot(root)
    oracle.GetInputPort("base_uncertainty").FixValue(context, uncertainty)
    told = oracle.GetOutputPort("clearances").Eval(context)
    spheres = frankie.spheres_at(frankie.q_home)
    expected = UncertainPlacement(
        field, frankie.q_home[:2], *uncertainty
    ).clearances(spheres, 5.0)
    np.testing.assert_allclose(told.distance, expected.distance)
    handed_out = oracle.GetOutputPort("distance_field").Eval(context)
    again = handed_out.clearances(spheres, 5.0)
    np.testing.assert_array_equal(again.distance, told.distance)
