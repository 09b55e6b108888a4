"""Seen space, judged by the truth that the views were rendered of."""

import numpy as np
import pytest
from pydrake.math import RigidTransform

from remosplat_drake.capture.capture import Capture
from remosplat_drake.capture.rendering.camera_poses import look_at
from remosplat_drake.capture.rendering.synthetic import render_capture
from remosplat_drake.oracle.signed_distance import SignedDistanceField
from remosplat_drake.reconstruction.seen_space import (
    find_seen_space,
    seen_box,
)
from remosplat_drake.reconstruction.surfels.point_cloud import (
    InitialisationConfig,
    initialise,
)
from remosplat_drake.reconstruction.surfels.surfels import splat_of_surfels
from remosplat_drake.reconstruction.whole_looks import count_whole_looks
from remosplat_drake.reconstruction.workspace import Workspace
from remosplat_drake.robot.sphere_model import Spheres
from remosplat_drake.scene.primitive_scene import Box, PrimitiveScene
from remosplat_drake.signals.coverage import FREE, SURFACE, UNSEEN, Coverage

BLOCK = Box(RigidTransform([0.0, 0.0, 0.2]), np.array([0.15, 0.25, 0.2]))
SCENE = PrimitiveScene(boxes=(BLOCK,)).with_floor()
LOWER, UPPER = np.array([-0.6, -0.6, -0.05]), np.array([0.6, 0.6, 0.7])


def from_the_front(views: int) -> Capture:
    """Views of a block on a floor; none sees its back at x < 0."""
    sides = np.linspace(-0.5, 0.5, views)
    eyes = [np.array([1.4, y, 0.7 + 0.2 * abs(y)]) for y in sides]
    poses = [look_at(eye, np.array([0.0, 0.0, 0.15])) for eye in eyes]
    return render_capture(SCENE, poses, 240, 180)


def seen_by(capture: Capture) -> Coverage:
    surfels = initialise(capture, InitialisationConfig(count=6000))
    return find_seen_space(capture, splat_of_surfels(surfels), LOWER, UPPER)


@pytest.fixture(scope="module")
def front() -> Coverage:
    return seen_by(from_the_front(5))


def state_at(coverage: Coverage, *p_W: float) -> int:
    cell = np.floor((np.array(p_W) - coverage.lower) / coverage.voxel)
    return int(coverage.state[tuple(cell.astype(int))])


def test_no_free_voxel_holds_any_of_the_truth(front):
    voxels = np.argwhere(front.state == FREE)
    assert len(voxels) > 3000
    inner = np.stack(np.meshgrid(*[np.linspace(0.01, 0.99, 5)] * 3), -1)
    p_W = voxels[:, None] + inner.reshape(-1, 3)
    p_W = front.lower + front.voxel * p_W.reshape(-1, 3)
    depth = SignedDistanceField(SCENE).clearances(Spheres.at(p_W), 0.0)
    assert not len(depth)


def test_before_the_block_is_free_and_behind_it_unseen(front):
    assert state_at(front, 0.4, 0.0, 0.3) == FREE
    assert state_at(front, -0.3, 0.0, 0.1) == UNSEEN
    # Its inside, and under the floor.
    assert state_at(front, 0.0, 0.0, 0.2) == UNSEEN
    assert state_at(front, 0.4, 0.0, -0.03) != FREE


def test_a_surface_with_discs_may_be_approached(front):
    assert state_at(front, 0.15, 0.0, 0.2) == SURFACE
    assert state_at(front, 0.0, 0.0, 0.4) == SURFACE
    assert state_at(front, 0.4, 0.2, 0.0) == SURFACE


def test_a_surface_without_discs_is_unseen():
    capture = from_the_front(5)
    nothing = splat_of_surfels(
        initialise(capture, InitialisationConfig(count=100))
    ).select(np.zeros(0, int))
    coverage = find_seen_space(capture, nothing, LOWER, UPPER)
    assert state_at(coverage, 0.15, 0.0, 0.2) == UNSEEN
    assert not (coverage.state == SURFACE).any()


def test_beside_surfaces_a_single_view_is_not_believed(front):
    single = seen_by(from_the_front(5).select([2]))
    for coverage, beside in ((single, UNSEEN), (front, SURFACE)):
        assert state_at(coverage, 0.4, 0.0, 0.3) == FREE
        assert state_at(coverage, 0.17, 0.0, 0.2) == beside


def test_where_a_single_pixel_has_measured_something_is_not_free():
    """Four other views look through the place, from too far away."""
    capture = from_the_front(5)
    place = capture.points_W(2)[90, 120]
    capture.depth[2, 90, 120] *= 0.75
    floating = capture.points_W(2)[90, 120]
    assert np.linalg.norm(floating - place) > 0.3
    coverage = seen_by(capture)
    assert state_at(coverage, *floating) == UNSEEN
    assert state_at(seen_by(from_the_front(5)), *floating) == FREE


def test_a_pixel_without_depth_says_nothing():
    capture = from_the_front(3)
    capture.depth[:] = 0
    corners = np.array([[0.4, 0.0, 0.3]])
    looks = count_whole_looks(capture, corners, 0.04, margin=0.01, enough=9)
    assert looks == [0]


def test_a_cube_is_looked_through_as_a_whole_or_not():
    """Before a plane z = 2 whose left half is at 1.5."""
    size = 100
    K = np.array([[size, 0, size / 2], [0, size, size / 2], [0, 0, 1.0]])
    depth = np.full((1, size, size), 2, np.float32)
    depth[:, :, : size // 2] = 1.5
    capture = Capture(
        K=K[None],
        X_WC=np.eye(4)[None],
        rgb=np.zeros((1, size, size, 3), np.uint8),
        depth=depth,
    )
    edge = 0.1
    corners = np.array(
        [
            [0.1, 0.0, 1.6],  # Before the far half.
            [0.1, 0.0, 1.895],  # Too near to it.
            [-0.05, 0.0, 1.6],  # Half behind the near half.
            [-0.2, 0.0, 1.3],  # Before the near half.
            [0.75, 0.0, 1.6],  # Partly out of the picture.
            [0.0, 0.0, -1.0],  # Behind the camera.
        ]
    )
    looks = count_whole_looks(capture, corners, edge, margin=0.01, enough=2)
    np.testing.assert_array_equal(looks, [1, 0, 0, 1, 0, 0])
    # At a cube's far side, 1.7 or 1.4 m away, pixels are 17 or 14 mm apart.
    looks = count_whole_looks(
        capture, corners, edge, margin=0.01, enough=2, pitch=0.015
    )
    np.testing.assert_array_equal(looks, [0, 0, 0, 1, 0, 0])


def test_the_box_holds_cameras_and_surfaces():
    capture = from_the_front(3)
    near = Workspace(np.full(3, -0.5), np.full(3, 0.5))
    lower, upper, voxel = seen_box(capture, near)
    assert (capture.X_WC[:, :3, 3] < upper).all()
    assert (lower < [-0.15, -0.25, 0.0]).all()
    assert (lower >= near.lower - 3).all() and (upper <= near.upper + 3).all()
    assert voxel == 0.04
    assert seen_box(capture, near, 0.001)[2] > 0.002
