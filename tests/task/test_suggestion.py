"""A task for an unknown scene: somewhere free, close to something."""

import dataclasses as dc
import itertools
import tracemalloc

import numpy as np
import pytest
from pydrake.math import RigidTransform

from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.oracle.signed_distance import SignedDistanceField
from remosplat_drake.robot.reach import arm_reach, shoulder
from remosplat_drake.robot.robot_model import load_robot
from remosplat_drake.scene.primitive_scene import Box, PrimitiveScene
from remosplat_drake.task import hand_places
from remosplat_drake.task.suggestion import suggest_task

LOWER, UPPER = np.array([0.5, -0.5, 0.0]), np.array([1.5, 0.5, 1.2])
BOARD = Box(RigidTransform([1, 0, 0.5]), np.array([0.3, 0.4, 0.03]))


def everywhere(points):
    return np.ones(len(points), bool)


@pytest.fixture
def field():
    return SignedDistanceField(PrimitiveScene(boxes=(BOARD,)).with_floor())


def test_the_robot_stands_free_and_faces_a_target_over_the_board(
    frankie, field
):
    task = suggest_task(frankie, field, LOWER, UPPER, everywhere)
    q = np.concatenate([task.base_pose, frankie.home])
    assert field.clearances(frankie.spheres_at(q)).minimum() > 0.14
    p_WT = task.X_WT.translation()
    ahead = p_WT[:2] - task.base_pose[:2]
    bearing = np.arctan2(ahead[1], ahead[0])
    assert np.cos(bearing - task.base_pose[2]) > 0.999
    np.testing.assert_allclose(
        task.X_WT.rotation().matrix(), np.diag([1, -1, -1]), atol=1e-12
    )
    # The gripper's tip is some centimetres over the board.
    assert 0.55 < p_WT[2] < 0.8


def test_only_what_is_known_to_be_free_is_suggested(frankie, field):
    task = suggest_task(
        frankie, field, LOWER, UPPER, lambda points: points[:, 1] > 0.15
    )
    assert task.X_WT.translation()[1] > 0.15


def test_a_wall_does_not_stand_between_the_robot_and_its_target(frankie):
    # Behind the wall there is room nearer to the board than before it.
    wall = Box(RigidTransform([1.45, 0, 1]), np.array([0.05, 5, 1]))
    scene = PrimitiveScene(boxes=(BOARD, wall)).with_floor()
    task = suggest_task(
        frankie,
        SignedDistanceField(scene),
        LOWER,
        UPPER,
        everywhere,
    )
    assert task.base_pose[0] < 1.4
    assert task.X_WT.translation()[0] < 1.4


def test_it_says_what_is_missing(frankie, field):
    far = UPPER + 10
    with pytest.raises(RemoSplatError, match="no place for the hand"):
        suggest_task(frankie, field, far, far + 1, everywhere)
    # A ceiling that leaves room for a hand but not for a robot.
    ceiling = Box(RigidTransform([1, 0, 1.06]), np.array([5, 5, 0.02]))
    low = SignedDistanceField(PrimitiveScene((BOARD, ceiling)).with_floor())
    lower, upper = np.array([[0.9, -0.1, 0.0], [1.1, 0.1, 1.2]])
    with pytest.raises(RemoSplatError, match="no free place for the robot"):
        suggest_task(frankie, low, lower, upper, everywhere)


def test_an_arm_on_a_fixed_base_reaches_from_where_it_stands(three_link):
    p_WA, reach = shoulder(three_link, three_link.home), arm_reach(three_link)
    board = Box(
        RigidTransform([0.3 * reach, 0, p_WA[2] - 0.5 * reach]),
        np.array([2 * reach, 2 * reach, 0.01]),
    )
    field = SignedDistanceField(PrimitiveScene(boxes=(board,)))
    lower, upper = np.array([[-2.0, -2, 0], [2, 2, 2]])
    task = suggest_task(three_link, field, lower, upper, everywhere)
    assert task.base_pose is None
    p_WT = task.X_WT.translation()
    assert np.linalg.norm(p_WT - p_WA) < 0.7 * reach


