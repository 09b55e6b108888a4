"""The surfels that remain of several in one place, by hand."""

import numpy as np

from remosplat_drake.reconstruction.surfels.surfel_thinning import (
    uncrowded,
    with_spacing,
)
from remosplat_drake.reconstruction.surfels.surfels import Surfels

UP, DOWN, ASIDE = [0.0, 0, 1], [0.0, 0, -1], [1.0, 0, 0]


def row(x: list[float], normals: list[list[float]]) -> Surfels:
    """Surfels of spacing 1 on the x axis."""
    p_WK = np.zeros((len(x), 3))
    p_WK[:, 0] = x
    return Surfels(
        p_WK, np.array(normals), np.zeros((len(x), 3)), np.ones(len(x))
    )


def test_the_better_known_of_two_stays():
    surfels = row([0, 0.2, 0.9], [UP, UP, UP])
    keep = uncrowded(surfels, np.array([1.0, 2, 1]), 0.35)
    assert keep.tolist() == [False, True, True]


def test_both_sides_of_a_board_stay():
    surfels = row([0, 0.1], [UP, DOWN])
    assert uncrowded(surfels, np.array([1.0, 2]), 0.35).all()


def test_a_faint_one_goes_whatever_its_normal():
    surfels = row([0, 0.8, 5], [UP, ASIDE, ASIDE])
    keep = uncrowded(surfels, np.array([100.0, 1, 1]), 0.35)
    assert keep.tolist() == [True, False, True]


def test_what_was_dropped_drops_nothing():
    """The middle one goes for the first; the last one is then alone."""
    surfels = row([0, 0.3, 0.6], [UP, UP, UP])
    keep = uncrowded(surfels, np.array([3.0, 2, 1]), 0.35)
    assert keep.tolist() == [True, False, True]


def test_spacing_grows_into_gaps_but_not_beyond_half():
    surfels = row([0, 1, 1.5, 9, 30], [UP] * 5)
    kept = np.array([True, True, True, True, False])
    answer = with_spacing(surfels, kept)
    assert len(answer) == 4
    assert answer.spacing.min() >= 1
    assert answer.spacing.max() == 1.5
