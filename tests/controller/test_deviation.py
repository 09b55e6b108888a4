"""Desired and executed velocity of the end effector."""

import dataclasses as dc

import numpy as np
import pytest

from remosplat_drake.controller.deviation import (
    deviation,
    end_effector_velocities,
)
from remosplat_drake.signals.aim import Aim
from remosplat_drake.signals.tick_report import TickReport

Q = np.array([0.3, 0.5, -0.2])


def report_at(robot, p_ET_W) -> TickReport:
    X_WT = robot.end_effector_pose(Q)
    X_WT[:3, 3] += p_ET_W
    before = TickReport.before_first(robot.n_q, robot.n_u)
    return dc.replace(before, q=Q, aim=Aim.of(X_WT))


def test_desired_is_straight_to_the_target(three_link):
    report = report_at(three_link, [0.0, 0.3, 0.4])
    desired, executed = end_effector_velocities(
        report, np.zeros(3), three_link, gain=2.0, max_speed=0.5
    )
    # 2 * 0.5 m/s, limited to 0.5 m/s.
    np.testing.assert_allclose(desired, [0, 0, 0, 0, 0.3, 0.4], atol=1e-12)
    np.testing.assert_array_equal(executed, np.zeros(6))
    assert deviation(desired, executed) == pytest.approx(0.5)


def test_executed_is_the_end_effectors_true_motion(three_link):
    u, h = np.array([0.3, -0.2, 0.5]), 1e-6
    report = report_at(three_link, np.zeros(3))
    _, executed = end_effector_velocities(report, u, three_link, 2.0, 0.5)
    ahead, back = (
        three_link.end_effector_pose(Q + s * h * u)[:3, 3] for s in (1, -1)
    )
    np.testing.assert_allclose(
        executed[3:], (ahead - back) / (2 * h), atol=1e-8
    )


def test_before_the_first_tick_all_is_unknown(three_link):
    report = TickReport.before_first(three_link.n_q, three_link.n_u)
    desired, executed = end_effector_velocities(
        report, np.zeros(3), three_link, 2.0, 0.5
    )
    assert np.isnan(deviation(desired, executed))
