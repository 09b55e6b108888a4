"""Tests of the plots that grow while a robot moves."""

import dataclasses as dc

import numpy as np
import pytest
from pydrake.common.value import Value

from remosplat_drake.robot.pose_error import pose_error
from remosplat_drake.signals.aim import Aim
from remosplat_drake.signals.distance_field import Clearances
from remosplat_drake.signals.tick_report import TickReport
from remosplat_drake.visualization.live_plots import LivePlots, RollingTrace


def test_a_point_is_the_worst_of_its_interval():
    trace = RollingTrace(1.0, 0.1, min)
    for time, value in [(0.0, 3.0), (0.05, 1.0), (0.09, 2.0), (0.1, 5.0)]:
        trace.add(time, value)
    age, value = trace.ages(0.1)
    np.testing.assert_allclose(age, [0.1, 0.0], atol=1e-12)
    np.testing.assert_array_equal(value, [1.0, 5.0])


def test_the_unknown_counts_most():
    trace = RollingTrace(1.0, 0.1, max)
    for value in (1.0, np.nan, 2.0):
        trace.add(0.0, value)
    assert np.isnan(trace.ages(0.0)[1]).all()


def test_memory_is_bounded_and_a_new_start_forgets():
    trace = RollingTrace(1.0, 0.1, max)
    for k in range(1000):
        trace.add(0.01 * k, 0.0)
    age, _ = trace.ages(9.99)
    assert len(age) == 11 and age.max() < 1.1
    trace.add(0.0, 7.0)
    np.testing.assert_array_equal(trace.ages(0.0)[1], [7.0])


@pytest.fixture
def show(page, frankie):
    """Publishes what the controller saw and what the robot does."""
    plots = LivePlots(
        page=page,
        robot=frankie,
        gain=1.0,
        max_speed=0.2,
        stopping=0.02,
        influence=0.5,
        period=0.02,
    )
    context = plots.CreateDefaultContext()

    def _show(time: float, report: TickReport, executed: np.ndarray):
        context.SetTime(time)
        plots.GetInputPort("report").FixValue(context, Value(report))
        plots.GetInputPort("executed").FixValue(context, executed)
        plots.ForcedPublish(context)
        return [page.told("plot", place) for place in ("0", "1")]

    return _show


def report_of(frankie, distance: float) -> TickReport:
    """The target is 0.1 m above the end effector, the scene so near."""
    q = np.zeros(frankie.n_q)
    X_WT = frankie.end_effector_pose(q).copy()
    X_WT[2, 3] += 0.1
    assert pose_error(frankie.end_effector_pose(q), X_WT).distance > 0.09
    clearances = Clearances(
        np.array([0]), np.array([distance]), np.eye(3)[:1], np.zeros((1, 3))
    )
    before = TickReport.before_first(frankie.n_q, frankie.n_u)
    return dc.replace(
        before, time=1.0, q=q, aim=Aim.of(X_WT), clearances=clearances
    )


def test_both_plots_say_how_it_is(show, frankie):
    """A robot that stands still although 0.1 m/s is wanted."""
    labels = show(1.0, report_of(frankie, 0.07), np.zeros(frankie.n_u))
    assert ">0.070 m<" in labels[0] and "stopping distance 0.02 m" in labels[0]
    assert ">0.100 m/s<" in labels[1]


def test_no_control_of_meshcat_carries_a_plot(show, page, frankie):
    """A browser lays all of them out again for each new one."""
    for k in range(5):
        show(0.1 * k, report_of(frankie, 0.01 * k), np.zeros(frankie.n_u))
    assert page.meshcat.GetButtonNames() == []


def test_nothing_is_plotted_before_the_first_tick(show, frankie):
    before = TickReport.before_first(frankie.n_q, frankie.n_u)
    labels = show(0.0, before, np.zeros(frankie.n_u))
    assert "unknown" in labels[0] and "unknown" in labels[1]
