"""Pieces hold every triangle, stand out by little, and are few."""

import numpy as np
import pytest
from scipy.spatial import ConvexHull

from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.robot.fitting.convex_pieces import (
    convex_piece,
    stretched,
)
from remosplat_drake.robot.fitting.decomposition import (
    SLACK,
    Pieces,
    decompose,
)
from remosplat_drake.robot.fitting.enclosure import standing_out
from tests.optional import needs_coacd

pytestmark = needs_coacd


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


def test_a_bracket_becomes_its_two_bars():
    pieces = decompose(bracket(), 0.01)
    assert len(pieces) == 2
    assert standing_out(bracket(), Pieces(pieces)) <= 0.0
    # The bars hold 5 litres; the hull of the bracket holds 7.
    assert sum(piece.volume for piece in pieces) == pytest.approx(5e-3, rel=0.1)
    # Pieces are nowhere in the bend but for what they are stretched by.
    bend = np.array([[0.1, 0.1, 0.05]]) + 8 * SLACK
    assert Pieces(pieces).outside_each(bend).min() > 0.0


def test_a_mesh_in_one_piece_is_its_hull():
    (piece,) = decompose(bracket(), np.inf)
    assert piece.volume == pytest.approx(7e-3, rel=1e-2)
    assert standing_out(bracket(), Pieces([piece])) <= 0.0


def test_a_mesh_that_is_no_solid_is_enclosed_all_the_same():
    """Without one side, another twice, and with a sheet that stands alone."""
    sheet = np.array([[[0.4, 0, 0], [0.4, 0.1, 0], [0.4, 0, 0.1]]])
    broken = np.concatenate([bracket()[1:], bracket()[:4], sheet])
    assert standing_out(broken, Pieces(decompose(broken, 0.01))) <= 0.0


def test_a_flat_mesh_is_told():
    with pytest.raises(RemoSplatError, match="flat"):
        decompose(bracket()[:1], np.inf)


def test_a_stretched_box_grows_alike_on_all_sides():
    corners = np.array(
        [[x, y, z] for x in (0, 1.0) for y in (0, 0.2) for z in (0, 0.02)]
    )
    piece = convex_piece(corners, 0.0)
    grown = stretched(piece, corners, 1e-3)
    np.testing.assert_allclose(
        np.ptp(grown.vertices, axis=0), [1.0022, 0.2022, 0.0222], atol=1e-4
    )
    assert len(grown.vertices) == 8
    planes = ConvexHull(grown.vertices).equations
    depth = -(corners @ planes[:, :3].T + planes[:, 3]).max(axis=1)
    assert depth.min() >= 1e-3