def test_the_map_is_moved_where_an_arm_reaches_nothing_from_the_origin():
    ur5e, board = (
        load_robot("ur5e"),
        Box(RigidTransform([4, 2, 0.2]), np.array([0.3, 0.3, 0.02])),
    )
    scene = PrimitiveScene(boxes=(board,)).with_floor()
    lower, upper = np.array([[3.5, 1.5, 0], [4.5, 2.5, 1]])
    asked = ur5e, SignedDistanceField(scene), lower, upper, everywhere
    with pytest.raises(RemoSplatError, match="to move the map"):
        suggest_task(*asked)
    task = suggest_task(*asked, may_move_map=True)
    assert task.base_pose is None
    # In the moved map the arm has room, and the target is over the board.
    moved = task.X_WG.inverse().GetAsMatrix4()
    spheres = ur5e.spheres_at(ur5e.q_home)
    p_GS = spheres.p_WS @ moved[:3, :3].T + moved[:3, 3]
    there = dc.replace(spheres, p_WS=p_GS, R_WL=moved[:3, :3] @ spheres.R_WL)
    assert SignedDistanceField(scene).clearances(there).minimum() > 0.14
    p_WT = task.X_WT.translation()
    assert np.linalg.norm(p_WT - shoulder(ur5e, ur5e.home)) < arm_reach(ur5e)
    p_GT = task.X_WG.inverse() @ p_WT
    assert np.abs(p_GT[:2] - [4, 2]).max() < 0.5
    assert 0.22 < p_GT[2] < 0.6


def furnished(side: float) -> SignedDistanceField:
    """A square floor with a table on each nine square metres of it."""
    centers = np.arange(1.5 - 0.5 * side, 0.5 * side, 3.0)
    boxes = [
        dc.replace(BOARD, X_WP=RigidTransform([x, y, 0.5]))
        for x, y in itertools.product(centers, repeat=2)
    ]
    return SignedDistanceField(PrimitiveScene(boxes=tuple(boxes)).with_floor())


@pytest.mark.parametrize("robot", ["frankie", "ur5e"])
@pytest.mark.parametrize(
    "extent", [pytest.param(12.0, marks=pytest.mark.slow), 1e7]
)
def test_a_large_floor_takes_no_more_memory(robot, extent):
    """Tables stand on twelve metres of it; one thing may be far away."""
    field, robot = furnished(12.0), load_robot(robot)
    lower, upper = np.array([-6.0, -6, 0]), np.array([extent - 6, 6, 1.2])
    tracemalloc.start()
    try:
        task = suggest_task(
            robot, field, lower, upper, everywhere, may_move_map=True
        )
        _, peak = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert np.abs((task.X_WG.inverse() @ task.X_WT.translation())[:2]).max() < 6
    assert peak < 150e6


@pytest.mark.parametrize("robot", ["frankie", "ur5e"])
def test_how_much_is_asked_at_once_changes_nothing(robot, monkeypatch):
    robot, field = load_robot(robot), furnished(6.0)
    lower, upper = np.array([[-2.7, -2.9, 0], [2.8, 2.4, 1.2]])
    tasks = []
    for at_once in (1, 1000, 10**9):
        monkeypatch.setattr(hand_places, "_AT_ONCE", at_once)
        tasks.append(
            suggest_task(
                *(robot, field, lower, upper),
                # At least in the corner that is farthest from the middle.
                lambda p_W: p_W[:, 0] + p_W[:, 1] > 2.0,
                may_move_map=True,
            )
        )
    for task in tasks:
        for a, b in ((task.X_WT, tasks[0].X_WT), (task.X_WG, tasks[0].X_WG)):
            np.testing.assert_array_equal(a.GetAsMatrix4(), b.GetAsMatrix4())
