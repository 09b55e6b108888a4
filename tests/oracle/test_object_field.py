"""Objects as a map: distances, and links that may come nearer than others."""

import pickle

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydrake.math import RigidTransform, RollPitchYaw

from remosplat_drake.oracle.contact_rules import ContactRule, reliefs
from remosplat_drake.oracle.object_field import ObjectField
from remosplat_drake.oracle.signed_distance import SignedDistanceField
from remosplat_drake.robot.sphere_model import Spheres
from remosplat_drake.scene.objects.convex_hull import ConvexHull
from remosplat_drake.scene.objects.scene_object import SceneObject
from remosplat_drake.scene.primitive_scene import Box, Cylinder, PrimitiveScene

X_WO = RigidTransform(RollPitchYaw(0.3, -0.2, 0.5), [0.4, 0.1, 0.2])
CAN = Cylinder(X_WO, 0.1, 0.2)
CRATE = Box(RigidTransform([-0.5, 0, 0]), np.array([0.1, 0.2, 0.3]))
OBJECTS = SceneObject("can", CAN), SceneObject("crate", CRATE)
CORNERS = np.array(
    [(x, y, z) for x in (-1, 1) for y in (-2, 2) for z in (-3, 3)]
)


def _spheres(p_WS, index=None):
    spheres = Spheres.at(p_WS, 0.05)
    index = np.full(len(spheres), -1) if index is None else np.array(index)
    return Spheres(
        spheres.p_WS, spheres.R_WL, spheres.radius, spheres.ignore_below, index
    )


@given(st.integers(0, 10**6))
def test_without_rules_it_is_the_scene(seed):
    p_WS = np.random.default_rng(seed).uniform(-1, 1, (20, 3))
    scene = PrimitiveScene(boxes=(CRATE,), cylinders=(CAN,))
    found = ObjectField(OBJECTS).clearances(_spheres(p_WS))
    wanted = SignedDistanceField(scene).clearances(_spheres(p_WS))
    assert found.distance == pytest.approx(wanted.distance)
    assert found.p_WC == pytest.approx(wanted.p_WC)
    assert found.direction_W == pytest.approx(wanted.direction_W)


@given(st.integers(0, 10**6))
def test_a_hull_in_front_of_its_faces_is_a_box(seed):
    half = np.array([0.1, 0.2, 0.3])
    hull = SceneObject("hull", ConvexHull(X_WO, 0.1 * CORNERS))
    box = SceneObject("box", Box(X_WO, half))
    p_PS = np.random.default_rng(seed).uniform(-1, 1, (50, 3))
    spheres = _spheres(X_WO.multiply(p_PS.T).T)
    found = ObjectField([hull]).clearances(spheres).distance
    exact = ObjectField([box]).clearances(spheres).distance
    faced = (np.abs(p_PS) > half).sum(axis=1) < 2
    assert found[faced] == pytest.approx(exact[faced])
    assert (found <= exact + 1e-12).all()


def test_rules_are_of_pairs():
    rules = [
        ContactRule("can", frozenset({"finger"})),
        ContactRule("can", frozenset({"palm"}), stopping=0.005),
    ]
    relief = reliefs(rules, ["arm", "palm", "finger"], ["can", "crate"], 0.02)
    assert relief[:, 0] == pytest.approx([0.0, 0.015, np.inf, 0.0])
    assert (relief[:, 1] == 0.0).all()


def test_the_distance_of_a_pair_is_its_own():
    rules = [ContactRule("can", frozenset({"palm"}), stopping=0.005)]
    relief = reliefs(rules, ["arm", "palm"], ["can", "crate"], 0.02)
    field = ObjectField(OBJECTS, relief)
    there = np.tile(X_WO.multiply([0.2, 0, 0]), (4, 1))
    # An unknown sphere, and one that has come later, count as the arm's.
    found = field.clearances(_spheres(there, [0, 1, -1, 7]))
    assert found.distance == pytest.approx([0.05, 0.065, 0.05, 0.05])
    # The closest point is where it is.
    assert found.p_WC[1] == pytest.approx(X_WO.multiply([0.1, 0, 0]))


def test_exempt_rows_are_left_out():
    rules = [ContactRule("can", frozenset({"finger"}))]
    relief = reliefs(rules, ["arm", "finger"], ["can"], 0.02)
    field = ObjectField(OBJECTS[:1], relief)
    inside = np.tile(X_WO.translation(), (2, 1))
    found = field.clearances(_spheres(inside, [0, 1]))
    assert found.sphere.tolist() == [0]
    assert found.minimum() == pytest.approx(-0.15)


def test_rules_change_the_revision_and_survive_a_pickle():
    plain = ObjectField(OBJECTS)
    ruled = ObjectField(OBJECTS, np.full((3, 2), 0.01))
    assert plain.revision != ruled.revision
    again = pickle.loads(pickle.dumps(ruled))
    assert again.revision == ruled.revision


def test_names_the_object():
    thing = ObjectField(OBJECTS).thing_at(np.array([-0.4, 0, 0]))
    assert "crate" in str(thing)
