"""The dead band in which a robot that holds its target stands still."""

import dataclasses as dc

import numpy as np
import pytest

from remosplat_drake.controller.controller_config import default_ingredients
from remosplat_drake.controller.rest import (
    Rest,
    RestRule,
    advance_rest,
    at_rest,
)
from remosplat_drake.controller.rest_config import RestConfig
from remosplat_drake.controller.tick.reactive_law import ReactiveLaw
from remosplat_drake.robot.braking import braking_command
from remosplat_drake.signals.aim import Aim
from remosplat_drake.signals.distance_field import Clearances
from remosplat_drake.signals.separation import Separation
from remosplat_drake.signals.target import Line, Target
from remosplat_drake.signals.tick_report import BRAKING, OPTIMAL, TickReport

DT = 0.05
RULE = RestRule(RestConfig(), lambda error: error.distance < 0.02)
Q = np.array([0.3, -0.8, 0.2])


@pytest.fixture(scope="module")
def law(three_link) -> ReactiveLaw:
    return ReactiveLaw(three_link, default_ingredients(three_link), DT)


class Hold:
    """A robot that stays at Q, and a target that begins 5 mm beside it."""

    def __init__(self, law: ReactiveLaw):
        self.law, self.rest, self.time = law, Rest(), 0.0
        self.clearance, self.more = 0.1, {}
        self.X_WE = law.robot.end_effector_pose(Q)
        self.aim = self.aim_at(0.005)

    def aim_at(self, beside: float) -> Aim:
        X_WT = self.X_WE.copy()
        X_WT[0, 3] += beside
        return Aim.of(X_WT)

    def report(self) -> TickReport:
        none = np.zeros(1, bool)
        e_x = np.array([[1.0, 0.0, 0.0]])
        clearances = Clearances(
            np.array([0]), np.array([self.clearance]), e_x, np.zeros((1, 3))
        )
        report = TickReport(
            time=self.time,
            q=Q,
            command=np.ones(3),
            status=OPTIMAL,
            reason="",
            scale=1.0,
            clearances=clearances,
            kept=none,
            tight=none,
            aim=self.aim,
        )
        return dc.replace(report, **self.more)

    def ticks(self, seconds: float) -> bool:
        """Whether the robot rests after some time."""
        for _ in range(round(seconds / DT)):
            self.rest = advance_rest(RULE, self.law, self.rest, self.report())
            self.time += DT
        return self.rest.is_still


@pytest.fixture
def resting(law) -> Hold:
    hold = Hold(law)
    assert not hold.ticks(0.9)
    assert hold.ticks(0.3)
    return hold


def test_it_does_not_rest_while_the_error_falls(law):
    hold = Hold(law)
    for beside in np.linspace(0.015, 0.005, 20):  # By 0.5 mm in 0.5 s.
        hold.rest = dc.replace(hold.rest, aim=hold.aim_at(beside))
        hold.aim = hold.rest.aim
        assert not hold.ticks(0.5)


def test_it_does_not_rest_before_it_has_arrived(law):
    hold = Hold(law)
    hold.aim = hold.aim_at(0.021)
    assert not hold.ticks(5.0)


def test_a_target_that_changes_ends_the_rest(resting):
    resting.aim = resting.aim_at(0.0049)
    assert not resting.ticks(DT)
    assert resting.ticks(1.2)


@pytest.mark.parametrize(("by", "rests"), [(0.0019, True), (0.0021, False)])
def test_an_error_that_grows_beyond_the_band_ends_it(resting, by, rests):
    # As if the same target had been held from a place that much farther away.
    resting.aim = resting.aim_at(0.005 + by)
    resting.rest = dc.replace(resting.rest, aim=resting.aim)
    assert resting.ticks(DT) == rests


@pytest.mark.parametrize(("lacks", "rests"), [(0.001, True), (0.003, False)])
def test_a_scene_that_comes_too_near_ends_it(resting, lacks, rests):
    resting.clearance = resting.law.collision.stopping - lacks
    assert resting.ticks(DT) == rests


@pytest.mark.parametrize(("beyond", "rests"), [(-0.01, False), (0.01, True)])
def test_what_moves_nearby_ends_it(resting, beyond, rests):
    distance = resting.law.movers.influence + beyond
    near = Separation("link", "Ada", distance, 0.2)
    resting.more = {"separation": near}
    assert resting.ticks(DT) == rests


def test_a_tick_that_brakes_does_not_rest(resting):
    resting.more = {"status": BRAKING}
    assert not resting.ticks(DT)


def test_a_line_is_no_place_to_rest(law):
    hold = Hold(law)
    hold.aim = Aim((Target(hold.X_WE, line=Line(hold.X_WE, 0.1)),))
    assert not hold.ticks(3.0)


def test_it_comes_to_rest_along_the_ramp(law):
    u = np.array([0.4, -0.2, 0.1])
    report = at_rest(law, Hold(law).report(), u)
    ramp = braking_command(u, law.robot.acceleration_limit, DT)
    np.testing.assert_array_equal(report.command, ramp)
