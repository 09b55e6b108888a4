"""Grasps of the Panda's hand, whose pieces overlap nothing."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pydrake.math import RigidTransform

from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.grasping.grasps import (
    ENOUGH,
    Grasp,
    bearing,
    grasp_poses,
    plan_grasps,
    reachable,
)
from remosplat_drake.grasping.gripper import ParallelGripper
from remosplat_drake.grasping.kernels.hand_clearance import hand_clearances
from remosplat_drake.grasping.surface import surface_of_solid
from remosplat_drake.robot.robot_model import load_robot
from remosplat_drake.scene.primitive_scene import Box, Cylinder

DOWN = np.array([0.0, 0.0, -1.0])


@pytest.fixture(scope="module")
def gripper() -> ParallelGripper:
    return ParallelGripper.of(load_robot("panda"))


def plan(solid, gripper, **kwargs):
    rng = np.random.default_rng(0)
    return plan_grasps(surface_of_solid(solid), gripper, rng=rng, **kwargs)


def test_the_pandas_hand_closes_along_y_and_looks_along_z(gripper):
    np.testing.assert_allclose(np.abs(gripper.close_E), [0, 1, 0], atol=1e-9)
    np.testing.assert_allclose(gripper.approach_E, [0, 0, 1], atol=1e-9)
    assert (gripper.max_width, gripper.max_force) == (0.08, 70.0)


def test_pieces_follow_the_fingers(gripper):
    """Between open fingers is room of their width, and nothing beside it."""
    for width in (0.08, 0.03):
        pieces = gripper.pieces(width)
        for y, free in (
            (0.5 * width - 2e-3, True),
            (0.5 * width + 4e-3, False),
            (0.5 * width + 30e-3, True),
        ):
            point = np.array([[0, y, 0]])
            clearance = hand_clearances(*pieces, np.eye(4)[None], point, ENOUGH)
            assert (clearance[0] > 0) == free, (width, y)


def clearance_reference(pieces, X_OE, points, enough):
    """By half spaces, piece by piece, or by the box around all of them."""
    p_E = (points - X_OE[:3, 3]) @ X_OE[:3, :3]
    least = enough
    beside = np.maximum(pieces.box[0] - p_E, p_E - pieces.box[1]).max(axis=1)
    for i, j in zip(pieces.first, pieces.first[1:], strict=False):
        planes = pieces.planes[i:j]
        away = (p_E @ planes[:, :3].T + planes[:, 3]).max(axis=1)
        away = np.maximum(away, beside)
        least = min(least, away.min())
    return least


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 2**32 - 1))
def test_clearance_is_that_of_the_reference(gripper, seed):
    rng = np.random.default_rng(seed)
    pieces = gripper.pieces(0.05)
    points = rng.uniform(-0.15, 0.15, (20, 3))
    poses = grasp_poses(
        rng.uniform(-0.1, 0.1, 3), np.array([0, 1.0, 0]), gripper
    )
    fast = hand_clearances(*pieces, poses, points, ENOUGH)
    for X_OE, clearance in zip(poses, fast, strict=True):
        slow = clearance_reference(pieces, X_OE, points, ENOUGH)
        assert (clearance > 0) == (slow > 0)
        if slow > 0:
            np.testing.assert_allclose(clearance, slow, atol=1e-12)


def test_a_can_is_taken_from_above_at_its_middle(gripper):
    """A can of 66 mm on a table: its table is below, not in the hand."""
    can = Cylinder(RigidTransform(), 0.033, 0.05)
    table = surface_of_solid(
        Box(RigidTransform(), np.array([0.3, 0.3, 0.01])), 0.01
    )
    around = table.points - [0, 0, 0.06]
    grasps = plan(can, gripper, approach_O=DOWN, around=around)
    best = grasps[0]
    np.testing.assert_allclose(best.width, 0.066, rtol=1e-2)
    assert best.opening == gripper.max_width
    approach = best.X_OE[:3, :3] @ gripper.approach_E
    np.testing.assert_allclose(approach, DOWN, atol=1e-6)
    axis = best.X_OE[:3, :3] @ gripper.close_E
    np.testing.assert_allclose(axis[2], 0, atol=1e-6)
    assert [g.score for g in grasps] == sorted(
        (g.score for g in grasps), reverse=True
    )
    pieces = gripper.pieces(best.opening)
    for grasp in grasps[::10]:
        assert clearance_reference(pieces, grasp.X_OE, around, ENOUGH) > 0


def test_the_pads_of_a_panda_are_18_mm_squares_at_its_fingertips(gripper):
    lower, upper = gripper.pad
    np.testing.assert_allclose(upper - lower, 0.0176, atol=5e-4)
    np.testing.assert_allclose(0.5 * (lower + upper), 0.0, atol=1e-3)


@pytest.mark.parametrize(("shift", "share"), [(0.0, 1.0), (0.0088, 0.5)])
def test_half_a_pad_beside_the_object_bears_half(gripper, shift, share):
    """A hand from above: its pads overlap a box of 40 mm, or half of them."""
    surface = surface_of_solid(Box(RigidTransform(), np.full(3, 0.02)), 5e-4)
    X_OE = np.diag([1.0, -1.0, -1.0, 1.0])
    X_OE[0, 3] = 0.02 - 0.0088 + shift
    found = bearing(surface, gripper, X_OE, 0.04)
    np.testing.assert_allclose(found, share, atol=0.06)


def test_a_box_on_a_table_is_not_taken_from_below(gripper):
    box = Box(RigidTransform(), np.array([0.02, 0.06, 0.03]))
    table = surface_of_solid(
        Box(RigidTransform(), np.array([0.3, 0.3, 0.01])), 0.01
    )
    grasps = plan(box, gripper, around=table.points - [0, 0, 0.04])
    assert grasps
    for grasp in grasps:
        assert (grasp.X_OE[:3, :3] @ gripper.approach_E)[2] < 0.5
        np.testing.assert_allclose(grasp.width, 0.04)


def test_what_is_wider_than_the_hand_has_none(gripper):
    assert plan(Box(RigidTransform(), np.full(3, 0.05)), gripper) == []


def test_the_whole_robot_decides(gripper):
    """Inverse kinematics that reach with one sense of the fingers alone."""
    grasps = plan(Cylinder(RigidTransform(), 0.03, 0.05), gripper)[:5]
    asked = []

    def reach(X_WE: np.ndarray, grasp: Grasp) -> np.ndarray | None:
        asked.append(grasp)
        return X_WE[:3, 3] if len(asked) == 4 else None

    X_WO = RigidTransform([1, 2, 3]).GetAsMatrix4()
    found = list(reachable(grasps, gripper, X_WO, reach))
    assert len(found) == 1
    grasp, q = found[0]
    np.testing.assert_allclose(q, grasp.X_OE[:3, 3] + [1, 2, 3])
    np.testing.assert_allclose(
        grasp.flipped(gripper).X_OE, grasps[1].X_OE, atol=1e-12
    )
    assert len(asked) == 10


def test_the_force_carries_the_weight_and_more(gripper):
    """1 kg at mu = 0.5: 9.81 N of each finger, times 2.5."""
    np.testing.assert_allclose(gripper.force(1.0, 0.5), 24.525)
    # 10 mm beside the axis, three times the arm at which a patch of 5 mm turns.
    lever = gripper.force(0.2, 0.5, lever=0.01)
    np.testing.assert_allclose(lever, 4.905 * 10**0.5)
    with pytest.raises(RemoSplatError, match="the hand has at most 70 N"):
        gripper.force(4.0, 0.5)


def test_a_robot_without_a_hand_grips_nothing():
    with pytest.raises(RemoSplatError, match="two fingers"):
        ParallelGripper.of(load_robot("ur5e"))
