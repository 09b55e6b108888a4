"""Pieces hold every triangle, stand out by little, and are few."""

import numpy as np
import pytest
from scipy.spatial import ConvexHull

from remosplat_drake.robot.fitting.convex_pieces import (
    convex_piece,
)
from remosplat_drake.robot.fitting.enclosing_piece import (
    SLACK,
    Pieces,
    enclosing_piece,
)
from remosplat_drake.robot.fitting.enclosure import standing_out


def bracket() -> np.ndarray:
    """The triangles of an L of two bars, 0.3 m long, 0.1 m wide and high."""
    corners = np.array(
        [[0, 0], [0.3, 0], [0.3, 0.1], [0.1, 0.1], [0.1, 0.3], [0, 0.3]]
    )
    lower = np.column_stack([corners, np.zeros(6)])
    upper = lower + np.array([0, 0, 0.1])
    # Every corner of an L is seen from the one outside its bend.
    floor = [lower[[0, i + 1, i]] for i in range(1, 5)]
    roof = [upper[[0, i, i + 1]] for i in range(1, 5)]
    sides = []
    for i in range(6):
        j = (i + 1) % 6
        sides.append([lower[i], lower[j], upper[j]])
        sides.append([lower[i], upper[j], upper[i]])
    return np.array([*floor, *roof, *sides])


def test_a_mesh_in_one_piece_is_its_hull():
    piece = enclosing_piece(bracket())
    assert piece.volume == pytest.approx(7e-3, rel=2e-2)
    assert standing_out(bracket(), Pieces([piece])) <= 0.0


def test_a_mesh_that_is_no_solid_is_enclosed_all_the_same():
    """Without one side, another twice, and with a sheet that stands alone."""
    sheet = np.array([[[0.4, 0, 0], [0.4, 0.1, 0], [0.4, 0, 0.1]]])
    broken = np.concatenate([bracket()[1:], bracket()[:4], sheet])
    assert standing_out(broken, Pieces([enclosing_piece(broken)])) <= 0.0


def test_a_flat_mesh_gets_a_thickness():
    sheet = bracket()[:1]
    piece = enclosing_piece(sheet)
    assert standing_out(sheet, Pieces([piece])) <= 0.0
    assert 2 * SLACK <= np.ptp(piece.vertices[:, 2]) <= 4 * SLACK


@pytest.mark.parametrize("height", [1e-4, 2e-3, 5e-3, 0.02])
def test_a_wedge_stands_out_no_farther_than_a_box(height):
    """A tenth of a metre long, as thin as a sheet at one end."""
    rng = np.random.default_rng(3)
    x, y, z = rng.uniform(0, 1, (3, 600))
    p = np.column_stack([0.1 * x, 0.03 * y, height * x * z])
    surface = p[ConvexHull(p).simplices]
    piece = enclosing_piece(surface)
    assert standing_out(surface, Pieces([piece])) <= 0.0
    hull = Pieces([convex_piece(p, 0.0)])
    assert hull.outside_each(piece.vertices).max() < 4 * SLACK


def test_corners_are_added_until_there_are_enough():
    p = np.random.default_rng(8).standard_normal((2000, 3))
    p /= np.linalg.norm(p, axis=1, keepdims=True)
    whole = convex_piece(p, 1e-3)
    assert len(whole.vertices) > 200
    assert 50 < len(convex_piece(p, 1e-3, 50).vertices) < 200
    enough = convex_piece(p, 1e-3, len(whole.vertices))
    np.testing.assert_array_equal(enough.vertices, whole.vertices)
