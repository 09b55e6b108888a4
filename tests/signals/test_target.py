"""Constrained and free directions of a target."""

import copy
import dataclasses as dc
import pickle

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pydrake.common.eigen_geometry import AngleAxis
from pydrake.math import RigidTransform

from remosplat_drake.robot.pose_error import pose_error
from remosplat_drake.robot.target_arrays import place_on_line
from remosplat_drake.signals.target import DIRECTIONS, Line, Target


def rotation(angle: float, axis) -> np.ndarray:
    axis = np.array(axis, float) / np.linalg.norm(axis)
    return AngleAxis(angle, axis).rotation()


def pose(p=(0.0, 0.0, 0.0), R=None) -> np.ndarray:
    X = np.eye(4)
    X[:3, 3] = p
    X[:3, :3] = np.eye(3) if R is None else R
    return X


def some_pose(rng) -> np.ndarray:
    return pose(
        rng.normal(size=3), rotation(rng.uniform(0, 3), rng.normal(size=3))
    )


def assert_equal_errors(one, other):
    for a, b in zip(vars(one).values(), vars(other).values(), strict=True):
        np.testing.assert_array_equal(a, b)


@pytest.mark.parametrize("seed", range(5))
def test_a_plain_target_is_its_pose_to_the_last_digit(seed):
    rng = np.random.default_rng(seed)
    X_WE, X_WT = some_pose(rng), some_pose(rng)
    for target in (Target.of(X_WT), Target.of(RigidTransform(X_WT))):
        assert target.is_plain
        assert_equal_errors(target.error(X_WE), pose_error(X_WE, X_WT))
    assert Target.of(target) is target
    assert copy.deepcopy(target) is target


def test_a_position_alone_has_no_angle():
    target = Target(pose((1, 2, 3))).without("rx", "ry", "rz")
    error = target.error(pose((1, 2, 1), rotation(2.0, (1, 1, 0))))
    assert error.angle == 0.0
    assert error.distance == pytest.approx(2.0)
    assert target.free == ("rx", "ry", "rz")
    assert not target.constrains_rotation


def test_a_screw_may_turn_about_its_axis_and_may_not_tilt():
    target = Target(pose()).without("rz")
    tilt = rotation(0.3, (1, 0, 0))
    for turn in (0.0, 1.0, np.pi, 5.0):
        error = target.error(pose(R=tilt @ rotation(turn, (0, 0, 1))))
        np.testing.assert_allclose(error.rotation_W, (-0.3, 0, 0), atol=1e-12)


def test_a_way_along_the_targets_own_axis_is_free():
    target = Target(pose(R=rotation(np.pi / 2, (0, 0, 1)))).without("x")
    error = target.error(pose((0.2, 7.0, -0.1)))  # T's x axis is W's y axis.
    np.testing.assert_allclose(error.p_ET_W, (-0.2, 0, 0.1), atol=1e-12)
    np.testing.assert_allclose(error.p_ET_E, (-0.2, 0, 0.1), atol=1e-12)


def test_an_axis_that_points_the_other_way_is_turned_round():
    target = Target(pose()).without("rz")
    over = pose(R=rotation(np.pi, (0, 1, 0)))
    assert target.error(over).angle == pytest.approx(np.pi)
    X_WN = target.nearest_pose(over)
    np.testing.assert_allclose(X_WN[:3, 2], (0, 0, 1), atol=1e-9)


@given(
    st.sets(st.sampled_from(DIRECTIONS)).filter(
        lambda free: (
            len({"rx", "ry", "rz"}.intersection(free)) in (0, 1, 3)
            and len(free) < 6
        )
    ),
    st.integers(0, 10**9),
)
@settings(max_examples=100, deadline=None)
def test_the_error_leads_to_the_nearest_pose_that_has_what_is_asked(free, seed):
    rng = np.random.default_rng(seed)
    target = Target(some_pose(rng)).without(*free)
    X_WE = some_pose(rng)
    error, X_WN = target.error(X_WE), target.nearest_pose(X_WE)
    there = target.error(X_WN)
    assert there.distance == pytest.approx(0, abs=1e-9)
    assert there.angle == pytest.approx(0, abs=1e-6)
    # What is free of the target may be shifted: no other pose is nearer.
    other = np.array(target.X_WT)
    for name, way in zip(("x", "y", "z"), rng.normal(size=3), strict=True):
        if name in free:
            other[:3, 3] += way * other[:3, DIRECTIONS.index(name) - 3]
    turns = {"rx", "ry", "rz"}.intersection(free)
    if turns:
        axis = rng.normal(size=3)
        if len(turns) == 1:
            axis = np.eye(3)[DIRECTIONS.index(*turns)]
        other[:3, :3] = other[:3, :3] @ rotation(rng.uniform(0, 3), axis)
    apart = pose_error(X_WE, other)
    assert apart.distance >= error.distance - 1e-9
    assert apart.angle >= error.angle - 1e-6


