"""Tests of the red lines of a tick report."""

import dataclasses as dc

import numpy as np
import pytest

from remosplat_drake.signals.distance_field import Clearances
from remosplat_drake.signals.tick_report import TickReport
from remosplat_drake.visualization.clearance_lines import (
    KEPT,
    TIGHT,
    ClearanceLines,
    line_ends,
)


@pytest.fixture
def report(frankie) -> TickReport:
    """Three rows straight down from spheres 3, 10 and 20, 0.2 m long."""
    q = np.array([0.0, 0.0, 0.0, *frankie.home])
    spheres = frankie.spheres_at(q)
    i = np.array([3, 10, 20])
    down = np.tile([0.0, 0.0, -1.0], (3, 1))
    p_WC = spheres.p_WS[i] + (spheres.radius[i, None] + 0.2) * down
    return dc.replace(
        TickReport.before_first(frankie.n_q, frankie.n_u),
        q=q,
        clearances=Clearances(i, np.full(3, 0.2), down, p_WC),
        kept=np.array([True, True, False]),
        tight=np.array([True, False, False]),
    )


def test_lines_go_from_the_sphere_surface_to_the_witness(frankie, report):
    start, end = line_ends(frankie, report)
    np.testing.assert_allclose(start - end, np.tile([0, 0, 0.2], (3, 1)))
    np.testing.assert_array_equal(end, report.clearances.p_WC)


def test_no_rows_no_lines(frankie):
    report = TickReport.before_first(frankie.n_q, frankie.n_u)
    start, end = line_ends(frankie, report)
    assert start.shape == end.shape == (0, 3)


def test_tight_row_gets_a_thick_line_at_its_witness(
    page, frankie, report, pose_of, is_visible
):
    dut = ClearanceLines(page, frankie)
    dut.draw(report, time=0.0)
    assert page.meshcat.HasPath(KEPT)
    X = pose_of(page.meshcat, f"{TIGHT}/0")
    np.testing.assert_allclose(X[:3, 3], report.clearances.p_WC[0])
    np.testing.assert_allclose(X[:3, 2], [0, 0, 1], atol=1e-12)
    assert not page.meshcat.HasPath(f"{TIGHT}/1")
    assert is_visible(page.meshcat, f"{TIGHT}/0")


def test_lines_disappear_with_their_rows(page, frankie, report, is_visible):
    dut = ClearanceLines(page, frankie)
    dut.draw(report, time=0.0)
    pale = len(page.meshcat._GetPackedObject(KEPT))
    nothing = TickReport.before_first(frankie.n_q, frankie.n_u)
    dut.draw(nothing, time=0.1)
    assert not is_visible(page.meshcat, f"{TIGHT}/0")
    # The thin ones wait: a browser is slow.
    assert len(page.meshcat._GetPackedObject(KEPT)) == pale
    dut.draw(nothing, time=0.2)
    # One segment less: two points of three float32.
    assert len(page.meshcat._GetPackedObject(KEPT)) == pale - 24


def test_contact_has_a_line_of_no_length(page, frankie, report, pose_of):
    spheres = frankie.spheres_at(report.q)
    rows = report.clearances
    touch = spheres.p_WS[rows.sphere] + (
        spheres.radius[rows.sphere, None] * rows.direction_W
    )
    at_contact = dc.replace(
        report,
        clearances=dc.replace(rows, p_WC=touch, distance=np.zeros(3)),
    )
    ClearanceLines(page, frankie).draw(at_contact, time=0.0)
    assert np.isfinite(pose_of(page.meshcat, f"{TIGHT}/0")).all()
