"""A plane cuts a part where its hull spans air, and nothing is lost."""

import numpy as np
import pytest

from remosplat_drake.robot.fitting.convex_pieces import (
    below,
    convex_piece,
    hull_volume,
)
from remosplat_drake.robot.fitting.plane_cuts import cut_in_two


def box(lower: tuple, upper: tuple) -> np.ndarray:
    x, y, z = zip(lower, upper, strict=True)
    grid = np.stack(np.meshgrid(x, y, z), axis=-1)
    return convex_piece(grid.reshape(-1, 3), 0.0).surface


def area(triangles: np.ndarray) -> float:
    a, b, c = triangles.transpose(1, 0, 2)
    return 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1).sum()


@pytest.fixture
def corner() -> np.ndarray:
    """Two bars of 0.3 x 0.1 x 0.1 m that meet at the origin."""
    along_x = box((0, 0, 0), (0.3, 0.1, 0.1))
    return np.concatenate([along_x, box((0, 0, 0), (0.1, 0.3, 0.1))])


def test_a_corner_is_cut_beside_one_of_its_bars(corner):
    p, off = np.array([[0.2, 0.2, 0.05]]), np.array([0.1])
    halves = cut_in_two(corner, p, off)
    assert halves is not None
    # The point is free: 5 litres are left of the hull's 7, and little more.
    volume = sum(hull_volume(half.reshape(-1, 3)) for half in halves)
    assert volume == pytest.approx(5e-3, rel=0.1)
    assert sum(map(area, halves)) == pytest.approx(area(corner))


def test_what_stands_out_of_nothing_is_not_cut():
    bar = box((0, 0, 0), (0.3, 0.1, 0.1))
    at_a_corner = np.array([[0.3, 0.1, 0.1]])
    assert cut_in_two(bar, at_a_corner, np.array([0.01])) is None


@pytest.mark.parametrize("seed", range(5))
def test_both_sides_of_a_plane_are_the_whole_surface(seed):
    rng = np.random.default_rng(seed)
    triangles = rng.uniform(-1, 1, (50, 3, 3))
    # Some corners lie on the plane.
    triangles[:20, 0, 2] = 0.0
    triangles[:10, 1, 2] = 0.0
    normal = np.array([0.0, 0.0, 2.0])
    sides = below(triangles, normal, 0.0), below(triangles, -normal, 0.0)
    assert sides[0][..., 2].max() <= 1e-15
    assert sides[1][..., 2].min() >= -1e-15
    assert sum(map(area, sides)) == pytest.approx(area(triangles))
