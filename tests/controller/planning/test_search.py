"""Trees, searches and shortcuts, held against slow references."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pydrake.math import RigidTransform

from remosplat_drake.controller.planning.free_space import FreeSpace
from remosplat_drake.controller.planning.kernels.base_spheres import (
    base_spheres,
    may_stand,
)
from remosplat_drake.controller.planning.kernels.shortcuts import motion_time
from remosplat_drake.controller.planning.kernels.trees import (
    GOAL,
    START,
    Trees,
    nearest,
)
from remosplat_drake.controller.planning.search import Search
from remosplat_drake.oracle.signed_distance import SignedDistanceField
from remosplat_drake.scene.primitive_scene import Box, PrimitiveScene

STOPPING = 0.02


def maze_space(maze) -> FreeSpace:
    bounds = maze.robot.position_lower, maze.robot.position_upper
    return FreeSpace(maze.robot, maze.field, STOPPING, None, bounds, maze.q)


def search_in(space, q, checks=1500, seed=1, **settings) -> Search:
    lower, upper = space.lower.copy(), space.upper.copy()
    if space.robot.n_base:
        lower[:3], upper[:3] = (-3.0, -3.0, -np.pi), (6.0, 3.0, np.pi)
    return Search(space, q, (lower, upper), checks, seed, **settings)


def are_free(space, corners) -> bool:
    return all(space.is_free_between(a, b) for a, b in pairwise(corners))


@settings(max_examples=30)
@given(
    seed=st.integers(0, 1000), count=st.integers(1, 70), n_base=st.booleans()
)
def test_the_nearest_node_is_that_of_all_distances(seed, count, n_base):
    rng = np.random.default_rng(seed)
    start, goals = rng.normal(0, 4, 5), rng.normal(0, 4, (count, 5))
    q = rng.normal(0, 4, 5)
    trees = Trees.rooted(start, goals).with_capacity(9)
    off = goals - q
    if n_base:
        off[:, 2] = (off[:, 2] + np.pi) % (2 * np.pi) - np.pi
    expected = np.linalg.norm(off, axis=1).argmin()
    assert nearest(trees.packed, GOAL, q, 2 * n_base) == expected
    assert nearest(trees.packed, START, q, 2 * n_base) == 0


def test_trees_grow_and_keep_their_nodes():
    goals = np.arange(6.0).reshape(2, 3)
    trees = Trees.rooted(np.full(3, 9.0), goals)
    more = trees.with_capacity(trees.q.shape[2])
    assert more.q.shape[2] >= 2 + trees.q.shape[2]
    assert more.with_capacity(1) is more
    np.testing.assert_array_equal(more.branch(GOAL, 1), goals[1:])
    np.testing.assert_array_equal(more.branch(START, 0), np.full((1, 3), 9.0))


@pytest.mark.parametrize("seed", range(1, 7))
def test_paths_are_free_and_end_at_a_goal(maze, seed):
    space = maze_space(maze)
    goals = np.stack([maze.q_target + 0.01, maze.q_target])
    search = search_in(space, maze.q, seed=seed)
    corners = search.path_to(goals)
    assert corners is not None and space.checks <= search.checks
    assert are_free(space, corners)
    np.testing.assert_array_equal(corners[0], maze.q)
    assert (corners[-1] == goals).all(axis=1).any()
    shorter = search.shortened(corners)
    assert are_free(space, shorter)
    np.testing.assert_array_equal(shorter[[0, -1]], corners[[0, -1]])
    time = [
        sum(motion_time(space.arrays, a, b) for a, b in pairwise(way))
        for way in (corners, shorter)
    ]
    assert time[1] <= time[0] + 1e-9


def test_equal_seeds_find_equal_paths_and_others_do_not(maze):
    found = [
        search_in(maze_space(maze), maze.q, seed=seed).path_to(
            maze.q_target[None]
        )
        for seed in (3, 3, 4)
    ]
    one, again, other = found
    assert one is not None and again is not None and other is not None
    assert np.array_equal(one, again)
    assert not np.array_equal(one, other)


@pytest.mark.parametrize("checks", [0, 1, 7, 150])
def test_no_search_looks_more_often_than_it_may(maze, checks):
    field = SignedDistanceField(
        PrimitiveScene(
            boxes=(
                *maze.field.scene.boxes,
                Box(RigidTransform([0.9, 0, 0.45]), np.array([0.25, 0.5, 0.2])),
            )
        )
    )
    bounds = maze.robot.position_lower, maze.robot.position_upper
    space = FreeSpace(maze.robot, field, STOPPING, None, bounds, maze.q)
    search = search_in(space, maze.q, checks)
    assert search.path_to(maze.q_target[None]) is None
    assert space.checks == checks


def test_an_interrupted_search_ends_at_the_next_chunk(maze):
    space, asked = maze_space(maze), []

    def interrupted() -> bool:
        asked.append(space.checks)
        return len(asked) > 1

    beyond = maze.q_target + np.array([0.0, 9.0, 0.0])
    search = search_in(space, maze.q, 100_000, interrupted=interrupted)
    assert search.path_to(beyond[None]) is None
    assert len(asked) == 2 and space.checks < 1000


def test_a_straight_motion_to_the_best_goal_is_taken(maze):
    space = maze_space(maze)
    goals = np.stack([maze.q_target, maze.q - 0.3, maze.q - 0.1])
    corners = search_in(space, maze.q).straight_to(goals)
    assert corners is not None
    np.testing.assert_array_equal(corners, [maze.q, goals[1]])


def test_motions_of_a_base_are_checked_as_they_are_driven(frankie):
    """It drives backwards into a niche no farther than it may."""
    wall = Box(RigidTransform([2.0, 1.6, 1.0]), np.array([0.05, 1.0, 1.0]))
    other = Box(RigidTransform([2.0, -1.6, 1.0]), np.array([0.05, 1.0, 1.0]))
    room = SignedDistanceField(PrimitiveScene(boxes=(wall, other)))
    bounds = frankie.position_lower, frankie.position_upper
    q = np.array([0.0, 0.8, np.pi, *frankie.home])
    goal = np.array([4.0, 0.5, np.pi, *frankie.home])
    space = FreeSpace(frankie, room, STOPPING, None, bounds, q, 0.5)
    search = search_in(space, q)
    corners = search.path_to(goal[None])
    assert corners is not None
    assert are_free(space, corners)
    assert are_free(space, search.shortened(corners))


@settings(max_examples=40)
@given(x=st.floats(-1.5, 1.5), y=st.floats(-1.5, 1.5), yaw=st.floats(-4.0, 4.0))
def test_where_a_base_may_stand_is_where_its_spheres_are_clear(
    frankie, x, y, yaw
):
    post = Box(RigidTransform([0.0, 0.0, 0.3]), np.array([0.3, 0.1, 0.3]))
    field = SignedDistanceField(PrimitiveScene(boxes=(post,)))
    bounds = frankie.position_lower, frankie.position_upper
    far = np.array([5.0, 0.0, 0.0, *frankie.home])
    space = FreeSpace(frankie, field, STOPPING, None, bounds, far)
    q = np.array([x, y, yaw, *frankie.home])
    spheres = frankie.spheres_at(q).select(~frankie.moved_by_arm)
    least = field.clearances(spheres).minimum()
    base = base_spheres(space.arrays)
    for _ in range(2):  # The order changes, and the answer does not.
        may = may_stand(space.arrays, 0, base, q)
        if abs(least - STOPPING) > 1e-6:
            assert may == (least > STOPPING)
