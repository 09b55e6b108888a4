"""Cross-validation: maps of a wall, judged by views of it."""

import numpy as np
import pytest
from plane_views import looking_down

from remosplat_drake.reconstruction.report.validation import (
    LEAST_VIEWS,
    UNFORESEEN,
    Validation,
    confirmed_maximum,
    cross_validate,
    left_out,
    validate,
)
from remosplat_drake.reconstruction.surfels.surfels import (
    splat_of_surfels,
    surfels_from_capture,
)
from remosplat_drake.reconstruction.workspace import Workspace

WORKSPACE = Workspace(np.array([-0.2, -0.2, -1.0]), np.array([0.2, 0.2, 1]))


def floor_views(count: int):
    """Views of the floor z = 0 from 1 m, along a line of 10 cm."""
    p_WC = np.zeros((count, 3))
    p_WC[:, 0] = np.linspace(-0.05, 0.05, count)
    p_WC[:, 2] = 1.0
    return looking_down(p_WC)


def floor_splat(height: float, uncertainty: float):
    """The same floor, a little too low or too high."""
    splat = splat_of_surfels(
        surfels_from_capture(floor_views(4), 25_000, stride=1)
    )
    p_GK = splat.p_GK + np.array([0, 0, height])
    moved = type(splat)(
        p_GK, splat.quaternions, splat.scales, splat.opacities, splat.colors
    )
    return moved.with_uncertainty(np.full(len(splat), uncertainty))


def test_blocks_of_a_quarter_are_left_out():
    mask = left_out(64)
    assert mask.sum() == 16
    starts = np.flatnonzero(np.diff(np.append(0, mask.astype(int))) == 1)
    assert starts.tolist() == [6, 22, 38, 54]
    assert not left_out(LEAST_VIEWS - 1).any()
    assert left_out(LEAST_VIEWS).any()


def test_one_point_that_flew_proves_nothing():
    """Five points in a row, 1 cm apart, and one far from all."""
    p_W = np.array([[0.01 * i, 0, 0] for i in range(5)] + [[1.0, 0, 0]])
    error = np.array([0, 0.001, 0.05, 0.002, 0.003, 0.09])
    # Within 2 cm of the middle one: 0, 1, 50, 2 and 3 mm.
    assert confirmed_maximum(p_W, error) == pytest.approx(0.002)
    assert confirmed_maximum(p_W[:2], error[:2]) == -np.inf


def test_three_neighbours_are_believed():
    p_W = np.array([[0.001 * i, 0, 0] for i in range(30)])
    error = np.zeros(30)
    error[10:13] = [0.03, 0.05, 0.04]
    assert confirmed_maximum(p_W, error) == pytest.approx(0.03)


def test_a_floor_that_is_5_mm_too_low_is_over_estimated_by_5_mm():
    capture, judges = floor_views(32), left_out(32)
    found = validate(floor_splat(-0.005, 0.002), capture, judges, WORKSPACE)
    ellipsoids, views = found.ellipsoids, found.depth_views
    assert ellipsoids is not None and views is not None
    assert ellipsoids.largest_over == pytest.approx(0.005, abs=1e-3)
    assert np.median(ellipsoids.excess) == pytest.approx(0.003, abs=5e-4)
    assert ellipsoids.covered == 0
    # The nearest of a view's pixels is a little beside the nearest point.
    assert np.median(views.over) == pytest.approx(0.005, abs=1e-3)


def test_what_the_discs_allow_for_is_covered_and_earns_no_better_verdict():
    capture, judges = floor_views(32), left_out(32)
    verdicts = []
    for uncertainty in (0.001, 0.02):
        splat = floor_splat(-0.005, uncertainty)
        found = validate(splat, capture, judges, WORKSPACE).ellipsoids
        assert found is not None
        verdicts.append(found.verdict)
        assert found.covered == (uncertainty > 0.01)
    assert verdicts[0] == verdicts[1]
    assert verdicts[0] == pytest.approx(UNFORESEEN * 0.005, rel=0.2)


def test_a_floor_is_foretold_by_most_of_its_views():
    found = cross_validate(floor_views(LEAST_VIEWS), WORKSPACE).ellipsoids
    assert found is not None and len(found) > 100
    assert found.covered == 1
    assert found.verdict < 0.004
    few = cross_validate(floor_views(LEAST_VIEWS - 1), WORKSPACE)
    assert few.of_oracles == []


def test_two_points_tell_nothing_and_judge_nothing():
    """They would make a map of which nothing is known safe from 2 mm on."""
    p_W = np.zeros((2, 3))
    assert not Validation("any", p_W, np.zeros(2), np.zeros(2)).is_conclusive
    p_W = np.array([[0.0, 0, 0], [1, 0, 0], [2, 0, 0]])
    assert not Validation("any", p_W, np.zeros(3), np.zeros(3)).is_conclusive
    assert Validation("any", p_W / 200, np.zeros(3), np.zeros(3)).is_conclusive
