"""Signed distances: by hand, by finite differences, and against Drake."""

import copy

import numpy as np
import pydrake.geometry as drake_geometry
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pydrake.math import RigidTransform, RollPitchYaw

from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.oracle.signed_distance import SignedDistanceField
from remosplat_drake.robot.sphere_model import Spheres
from remosplat_drake.scene.primitive_scene import Box, Cylinder, PrimitiveScene

BOX = PrimitiveScene(
    boxes=(Box(RigidTransform([1, 0, 0]), np.array([0.5, 1.0, 2.0])),)
)
CYLINDER = PrimitiveScene(
    cylinders=(Cylinder(RigidTransform([0, 0, 1]), 0.5, 1.0),)
)


def _random_scene(rng: np.random.Generator) -> PrimitiveScene:
    def pose():
        return RigidTransform(
            RollPitchYaw(rng.uniform(-3, 3, 3)), rng.uniform(-1, 1, 3)
        )

    return PrimitiveScene(
        boxes=tuple(Box(pose(), rng.uniform(0.05, 0.6, 3)) for _ in range(4)),
        cylinders=tuple(
            Cylinder(pose(), *rng.uniform(0.05, 0.6, 2)) for _ in range(4)
        ),
    )


def _one(scene, point, radius=0.0):
    clearances = SignedDistanceField(scene).clearances(
        Spheres.at(np.array(point, float), radius)
    )
    assert len(clearances) == 1
    return clearances


@pytest.mark.parametrize(
    ("point", "distance", "direction"),
    [
        ([0, 0, 0], 0.5, [1, 0, 0]),
        ([1, 1.5, 0], 0.5, [0, -1, 0]),
        ([1.5 + 3, 1 + 4, 0], 5.0, [-0.6, -0.8, 0]),
        ([1.4, 0, 0], -0.1, [-1, 0, 0]),
        ([1, 0, -1.9], -0.1, [0, 0, 1]),
        ([1, 0, 0], -0.5, [-1, 0, 0]),
        ([1.5, 0, 0], 0.0, [-1, 0, 0]),
        ([1.5, 1, 2], 0.0, [-1, 0, 0]),
    ],
)
def test_box_by_hand(point, distance, direction):
    clearances = _one(BOX, point)
    assert clearances.distance[0] == pytest.approx(distance, abs=1e-12)
    np.testing.assert_allclose(clearances.direction_W[0], direction, atol=1e-12)


@pytest.mark.parametrize(
    ("point", "distance", "direction"),
    [
        ([2, 0, 1], 1.5, [-1, 0, 0]),
        ([0, 0.1, 2.5], 0.5, [0, 0, -1]),
        ([0.5 + 3, 0, 2 + 4], 5.0, [-0.6, 0, -0.8]),
        ([0, -0.4, 1], -0.1, [0, 1, 0]),
        ([0, 0, 1], -0.5, [-1, 0, 0]),
        ([0, 0, 1.9], -0.1, [0, 0, -1]),
        ([0.5, 0, 2], 0.0, [-1, 0, 0]),
    ],
)
def test_cylinder_by_hand(point, distance, direction):
    clearances = _one(CYLINDER, point)
    assert clearances.distance[0] == pytest.approx(distance, abs=1e-12)
    np.testing.assert_allclose(clearances.direction_W[0], direction, atol=1e-12)


def test_radius_shortens_the_distance_but_not_the_witness():
    clearances = _one(BOX, [0, 0, 0], radius=0.2)
    assert clearances.distance[0] == pytest.approx(0.3)
    np.testing.assert_allclose(clearances.p_WC[0], [0.5, 0, 0])


def _drake_signed_distances(scene, points):
    """Distance, gradient and witness of all pairs, (points, primitives)."""
    scene_graph = drake_geometry.SceneGraph()
    source = scene_graph.RegisterSource("test")
    order = {}
    for i, p in enumerate(scene.primitives):
        shape = (
            drake_geometry.Box(*(2 * p.half_extents))
            if isinstance(p, Box)
            else drake_geometry.Cylinder(p.radius, 2 * p.half_height)
        )
        instance = drake_geometry.GeometryInstance(p.X_WP, shape, f"p{i}")
        instance.set_proximity_properties(drake_geometry.ProximityProperties())
        order[scene_graph.RegisterAnchoredGeometry(source, instance)] = i
    context = scene_graph.CreateDefaultContext()
    query = scene_graph.get_query_output_port().Eval(context)
    distance = np.empty((len(points), len(order)))
    gradient = np.empty((len(points), len(order), 3))
    for i, point in enumerate(points):
        for answer in query.ComputeSignedDistanceToPoint(point):
            j = order[answer.id_G]
            distance[i, j] = answer.distance
            gradient[i, j] = answer.grad_W
    return distance, gradient


