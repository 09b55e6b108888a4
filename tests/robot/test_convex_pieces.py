"""Cutting bodies into convex pieces: worked examples."""

import numpy as np
import pytest
from scipy.spatial import ConvexHull

from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.robot.fitting.convex_pieces import convex_pieces
from remosplat_drake.robot.fitting.enclosure import standing_out
from remosplat_drake.robot.fitting.link_spheres import LinkSpheres


def box(lower, upper) -> np.ndarray:
    """The surface of a box as triangles."""
    corners = np.array(
        [[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)]
    )
    p = np.array(lower) + corners * np.subtract(upper, lower)
    return p[ConvexHull(p).simplices]


def spheres(*rows) -> LinkSpheres:
    table = np.array(rows, float)
    return LinkSpheres(table[:, :3], table[:, 3])


def volume(pieces) -> float:
    return sum(piece.volume for piece in pieces)


def test_a_bar_in_two_spheres_stays_one_box():
    bar = box([0, 0, 0], [2, 1, 1])
    around = spheres([0.5, 0.5, 0.5, 0.9], [1.5, 0.5, 0.5, 0.9])
    (piece,) = convex_pieces(bar, around, 1e-3)
    assert len(piece.vertices) == 8
    assert piece.volume == pytest.approx(2)


def test_a_corner_is_cut_in_two_and_keeps_its_hollow():
    # An L: 2 x 1 x 1 and 1 x 2 x 1 share the unit cube at the origin.
    corner = np.vstack([box([0, 0, 0], [2, 1, 1]), box([0, 0, 0], [1, 2, 1])])
    around = spheres(
        [0.5, 0.5, 0.5, 0.9], [1.5, 0.5, 0.5, 0.9], [0.5, 1.5, 0.5, 0.9]
    )
    pieces = convex_pieces(corner, around, 1e-3)
    assert len(pieces) == 2
    assert volume(pieces) == pytest.approx(3)
    for piece in pieces:
        assert standing_out(piece.surface, around) <= 0


def test_pieces_are_only_joined_while_the_spheres_enclose_them():
    # The neck between the spheres is narrower than the bar is wide.
    bar = box([0, 0.3, 0.3], [2, 0.7, 0.7])
    ends = np.vstack([box([0, 0, 0], [0.5, 1, 1]), box([1.5, 0, 0], [2, 1, 1])])
    around = spheres([0.45, 0.5, 0.5, 0.86], [1.55, 0.5, 0.5, 0.86])
    dumbbell = np.vstack([bar, ends])
    pieces = convex_pieces(dumbbell, around, 1e-3, filling=np.inf)
    assert len(pieces) == 2
    for piece in pieces:
        assert standing_out(piece.surface, around) <= 0


def test_a_round_body_gets_few_corners_and_loses_little():
    angle = np.linspace(0, 2 * np.pi, 400, endpoint=False)
    rim = np.column_stack([np.cos(angle), np.sin(angle)])
    p = np.vstack([np.insert(rim, 2, z, axis=1) for z in (-1.0, 1.0)])
    cylinder = p[ConvexHull(p).simplices]
    (piece,) = convex_pieces(cylinder, spheres([0, 0, 0, 1.5]), 0.02)
    # A chord of a unit circle that leaves 0.02 outside spans 0.4 rad.
    assert 2 * 2 * np.pi / 0.401 < len(piece.vertices) < 80
    planes = ConvexHull(piece.vertices).equations
    assert (p @ planes[:, :3].T + planes[:, 3]).max() <= 0.02


def test_triangles_are_anticlockwise_from_outside():
    cube = box([0, 0, 0], [1, 1, 1])
    (piece,) = convex_pieces(cube, spheres([0.5, 0.5, 0.5, 0.9]), 1e-3)
    a, b, c = np.moveaxis(piece.surface, 1, 0)
    outward = np.cross(b - a, c - a) * (a - 0.5)
    assert (outward.sum(axis=1) > 0).all()


def test_a_surface_that_stands_out_is_refused():
    with pytest.raises(RemoSplatError, match=r"protrudes .* by 116\.0 mm"):
        convex_pieces(
            box([0, 0, 0], [1, 1, 1]), spheres([0.5, 0.5, 0.5, 0.75]), 1e-3
        )
