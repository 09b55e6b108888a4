"""The distances of shipped robots, by two libraries that are not ours."""

import itertools

import numpy as np
import pytest
from pydrake.geometry import Role
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph
from pydrake.systems.framework import DiagramBuilder

from remosplat_drake.robot.model_file import add_robot_model
from remosplat_drake.robot.robot_description import shipped_robots
from remosplat_drake.robot.robot_model import RobotModel, load_robot
from remosplat_drake.robot.self_collision.pairs import (
    SelfCollisionPairs,
    self_collision_pairs,
)

TOLERANCE = 5e-3
"""How well Drake measures hulls that are near each other [m]. Elsewhere it
finds up to a tenth too much, and of cylinders up to a third: the points that it
names are not the nearest."""


class SceneGraphOf:
    """A robot in Drake's scene graph, shape by shape."""

    def __init__(self, robot: RobotModel):
        builder = DiagramBuilder()
        plant, scene_graph = AddMultibodyPlantSceneGraph(builder, 0.0)
        add_robot_model(robot.description, plant)
        for name, position in robot.description.locked.items():
            plant.GetJointByName(name).set_default_positions([position])
        plant.Finalize()
        self._diagram = builder.Build()
        self._root = self._diagram.CreateDefaultContext()
        self._plant = plant
        self._context = plant.GetMyMutableContextFromRoot(self._root)
        joints = [plant.GetJointByName(name) for name in robot.joint_names]
        self._rows = [joint.position_start() for joint in joints]
        inspector = scene_graph.model_inspector()
        self._ids = inspector.GetAllGeometryIds(Role.kProximity)

    def distances(self, pairs: SelfCollisionPairs, q: np.ndarray) -> np.ndarray:
        positions = self._plant.GetPositions(self._context)
        positions[self._rows] = q
        self._plant.SetPositions(self._context, positions)
        query = self._plant.get_geometry_query_input_port().Eval(self._context)
        return np.array(
            [
                query.ComputeSignedDistancePairClosestPoints(
                    self._ids[i], self._ids[j]
                ).distance
                for i, j in zip(
                    pairs.pairs.first, pairs.pairs.second, strict=True
                )
            ]
        )


def configurations(robot: RobotModel, n: int):
    """Anywhere within the joint limits, and on the way to what touches.

    Between a configuration in which links overlap and one in which they do
    not, the last look before they do is as near as a micrometre.
    """
    rng = np.random.default_rng(11)
    pairs = self_collision_pairs(robot, 0.0)
    arm = np.isfinite(robot.position_lower)
    lower = np.where(arm, robot.position_lower, 0.0)
    upper = np.where(arm, robot.position_upper, 0.0)

    def least(q: np.ndarray) -> float:
        return pairs.distances(q, 0.01).min()

    free = robot.q_home
    assert least(free) > 0
    for q in rng.uniform(lower, upper, (n, robot.n_q)):
        yield q
        if least(q) >= 0:
            continue
        clear, overlapping = free, q
        for _ in range(20):
            middle = 0.5 * (clear + overlapping)
            if least(middle) > 0:
                clear = middle
            else:
                overlapping = middle
        yield clear
        yield overlapping


@pytest.mark.parametrize("name", shipped_robots())
def test_drake_measures_the_same(name):
    robot = load_robot(name)
    pairs, theirs = self_collision_pairs(robot, 0.0), SceneGraphOf(robot)
    touching = 0
    for q in configurations(robot, 120):
        ours, expected = pairs.distances(q), theirs.distances(pairs, q)
        apart = (ours > 0) & (expected > 0)
        assert (ours[apart] < expected[apart] + TOLERANCE).all()
        assert (expected[apart] < 1.5 * ours[apart] + TOLERANCE).all()
        # No miss and no false alarm; how deep hulls are, Drake exaggerates.
        assert (ours[~apart] < TOLERANCE).all()
        assert (expected[~apart] < TOLERANCE).all()
        touching += abs(ours).min() < 1e-5
    assert touching >= 2


def test_coal_measures_the_same():
    coal = pytest.importorskip("coal")
    robot = load_robot("frankie")
    pairs = self_collision_pairs(robot, 0.0)
    shapes, body = pairs.shapes, pairs.pairs.shapes.body
    hulls = []
    for shape in shapes.shapes:
        points = coal.StdVec_Vec3s()
        points.extend(list(shape.vertices))
        hulls.append(coal.Convex.convexHull(points, False, "Qt"))
    request, result = coal.DistanceRequest(), coal.DistanceResult()
    for q in configurations(robot, 25):
        X_WL = robot.body_poses(q)
        poses = [coal.Transform3s(X[:3, :3], X[:3, 3]) for X in X_WL]
        expected = []
        for i, j in zip(pairs.pairs.first, pairs.pairs.second, strict=True):
            result.clear()
            placed = hulls[i], poses[body[i]], hulls[j], poses[body[j]]
            expected.append(coal.distance(*placed, request, result))
        np.testing.assert_allclose(pairs.distances(q), expected, atol=1e-5)


def test_what_is_enough_hides_nothing():
    """Bounds of boxes and balls are none too high."""
    robot = load_robot("frankie")
    pairs = self_collision_pairs(robot, 0.01)
    for q, enough in zip(
        configurations(robot, 30), itertools.cycle([0.0, 0.05, 0.3])
    ):
        exact, found = pairs.distances(q), pairs.distances(q, enough)
        near = exact < enough
        np.testing.assert_allclose(found[near], exact[near], atol=1e-9)
        assert (found <= exact + 1e-9).all()
        assert (found[~near] >= enough - 1e-9).all()
