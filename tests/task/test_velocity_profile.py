"""A profile of velocities, by the clock of its context."""

import numpy as np
import pytest
from pydrake.systems.framework import Context

from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.task.targets import check_targets
from remosplat_drake.task.velocity_profile import VelocityProfile

PERIOD = 0.125


@pytest.fixture
def profile(frankie) -> VelocityProfile:
    return VelocityProfile(robot=frankie, period=PERIOD)


def context_of(profile: VelocityProfile, robot: RobotModel) -> Context:
    context = profile.CreateDefaultContext()
    profile.GetInputPort("configuration").FixValue(context, robot.q_home)
    return context


def rows(robot: RobotModel) -> np.ndarray:
    return np.array([[1.0], [2.0], [3.0]]) * np.ones(robot.n_u)


def test_it_hands_out_one_row_a_period_and_then_rest(profile, frankie):
    context = context_of(profile, frankie)
    context.SetTime(10.0)
    profile.play(context, rows(frankie))
    found = []
    for k in range(8):
        # In the middle of each period, and just before its end by rounding.
        context.SetTime(10.0 + PERIOD * (k // 2) + (k % 2) * 0.99 * PERIOD)
        aim = profile.GetOutputPort("aim").Eval(context)
        found.append(aim.u[0])
        assert profile.progress(context).finished == (k >= 6)
    assert found == [1.0, 1.0, 2.0, 2.0, 3.0, 3.0, 0.0, 0.0]


def test_before_it_is_played_it_asks_for_rest(profile, frankie):
    context = context_of(profile, frankie)
    for time in (0.0, 1e9):
        context.SetTime(time)
        aim = profile.GetOutputPort("aim").Eval(context)
        assert not aim.u.any()
        assert not profile.progress(context).finished


def test_the_end_effector_is_where_it_shall_be(profile, frankie):
    context = context_of(profile, frankie)
    error = profile.error(context)
    assert (error.distance, error.angle) == (0.0, 0.0)
    X_WE = frankie.end_effector_pose(frankie.q_home)
    target = profile.GetOutputPort("target").Eval(context)
    np.testing.assert_allclose(target.GetAsMatrix4(), X_WE)


def test_it_is_what_the_application_takes_for_targets(profile):
    check_targets(profile, "a profile")
