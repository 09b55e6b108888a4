"""Level surfaces in points of a map, in worlds worked by hand."""

import numpy as np
import pytest

from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.scene.objects.level_surface import (
    THICKNESS,
    find_level_surface,
)

UP = np.array([0.0, 0.0, 1.0])


def plate(x, y, z=0.5, noise=0.001, step=0.008):
    """Points of a level plate, as noisy as those of a map."""
    rng = np.random.default_rng(4)
    grid = np.meshgrid(np.arange(*x, step), np.arange(*y, step))
    xy = np.stack([axis.ravel() for axis in grid], axis=1)
    heights = z + noise * rng.standard_normal(len(xy))
    return np.column_stack([xy, heights])


def find(points, near, reach=0.3, normals=None):
    if normals is None:
        normals = np.tile(UP, (len(points), 1))
    return find_level_surface(points, normals, np.array(near), reach, "top")


def test_a_plate_becomes_a_box_below_its_top():
    box = find(plate((0.0, 0.4), (-0.1, 0.1)), (0.15, 0.0, 0.51))
    half, p_W = box.half_extents, box.X_WP.translation()
    assert p_W[2] + half[2] == pytest.approx(0.5, abs=0.001)
    assert half[2] == THICKNESS / 2
    # It is within the plate, and lacks at most two cells of it.
    assert 0.36 <= 2 * half[0] <= 0.4 and 0.16 <= 2 * half[1] <= 0.2
    assert abs(p_W[0] - 0.2) < 0.021 and abs(p_W[1]) < 0.021
    assert box.name == "top"


def test_it_goes_no_farther_than_it_may():
    box = find(plate((0.0, 2.0), (-1.0, 1.0)), (1.0, 0.0, 0.5), reach=0.1)
    assert (2 * box.half_extents[:2] <= 0.2 + 1e-9).all()
    assert (2 * box.half_extents[:2] > 0.15).all()


def test_it_ends_at_what_stands_on_the_plate():
    table = plate((0.0, 0.5), (-0.25, 0.25))
    under = np.linalg.norm(table[:, :2] - [0.15, 0.0], axis=1) < 0.05
    pot = plate((0.1, 0.2), (-0.05, 0.05), z=0.58)
    points = np.concatenate([table[~under], pot])
    box = find(points, (0.35, 0.0, 0.5))
    left = box.X_WP.translation()[0] - box.half_extents[0]
    assert 0.19 < left < 0.23
    assert 2 * box.half_extents[1] > 0.4


def test_points_of_a_wall_beside_it_do_not_count():
    table = plate((0.0, 0.4), (-0.1, 0.1))
    wall = plate((0.4, 0.6), (-0.1, 0.1))[:, [1, 2, 0]] * [0, 0, 1]
    wall += np.column_stack(
        [
            np.full(len(wall), 0.16),
            np.linspace(-0.1, 0.1, len(wall)),
            0 * wall[:, 0],
        ]
    )
    points = np.concatenate([table, wall])
    normals = np.tile(UP, (len(points), 1))
    normals[len(table) :] = [1.0, 0.0, 0.0]
    box = find(points, (0.1, 0.0, 0.5), normals=normals)
    assert box.X_WP.translation()[2] + THICKNESS / 2 == pytest.approx(
        0.5, abs=0.001
    )


def test_what_is_no_level_surface_is_refused():
    ramp = plate((0.0, 0.4), (-0.1, 0.1))
    ramp[:, 2] += np.tan(np.radians(12.0)) * ramp[:, 0]
    slope = np.tile(
        [-np.sin(np.radians(12)), 0, np.cos(np.radians(12))], (len(ramp), 1)
    )
    with pytest.raises(RemoSplatError, match="tilted by 12 deg"):
        find(ramp, (0.2, 0.0, 0.54), normals=slope)
    with pytest.raises(RemoSplatError, match="no surface within"):
        find(ramp, (5.0, 0.0, 0.5))
    with pytest.raises(RemoSplatError, match="too small: "):
        find(plate((0.0, 0.4), (-0.02, 0.02)), (0.2, 0.0, 0.5))
    with pytest.raises(RemoSplatError, match="too little of a surface"):
        find(np.array([[0.0, 0.0, 0.5]]), (0.0, 0.0, 0.5))
