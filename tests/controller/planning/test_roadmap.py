"""Earlier paths make later searches cheaper, and never make them wrong."""

from itertools import pairwise

import numpy as np
import pytest
from pydrake.math import RigidTransform

from remosplat_drake.controller.guidance.selection import start_selection
from remosplat_drake.controller.guidance.selection_round import (
    advance_selection,
)
from remosplat_drake.controller.planning.roadmap import Roadmap
from remosplat_drake.oracle.composite import CompositeDistanceField
from remosplat_drake.oracle.signed_distance import SignedDistanceField
from remosplat_drake.scene.primitive_scene import Box, PrimitiveScene

STOPPING = 0.02


@pytest.fixture(scope="module")
def first(maze):
    return maze.planner().plan(maze.q, maze.X_WT, maze.field, STOPPING)


def beside(maze) -> np.ndarray:
    """A target a little above the maze's."""
    return maze.robot.end_effector_pose(maze.q_target - [0.04, 0.0, 0.0])


def test_the_second_search_is_cheaper_and_ends_at_its_own_target(maze, first):
    roadmap = Roadmap().with_path(first.corners)
    X_WT = beside(maze)
    fresh = maze.planner().plan(maze.q, X_WT, maze.field, STOPPING)
    again = maze.planner().plan(
        maze.q, X_WT, maze.field, STOPPING, roadmap=roadmap
    )
    reached = maze.robot.end_effector_pose(again.path.q[-1])
    np.testing.assert_allclose(reached, X_WT, atol=2e-3)
    assert again.checks < fresh.checks


def test_what_is_blocked_by_now_is_not_used(maze, first):
    """A ball of a box stands where the remembered path leads through."""
    roadmap = Roadmap().with_path(first.corners)
    middle = first.path.at(0.5 * first.path.length)
    p_WS = maze.robot.spheres_at(middle).p_WS[-1]
    box = Box(RigidTransform(p_WS), np.full(3, 0.01))
    blocked = SignedDistanceField(PrimitiveScene(boxes=(box,)))
    field = CompositeDistanceField([maze.field, blocked])
    planner = maze.planner(checks=200)
    space = planner.free_space(maze.q, field, STOPPING)
    assert not space.is_free(middle)
    way = roadmap.path_between(space, maze.q, maze.q_target[None])
    assert way is None or all(
        space.is_free_between(a, b) for a, b in pairwise(way)
    )


def test_the_latest_corners_are_kept():
    roadmap = Roadmap()
    for k in range(60):
        roadmap = roadmap.with_path(np.full((10, 3), float(k)))
    assert len(roadmap.q) == 400
    assert roadmap.q[0, 0] == 20.0
    assert roadmap.edges.min() >= 0
    assert roadmap.edges.max() == 399
    a, b = roadmap.q[roadmap.edges.T]
    np.testing.assert_array_equal(a, b)


def test_a_new_target_remembers_the_path_to_the_one_before(maze):
    rule = maze.rule()
    selection = start_selection(rule)
    world = {
        "time": 0.0,
        "q": maze.q,
        "u": np.zeros(3),
        "field": maze.field,
        "budget": 20_000,
    }
    selection = advance_selection(rule, selection, aim=maze.X_WT, **world)
    assert selection.guidance.path is not None
    assert len(selection.found) == 1
    assert selection.roadmap.q is None
    effort = selection.effort
    assert effort.searches >= 1
    assert effort.first_path == pytest.approx(effort.seconds)
    assert effort.first_checks == effort.checks
    selection = advance_selection(
        rule, selection, aim=beside(maze), **world | {"time": 5.0}
    )
    assert selection.roadmap.q is not None
    assert selection.guidance.path is not None
    more = selection.effort.checks - effort.checks
    assert more < effort.checks
