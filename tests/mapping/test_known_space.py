"""What was seen, worked by hand in a box of few voxels."""

import numpy as np
import pytest
from laden_table import joined

from remosplat_drake.capture.capture import Capture
from remosplat_drake.mapping.changes import find_changes, without
from remosplat_drake.mapping.known_space import in_box, known_space
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

NOTHING = np.zeros((1, 80, 80), bool)
"""That has come."""


@pytest.fixture
def wall() -> Capture:
    """A camera at the origin that looks along z at a wall at z = 2."""
    size = 80
    K = np.array([[size, 0, size / 2], [0, size, size / 2], [0, 0, 1.0]])
    return Capture(
        K=K[None],
        X_WC=np.eye(4)[None],
        rgb=np.zeros((1, size, size, 3), np.uint8),
        depth=np.full((1, size, size), 2, np.float32),
    )


def test_behind_a_wall_nothing_is_known(wall):
    config = MappingConfig(
        volume_lower=[-0.3, -0.3, 1.0],
        volume_upper=[0.3, 0.3, 3.0],
        voxel=0.2,
    )
    splat = splat_of_surfels(surfels_from_capture(wall, 2000))
    coverage = known_space(wall, NOTHING, splat, None, config)
    assert coverage.state.shape == (3, 3, 10)
    # The wall at z = 2 is the border of the fifth and the sixth layer.
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


def test_where_the_robot_stood_is_free(wall):
    config = MappingConfig(
        volume_lower=[-0.3, -0.3, 1.0],
        volume_upper=[0.3, 0.3, 3.0],
        voxel=0.2,
        robot_margin=0.05,
    )
    splat = splat_of_surfels(surfels_from_capture(wall, 2000))
    robot = Spheres.at([[0, 0, 2.5], [9, 9, 9]], 0.1)
    coverage = known_space(wall, NOTHING, splat, robot, config)
    # The ball of 0.15 m reaches 0.05 m into the voxels around its own.
    assert coverage.state[1, 1, 7] == FREE
    assert coverage.state[1, 0, 7] == coverage.state[1, 1, 8] == FREE
    assert coverage.state[0, 0, 7] == FREE
    assert coverage.state[0, 0, 8] == coverage.state[1, 1, 9] == UNSEEN
    clearance = unknown_space_field(coverage).clearances(robot).distance[0]
    # To the corners of those that it does not reach.
    assert clearance == pytest.approx(np.sqrt(3) * 0.1 - 0.1)


@pytest.mark.parametrize("stood", [False, True])
def test_what_was_seen_before_stays_known_but_behind_what_has_come(wall, stood):
    config = MappingConfig(
        volume_lower=[-0.3, -0.3, 1.0],
        volume_upper=[0.3, 0.3, 3.0],
        voxel=0.1,
    )
    state = np.full((6, 6, 20), FREE, np.uint8)
    state[..., 18:] = UNSEEN
    if stood:
        state[..., 9:11] = SURFACE
    before = Coverage(np.array(config.volume_lower), 0.1, state)
    splat = splat_of_surfels(surfels_from_capture(wall, 2000))
    coverage = known_space(wall, NOTHING, splat, None, config, before)
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
    moved[0, 3] = 0.1  # Nobody has looked at the first 0.1 m.
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
    lit = known_space(present, changes.come & False, splat, None, config)
    dut = known_space(present, changes.come, splat, None, config)
    # The thing is 0.2 m wide, which is the fourth to the seventh voxel.
    assert (lit.state[3:7, 3:7] == FREE).sum() > 10
    assert (dut.state[3:7, 3:7] != FREE).all()
    # Before its face and beside it nothing has been forgotten.
    assert (dut.state[9, 7:] == FREE).all()
    # Whoever looks at it from all sides knows.
    all_sides = joined(bare, laden)
    changes = find_changes(all_sides)
    present = without(all_sides, changes.outdated)
    known = known_space(present, changes.come, splat, None, config)
    assert known.fraction(FREE) > dut.fraction(FREE)
