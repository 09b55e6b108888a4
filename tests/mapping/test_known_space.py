"""Seen space, worked by hand in a box of few voxels."""

import numpy as np
import pytest
from laden_table import joined

from remosplat_drake.capture.capture import Capture
from remosplat_drake.mapping.changes import find_changes, without
from remosplat_drake.mapping.known_space import (
    in_box,
    known_space,
    measured_in_box,
)
from remosplat_drake.mapping.mapping_config import MappingConfig
from remosplat_drake.oracle.unknown_space import unknown_space_field
from remosplat_drake.reconstruction.surfels.surfels import (
    splat_of_surfels,
    surfels_from_capture,
)
from remosplat_drake.robot.sphere_model import Spheres
from remosplat_drake.signals.coverage import (
    FREE,
    SURFACE,
    UNSEEN,
    Coverage,
    with_free,
)
from remosplat_drake.splat.gaussian_splat import GaussianSplat

NOTHING = np.zeros((2, 80, 80), bool)
"""That has come."""

NOWHERE = np.zeros((0, 3), int)
"""Cells in which nothing was measured."""


def wall(depth: float) -> Capture:
    """Two cameras at the origin that look along z at a wall [m]."""
    size = 80
    K = np.array([[size, 0, size / 2], [0, size, size / 2], [0, 0, 1.0]])
    return Capture(
        K=np.tile(K, (2, 1, 1)),
        X_WC=np.tile(np.eye(4), (2, 1, 1)),
        rgb=np.zeros((2, size, size, 3), np.uint8),
        depth=np.full((2, size, size), depth, np.float32),
    )


def box(voxel: float) -> MappingConfig:
    return MappingConfig(
        volume_lower=[-0.3, -0.3, 1.0],
        volume_upper=[0.3, 0.3, 3.0],
        voxel=voxel,
        robot_margin=0.05,
    )


def discs(capture: Capture) -> GaussianSplat:
    return splat_of_surfels(surfels_from_capture(capture, 2000))


def test_behind_a_wall_nothing_is_known():
    capture = wall(2.1)
    coverage = known_space(
        capture, NOTHING, NOWHERE, discs(capture), None, box(0.2)
    )
    assert coverage.state.shape == (3, 3, 10)
    assert (coverage.state[..., :5] == FREE).all()
    assert (coverage.state[..., 5] == SURFACE).all()
    assert (coverage.state[..., 6:] == UNSEEN).all()
    field = unknown_space_field(coverage)
    answer = field.clearances(Spheres.at([0, 0, 1.9], 0.05))
    # To the sides the box ends, and what was seen with it.
    np.testing.assert_allclose(answer.distance, 0.25)
    answer = field.clearances(Spheres.at([0, 0, 2.1]))
    np.testing.assert_allclose(answer.distance, 0.1)
    np.testing.assert_allclose(answer.direction_W, [[0, 0, 1]])


def test_where_the_robot_stood_is_free():
    capture = wall(2.1)
    robot = Spheres.at([[0, 0, 2.5], [9, 9, 9]], 0.1)
    coverage = known_space(
        capture, NOTHING, NOWHERE, discs(capture), robot, box(0.2)
    )
    # The ball of 0.15 m reaches 0.05 m into the voxels around its own.
    assert coverage.state[1, 1, 7] == FREE
    assert coverage.state[1, 0, 7] == coverage.state[1, 1, 8] == FREE
    assert coverage.state[0, 0, 7] == FREE
    assert coverage.state[0, 0, 8] == coverage.state[1, 1, 9] == UNSEEN
    clearance = unknown_space_field(coverage).clearances(robot).distance[0]
    # To the corners of those that it does not reach.
    assert clearance == pytest.approx(np.sqrt(3) * 0.1 - 0.1)


def test_what_a_pixel_has_measured_beside_the_robot_is_not_free():
    """Neither by the margin around it, nor as it was before."""
    capture, config = wall(2.1), box(0.1)
    robot = Spheres.at([0.05, 0.05, 2.55], 0.04)
    before = Coverage(
        np.array(config.volume_lower), 0.1, np.full((6, 6, 20), FREE, np.uint8)
    )
    # In the robot's voxel, in the next one, and far away; three cells each.
    cells = np.array([[10, 10, 46], [13, 10, 46], [4, 4, 55]])
    coverage = known_space(
        capture, NOTHING, cells, discs(capture), robot, config, before
    )
    assert coverage.state[3, 3, 15] == FREE
    assert coverage.state[4, 3, 15] == UNSEEN
    assert coverage.state[1, 1, 18] == UNSEEN


