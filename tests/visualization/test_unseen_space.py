"""Tests of the boundary of what no camera has seen."""

import numpy as np

from remosplat_drake.signals.coverage import FREE, SURFACE, UNSEEN, Coverage
from remosplat_drake.visualization.unseen_space import (
    frontier_mesh,
    merged,
    smoothed,
)


def quads_of(state: np.ndarray, voxel: float = 1.0) -> np.ndarray:
    """Pairs (centre, unit normal) of all quads, shape (n, 2, 3)."""
    coverage = Coverage(np.zeros(3), voxel, state)
    found = [np.zeros((0, 2, 3))]
    for layer in range(state.shape[2]):
        vertices, faces = frontier_mesh(coverage, layer)
        a, b, c = (vertices[faces[:, k]] for k in range(3))
        normals = np.cross(b - a, c - a)
        np.testing.assert_array_equal(normals[::2], normals[1::2])
        np.testing.assert_allclose(
            np.linalg.norm(normals, axis=1), voxel**2, rtol=1e-12
        )
        centers = vertices.reshape(-1, 4, 3).mean(axis=1)
        found.append(np.stack([centers, normals[::2] / voxel**2], axis=1))
    return np.concatenate(found)


def test_a_free_voxel_has_walls_that_look_inwards():
    state = np.full((3, 3, 3), UNSEEN, np.uint8)
    state[1, 1, 1] = FREE
    quads = quads_of(state)
    assert len(quads) == 6
    np.testing.assert_allclose(quads[:, 0] + 0.5 * quads[:, 1], 1.5)


def test_the_grid_ends_in_walls_but_not_in_a_floor():
    quads = quads_of(np.full((1, 1, 1), FREE, np.uint8))
    assert len(quads) == 5
    assert [0.5, 0.5, 0.0] not in quads[:, 0].tolist()


def test_surfaces_are_no_frontier():
    state = np.array([FREE, SURFACE, UNSEEN], np.uint8).reshape(3, 1, 1)
    assert 1.0 not in quads_of(state)[:, 0, 0]
    assert not len(quads_of(np.full((2, 2, 2), UNSEEN, np.uint8)))


def test_every_wall_parts_free_from_unseen():
    """Against a count of all pairs of neighbours of a random grid."""
    rng = np.random.default_rng(2)
    state = rng.integers(0, 3, (4, 5, 6)).astype(np.uint8)
    padded = np.full((6, 7, 8), UNSEEN, np.uint8)
    padded[:, :, 0] = SURFACE
    padded[1:-1, 1:-1, 1:-1] = state
    expected = 0
    for axis in range(3):
        a, b = (
            np.moveaxis(padded, axis, 0)[:-1],
            np.moveaxis(padded, axis, 0)[1:],
        )
        expected += ((a == FREE) & (b == UNSEEN)).sum()
        expected += ((a == UNSEEN) & (b == FREE)).sum()
    quads = quads_of(state, voxel=0.5)
    assert len(quads) == expected
    for center, normal in quads:
        for side, wanted in ((0.25, FREE), (-0.25, UNSEEN)):
            cell = np.floor((center + side * normal) / 0.5).astype(int) + 1
            assert padded[tuple(cell)] == wanted


def frontier_of(state: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Vertices of a frontier of voxels of 0.1 m, as they are and smoothed."""
    coverage = Coverage(np.array([1.0, 2.0, 0.0]), 0.1, state)
    before, after = [], []
    for layer in range(state.shape[2]):
        vertices, _ = frontier_mesh(coverage, layer)
        if len(vertices):
            before.append(vertices)
            after.append(smoothed(vertices, coverage, layer))
    return np.concatenate(before), np.concatenate(after)


def test_a_level_frontier_stays_where_it_is():
    state = np.full((8, 8, 8), UNSEEN, np.uint8)
    state[:, :, :4] = FREE
    before, after = frontier_of(state)
    middle = (np.abs(before[:, :2] - [1.4, 2.4]) < 0.25).all(axis=1)
    assert middle.any()
    np.testing.assert_allclose(after[middle], before[middle], atol=1e-12)


def test_steps_around_a_ball_become_rounder():
    center, radius = np.full(3, 10.0), 8.0
    voxels = np.indices((20, 20, 20)).reshape(3, -1).T + 0.5
    free = np.linalg.norm(voxels - center, axis=1) < radius
    state = np.where(free, FREE, UNSEEN).astype(np.uint8).reshape(20, 20, 20)
    p_W = [1.0, 2.0, 0.0] + 0.1 * center
    before, after = (
        np.linalg.norm(vertices - p_W, axis=1)
        for vertices in frontier_of(state)
    )
    assert after.std() < before.std() / 3
    assert abs(after - 0.1 * radius).max() < 0.05


def test_layers_stay_joined():
    state = np.random.default_rng(3).integers(0, 3, (6, 5, 4)).astype(np.uint8)
    before, after = frontier_of(state)
    corners, same = np.unique(before.round(6), axis=0, return_inverse=True)
    moved = np.zeros_like(corners)
    moved[same.ravel()] = after
    np.testing.assert_array_equal(moved[same.ravel()], after)
    assert np.abs(after - before).max() <= 0.1 + 1e-12


def test_corners_at_the_same_place_are_one():
    """Two squares with an edge in common: six corners are left of eight."""
    square = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], float)
    beside = square + np.array([1, 0, 0])
    vertices = np.concatenate([square, beside]) - [0.3, 2, 0]
    faces = np.array([[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]])
    fewer, joined = merged(vertices, faces)
    assert len(fewer) == 6
    np.testing.assert_allclose(fewer[joined], vertices[faces], atol=2**-13)