@settings(max_examples=10)
@given(st.integers(0, 10_000))
def test_agrees_with_scene_graph(seed):
    rng = np.random.default_rng(seed)
    scene = _random_scene(rng)
    points = rng.uniform(-1.5, 1.5, (20, 3))
    distance, gradient = _drake_signed_distances(scene, points)

    field = SignedDistanceField(scene, rows="per_primitive")
    rows = field.clearances(Spheres.at(points))
    assert rows.sphere.tolist() == np.repeat(np.arange(20), 8).tolist()
    np.testing.assert_allclose(
        rows.distance.reshape(20, 8), distance, atol=1e-12
    )
    np.testing.assert_allclose(
        rows.direction_W.reshape(20, 8, 3), -gradient, atol=1e-9
    )

    closest = SignedDistanceField(scene).clearances(Spheres.at(points))
    np.testing.assert_allclose(closest.distance, distance.min(1), atol=1e-12)


@settings(max_examples=10)
@given(st.integers(0, 10_000))
def test_direction_is_minus_the_gradient(seed):
    rng = np.random.default_rng(seed)
    field = SignedDistanceField(_random_scene(rng), rows="per_primitive")
    points = rng.uniform(-1.5, 1.5, (20, 3))
    step = 1e-6
    gradient = np.stack(
        [
            (
                field.clearances(Spheres.at(points + e)).distance
                - field.clearances(Spheres.at(points - e)).distance
            )
            / (2 * step)
            for e in step * np.eye(3)
        ],
        axis=1,
    )
    rows = field.clearances(Spheres.at(points))
    # A step across a medial axis sees both sides of the kink.
    smooth = np.abs(np.linalg.norm(gradient, axis=1) - 1) < 1e-6
    assert smooth.mean() > 0.95
    np.testing.assert_allclose(
        rows.direction_W[smooth], -gradient[smooth], atol=1e-5
    )
    np.testing.assert_allclose(
        rows.p_WC,
        points[rows.sphere] + rows.distance[:, None] * rows.direction_W,
        atol=1e-12,
    )


def test_rows_at_or_beyond_max_distance_are_left_out():
    spheres = Spheres.at(np.array([[0, 0, 0], [-1, 0, 0]]), 0.1)
    rows = SignedDistanceField(BOX).clearances(spheres, max_distance=1.0)
    assert rows.sphere.tolist() == [0]
    assert not len(SignedDistanceField(BOX).clearances(spheres, 0.4))


def test_low_primitives_are_unseen_by_some_spheres():
    scene = BOX.with_floor()
    point = np.array([[-1.0, 0, 0.02]] * 2)
    spheres = Spheres.at(point, 0.1)
    spheres = Spheres(
        spheres.p_WS, spheres.R_WL, spheres.radius, np.array([0.03, -np.inf])
    )
    rows = SignedDistanceField(scene).clearances(spheres)
    np.testing.assert_allclose(rows.distance, [1.4, -0.08])


def test_empty_scene_has_no_rows():
    field = SignedDistanceField(PrimitiveScene())
    assert not len(field.clearances(Spheres.at(np.zeros((3, 3)))))


def test_revision_names_geometry_and_rows():
    revisions = {
        SignedDistanceField(BOX).revision,
        SignedDistanceField(BOX, rows="per_primitive").revision,
        SignedDistanceField(CYLINDER).revision,
    }
    assert len(revisions) == 3
    assert SignedDistanceField(BOX).revision in revisions


def test_copy_is_the_field_itself():
    field = SignedDistanceField(BOX)
    assert copy.deepcopy(field) is field


def test_rejects_unknown_rows():
    with pytest.raises(RemoSplatError, match="closest, per_primitive"):
        SignedDistanceField(BOX, rows="per_primitives")