@pytest.mark.parametrize("stood", [False, True])
def test_what_was_seen_before_stays_known_but_behind_what_has_come(stood):
    capture, config = wall(2.05), box(0.1)
    state = np.full((6, 6, 20), FREE, np.uint8)
    state[..., 18:] = UNSEEN
    if stood:
        state[..., 10] = SURFACE
    before = Coverage(np.array(config.volume_lower), 0.1, state)
    coverage = known_space(
        capture, NOTHING, NOWHERE, discs(capture), None, config, before
    )
    assert (coverage.state[..., 10] == SURFACE).all()
    # The next 0.3 m may be the thing's inside.
    behind = FREE if stood else UNSEEN
    assert (coverage.state[..., 11:13] == behind).all()
    assert (coverage.state[..., 13:18] == FREE).all()
    assert (coverage.state[..., 18:] == UNSEEN).all()


def test_a_voxel_of_the_box_is_seen_only_if_all_of_it_is():
    config = MappingConfig(
        volume_lower=[0.0, 0.0, 0.0], volume_upper=[0.4, 0.2, 0.2], voxel=0.2
    )
    # Of the quarter turn's columns along G's y, W's x, three of four are seen.
    state = np.full((2, 4, 2), FREE, np.uint8)
    state[0, 0, 0] = SURFACE
    state[1, 3, 1] = UNSEEN
    X_WG = np.array(
        [[0.0, 1, 0, 0], [-1, 0, 0, 0.2], [0, 0, 1, 0], [0, 0, 0, 1]]
    )
    box = in_box(Coverage(np.zeros(3), 0.1, state), X_WG, config)
    np.testing.assert_array_equal(box.state[:, 0, 0], [SURFACE, UNSEEN])
    moved = X_WG.copy()
    moved[0, 3] = 0.1  # No camera has looked at the first 0.1 m.
    box = in_box(Coverage(np.zeros(3), 0.1, state), moved, config)
    np.testing.assert_array_equal(box.state[:, 0, 0], [UNSEEN, FREE])


def test_a_robot_frees_no_surface():
    state = np.full((3, 3, 3), UNSEEN, np.uint8)
    state[1, 1, 1] = SURFACE
    before = Coverage(np.zeros(3), 1.0, state)
    after = with_free(before, Spheres.at([1.5, 1.5, 1.5], 0.4), 0.2)
    assert after.state[1, 1, 1] == SURFACE
    assert (after.state == FREE).sum() == 6
    assert (before.state == FREE).sum() == 0


@pytest.mark.parametrize("margin", [0.0, 0.03, 0.1])
def test_the_robot_keeps_its_margin_to_the_unknown(margin):
    rng = np.random.default_rng(0)
    robot = Spheres.at(rng.uniform(0.3, 0.7, (20, 3)), rng.uniform(0, 0.1, 20))
    unseen = Coverage(np.zeros(3), 0.04, np.full((25,) * 3, UNSEEN, np.uint8))
    coverage = with_free(unseen, robot, margin)
    answer = unknown_space_field(coverage).clearances(robot)
    assert answer.distance.min() > margin - 1e-9
    assert answer.distance.min() < margin + 0.04 * np.sqrt(3)


def test_how_deep_a_thing_is_that_has_come_is_not_known(bare, laden):
    """Older views looked through where its back is now."""
    both = joined(bare, laden.select(np.array([0])))
    changes = find_changes(both)
    assert changes.come[-1].any() and not changes.come[:-1].any()
    present = without(both, changes.outdated)
    config = MappingConfig(
        volume_lower=[0.8, -0.2, 0.45], volume_upper=[1.2, 0.2, 0.61]
    )
    splat = splat_of_surfels(surfels_from_capture(present, 5000))
    measured = measured_in_box(both, changes, present, config)

    def known(capture: Capture, come: np.ndarray) -> Coverage:
        return known_space(capture, come, measured, splat, None, config)

    lit, dut = (
        known(present, changes.come & False),
        known(present, changes.come),
    )
    # The thing is 0.2 m wide, which is the fourth to the seventh voxel.
    assert (lit.state[3:7, 3:7] == FREE).any()
    assert (dut.state[3:7, 3:7] != FREE).all()
    # Before its face and beside it nothing has been forgotten.
    assert (dut.state[9, 7:] == FREE).all()
    # Views from all sides tell.
    all_sides = joined(bare, laden)
    changes = find_changes(all_sides)
    present = without(all_sides, changes.outdated)
    seen = known(present, changes.come)
    assert seen.fraction(FREE) > dut.fraction(FREE)