@pytest.mark.parametrize(
    ("weights", "problem"),
    [
        (np.ones(5), "expected 6 weights"),
        (np.array([1, 1, 1, 1, 1, -1.0]), "not negative"),
        (np.array([1, 1, 1, 1, 1, np.nan]), "finite"),
        (np.zeros(6), "all six directions are free"),
        (np.array([0, 0, 1, 1, 1, 1.0]), "none, one or all"),
    ],
)
def test_weights_that_mean_nothing_are_refused(weights, problem):
    with pytest.raises(ValueError, match=problem):
        Target(np.eye(4), weights)


def test_targets_are_told_apart_by_what_they_ask():
    target = Target(pose((1, 2, 3)))
    assert target.equals(pickle.loads(pickle.dumps(target)))
    for changes in (
        {"X_WT": pose((1, 2, 4))},
        {"weights": np.array([1, 1, 1, 1, 1, 2.0])},
        {"line": Line(pose(), 0.1)},
        {"passed_within": 0.1},
        {"onward": 0.1},
    ):
        assert not target.equals(dc.replace(target, **changes))


def test_what_is_passed_counts_by_its_distance():
    passed = Target(pose((1, 0, 0)), passed_within=0.05)
    near = passed.error(pose((0.96, 0, 0), rotation(1.0, (1, 0, 0))))
    assert passed.is_reached(near, lambda error: False)
    far = passed.error(pose((0.94, 0, 0)))
    assert not passed.is_reached(far, lambda error: True)
    held = Target(pose((1, 0, 0)))
    assert held.is_reached(far, lambda error: True)


class TestLine:
    """From the origin 2 m along x, with a quarter turn about z."""

    target = Target(
        pose((2, 0, 0), rotation(np.pi / 2, (0, 0, 1))), line=Line(pose(), 0.1)
    )

    def place(self, X_WE, target=None):
        return place_on_line(X_WE, (target or self.target).arrays)

    def test_halfway_half_the_turn_is_asked_for(self):
        beside = pose((1, 0.03, 0))
        along, left, p_ES_W, rotation_W, turn_W = self.place(beside)
        np.testing.assert_allclose(along, (1, 0, 0), atol=1e-12)
        assert left == pytest.approx(1.0)
        np.testing.assert_allclose(p_ES_W, (0, -0.03, 0), atol=1e-12)
        np.testing.assert_allclose(rotation_W, (0, 0, np.pi / 4), atol=1e-12)
        np.testing.assert_allclose(turn_W, (0, 0, np.pi / 4), atol=1e-12)
        assert self.target.line_deviation(beside) == pytest.approx(0.03)

    def test_before_its_start_the_start_is_nearest(self):
        _, left, p_ES_W, rotation_W, _ = self.place(pose((-0.3, 0, 0.4)))
        assert left == pytest.approx(2.0)
        np.testing.assert_allclose(p_ES_W, (0.3, 0, -0.4), atol=1e-12)
        np.testing.assert_allclose(rotation_W, np.zeros(3), atol=1e-12)

    def test_at_its_end_the_target_is_asked_for(self):
        _, left, p_ES_W, rotation_W, _ = self.place(self.target.X_WT)
        assert left == pytest.approx(0.0)
        np.testing.assert_allclose(p_ES_W, np.zeros(3), atol=1e-12)
        np.testing.assert_allclose(rotation_W, np.zeros(3), atol=1e-12)

    def test_what_is_free_is_free_on_the_way(self):
        target = self.target.without("rz", "z")
        turned = pose((1, 0, 5), rotation(2.0, (0, 0, 1)))
        _, _, p_ES_W, rotation_W, turn_W = self.place(turned, target)
        np.testing.assert_allclose(p_ES_W, np.zeros(3), atol=1e-12)
        np.testing.assert_allclose(rotation_W, np.zeros(3), atol=1e-12)
        np.testing.assert_allclose(turn_W, np.zeros(3), atol=1e-12)

    def test_without_length_it_is_the_target(self):
        target = dc.replace(self.target, line=Line(self.target.X_WT, 0.1))
        along, left, p_ES_W, _, _ = self.place(pose((2, 1, 0)), target)
        np.testing.assert_array_equal(along, np.zeros(3))
        assert left == 0.0
        np.testing.assert_allclose(p_ES_W, (0, -1, 0), atol=1e-12)

    def test_there_is_no_deviation_without_a_line(self):
        assert np.isnan(Target(pose()).line_deviation(pose()))
