"""Poses by lanes, against one configuration after the other."""

import numpy as np
import pytest
from effort import effort
from hypothesis import given, settings
from hypothesis import strategies as st

import remosplat_drake as rs
from remosplat_drake.base.kernels import kernel
from remosplat_drake.base.lanes import WIDTH, write_lanes
from remosplat_drake.controller.verification.self_sweep import SelfClearance
from remosplat_drake.robot.kinematics import body_poses
from remosplat_drake.robot.pose_lanes import place_bodies, place_by_lanes
from remosplat_drake.robot.sampling import random_states
from remosplat_drake.robot.self_collision.kernels.pair_distance import (
    centers_in_world,
    least_distance,
    least_distances,
)
from remosplat_drake.robot.self_collision.kernels.separation import separations

SEEDS = st.integers(0, 2**32 - 1)


@kernel
def _placed(tree, q, points):
    X_WL = np.zeros((len(tree.parent), 3, 4, WIDTH))
    place_bodies(tree, q, X_WL, np.zeros((2, 3, 4, WIDTH)))
    body, p_LP = points
    p_WP = np.zeros((len(body), 3, WIDTH))
    place_by_lanes(X_WL, body, p_LP, p_WP)
    return X_WL, p_WP


@kernel
def _bounds(shapes, X_WL, p_WC, pairs, n_A):
    found = np.zeros((2, len(pairs), WIDTH))
    for k in range(len(pairs)):
        i, j = pairs[k, 0], pairs[k, 1]
        bounds = least_distances(shapes, X_WL, p_WC, i, j)
        write_lanes(found, k * WIDTH, bounds)
        gaps = separations(shapes, X_WL, (i, j), n_A)
        write_lanes(found, (len(pairs) + k) * WIDTH, gaps)
    return found


@kernel
def _bounds_at(shapes, X_WL, pairs):
    p_WC, found = centers_in_world(shapes, X_WL), np.zeros(len(pairs))
    for k in range(len(pairs)):
        i, j = pairs[k, 0], pairs[k, 1]
        found[k] = least_distance(shapes, X_WL, p_WC, i, j)
    return found


@pytest.fixture(scope="module", params=["panda", "fetch"])
def own(request) -> SelfClearance:
    return SelfClearance.make(rs.load_robot(request.param), 0.01)


@settings(max_examples=effort(10, 100))
@given(seed=SEEDS)
def test_bodies_are_placed_as_one_by_one(own, seed):
    robot = own.robot
    states = random_states(robot, WIDTH, np.random.default_rng(seed))
    tree, points = robot.tree.arrays, (robot.arrays.body_S, robot.arrays.p_LS)
    X_WL, p_WP = _placed(tree, np.ascontiguousarray(states.T), points)
    for k, q in enumerate(states):
        X, _ = body_poses(tree, q)
        np.testing.assert_allclose(X_WL[..., k], X[:, :3], atol=1e-13)
        p_WS = robot.spheres_at(q).p_WS
        np.testing.assert_allclose(p_WP[..., k], p_WS, atol=1e-13)


@settings(max_examples=effort(10, 100))
@given(seed=SEEDS)
def test_bounds_on_distances_hold_and_are_those_of_one_by_one(own, seed):
    rng, robot = np.random.default_rng(seed), own.robot
    states = random_states(robot, WIDTH, rng)
    arrays = own.pairs.pair_arrays.values
    shapes, pairs = (
        arrays.shapes,
        np.column_stack([arrays.first, arrays.second]),
    )
    points, tree = (shapes.body, shapes.center), robot.tree.arrays
    X_WL, p_WC = _placed(tree, np.ascontiguousarray(states.T), points)
    n_A = rng.normal(size=3)
    n_A /= np.linalg.norm(n_A)
    found, gaps = _bounds(shapes, X_WL, p_WC, pairs, n_A)
    for k, q in enumerate(states):
        X, _ = body_poses(tree, q)
        exact = own.distances(q) - arrays.allowance
        assert (found[:, k] <= exact + 1e-9).all()
        assert (gaps[:, k] <= exact + 1e-9).all()
        one_by_one = _bounds_at(shapes, X, pairs)
        assert (found[:, k] >= one_by_one - 1e-9).all()
