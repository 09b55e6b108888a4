"""The supervisor's state machine, rule by rule and for any history."""

import dataclasses as dc
import math

import numpy as np
import pytest
from effort import effort
from hypothesis import given, settings
from hypothesis import strategies as st
from supervised import (
    ACCELERATION,
    DT,
    MIN_CLEARANCE,
    VELOCITY,
    make_law,
    make_observation,
)

from remosplat_drake.robot.actuators import Actuator, ActuatorModel
from remosplat_drake.robot.braking import (
    braking_command,
    braking_steps,
    periods_between,
)
from remosplat_drake.safety.supervision import SupervisorLaw
from remosplat_drake.safety.supervisor import supervise
from remosplat_drake.safety.symptoms import symptoms
from remosplat_drake.scene.mover import Mover, Movers
from remosplat_drake.signals.motion import Motion
from remosplat_drake.signals.station_status import STOPPED as STATION_STOPPED
from remosplat_drake.signals.station_status import StationStatus
from remosplat_drake.signals.supervisor_state import (
    ARM_MODE,
    ASKED,
    LOST,
    RUNNING,
    SCANNER,
    STARTING,
    STOPPED,
    STOPPING,
    UNARMED,
    SupervisorState,
)
from remosplat_drake.signals.tick_report import BRAKING, RELAXED

FAST = 0.8 * VELOCITY


class Drive:
    """A supervisor that is shown one tick after the other."""

    def __init__(self, law: SupervisorLaw | None = None):
        self.law = law or make_law()
        self.state = SupervisorState(np.zeros(3))
        self.k = 0

    @property
    def time(self) -> float:
        return self.k * DT

    def tick(self, u=FAST, **seen) -> SupervisorState:
        now = make_observation(self.state, self.time, u, **seen)
        self.state = supervise(self.law, self.state, now)
        self.k += 1
        return self.state

    def ticks(self, n: int, u=FAST, **seen) -> SupervisorState:
        for _ in range(n):
            self.tick(u, **seen)
        return self.state

    def time_until_stopping(self, limit: float = 3.0, **seen) -> float:
        """How long something may last [s]; inf: longer than the limit."""
        start = self.time
        while self.time - start < limit:
            if self.tick(**seen).mode in (STOPPING, STOPPED):
                return self.time - DT - start
        return math.inf


@pytest.fixture
def running() -> Drive:
    drive = Drive()
    drive.ticks(100)
    assert drive.state.mode == RUNNING
    return drive


# Starting


def test_a_start_passes_what_was_verified_and_nothing_else():
    """A share of a command ends where verification has not looked."""
    state = Drive().tick()
    assert state.mode == RUNNING
    np.testing.assert_array_equal(state.command, FAST)


def test_a_strict_start_passes_nothing_beyond_the_bounds():
    drive = Drive(dc.replace(make_law(), strict=True))
    state = drive.tick(2.0 * ACCELERATION * DT)
    assert state.mode == STOPPED
    assert "out of bounds" in state.reason
    gentle = Drive(dc.replace(make_law(), strict=True)).tick(ACCELERATION * DT)
    assert gentle.mode == RUNNING


def test_it_waits_for_measurements_without_a_stop():
    drive = Drive()
    state = drive.ticks(50, status=StationStatus(age=math.inf))
    assert state.mode == STARTING
    assert state.reason == "waiting for the first measurement"
    assert not state.command.any()
    assert drive.tick().command.any()


def test_it_waits_for_the_first_tick_without_a_stop():
    drive = Drive()
    state = drive.ticks(50, tick_age=math.nan)
    assert state.reason == "waiting for the first control tick"
    assert not state.command.any()


def test_a_robot_in_trouble_is_not_started():
    """It must not start by itself when a person lifts the emergency stop."""
    drive = Drive()
    drive.tick(status=StationStatus(robot_mode="user_stopped"))
    assert drive.tick().mode == STOPPED
    assert drive.state.reason == "the arm's mode is user_stopped"


def test_measurements_that_are_lost_during_the_start_stop_it():
    drive = Drive()
    drive.ticks(10)
    state = drive.tick(status=StationStatus(age=math.inf))
    assert state.mode == STOPPING


# Rules: what stops a running robot, and how long it may last


@pytest.mark.parametrize(
    ("seen", "dwell", "reason"),
    [
        ({"status": StationStatus(age=0.06)}, 0, "measurements are 60 ms old"),
        ({"status": StationStatus(age=math.nan)}, 0, "nan ms old"),
        ({"status": StationStatus(robot_mode="reflex")}, 0, "mode is reflex"),
        (
            {"status": StationStatus(mode=STATION_STOPPED, stop_reason="x")},
            0,
            "the station stopped: x",
        ),
        (
            {"status": StationStatus(protective_stop=True)},
            0,
            "protective stop of the base",
        ),
        ({"status": StationStatus(success_rate=0.5)}, 0.2, "only 50 %"),
        ({"status": StationStatus(success_rate=math.nan)}, 0.2, "nan %"),
        ({"tick_age": 0.11}, 0, "control tick is 110 ms old"),
        ({"tick_age": math.nan}, 0, "control tick is nan ms old"),
        ({"u": [0, np.nan, 0]}, 0, "the command is not finite"),
        ({"u": [0, np.inf, 0]}, 0, "the command is not finite"),
        ({"q": np.nan}, 0, "measured positions are not finite"),
        ({"u_measured": np.full(3, np.nan)}, 0, "velocities are not finite"),
        ({"clearance": 0.0159}, 0.1, "clearance 15.9 mm is below 16.0 mm"),
        ({"clearance": -np.inf}, 0.1, "clearance -inf mm"),
        ({"status_": BRAKING}, 1.0, "no command for 1 s: no feasible"),
        ({"u_measured": np.zeros(3)}, 0.5, "u[0] is 0.00, not 0.40"),
        ({"stop": "stop button"}, 0, "stop button"),
    ],
    ids=lambda value: str(value)[:40],
)
def test_rule(running, seen, dwell, reason):
    if "status_" in seen:
        seen = {"report_status": seen["status_"]}
    assert running.time_until_stopping(**seen) == pytest.approx(dwell)
    assert reason in running.state.reason
    # Better again, and nothing moves without a release.
    running.ticks(200)
    assert running.state.mode == STOPPED
    assert reason in running.state.reason
    assert not running.state.command.any()


@pytest.mark.parametrize(
    "seen",
    [
        {"status": StationStatus(age=0.05)},
        {"status": StationStatus(robot_mode="idle")},
        {"status": StationStatus(success_rate=0.8)},
        {"tick_age": 0.099},
        {"clearance": 0.016},
        {"report_status": RELAXED},
        {"u_measured": FAST - 0.29 * VELOCITY},
        {"map_age": 1e9},
    ],
    ids=lambda value: str(value)[:40],
)
def test_what_is_just_good_enough(running, seen):
    assert running.time_until_stopping(**seen) == math.inf


def test_a_symptom_that_goes_away_in_time_stops_nothing(running):
    for _ in range(10):
        running.ticks(9, clearance=0.0)
        running.tick()
    assert running.state.mode == RUNNING


REFLEX = StationStatus(robot_mode="reflex")
STALE = StationStatus(age=0.2)
SLOW = StationStatus(success_rate=0.5)


def test_what_comes_after_a_stop_has_begun_changes_no_reason(running):
    running.tick(status=REFLEX)
    running.tick(status=STALE, stop="stop button")
    running.ticks(100, status=STALE)
    assert running.state.reason == "the arm's mode is reflex"
    assert running.state.symptom == ARM_MODE
    running.tick(status=STALE, release=True)
    assert running.state.refusal == (
        "not released: measurements are 200 ms old"
    )


def test_of_two_faults_the_one_that_stops_the_robot_is_named(running):
    """The other one is still within its dwell, though it began earlier."""
    running.ticks(10, status=SLOW)
    both = StationStatus(success_rate=0.5, robot_mode="reflex")
    assert running.tick(status=both).mode == STOPPING
    assert running.state.reason == "the arm's mode is reflex"


def test_of_two_faults_at_one_tick_the_first_cause_is_named(running):
    """Too little clearance for 0.1 s, too few commands for 0.2 s."""
    running.ticks(10, status=SLOW)
    running.ticks(10, status=SLOW, clearance=0.0)
    assert running.state.mode == RUNNING
    running.tick(status=SLOW, clearance=0.0)
    assert running.state.mode == STOPPING
    assert "only 50 %" in running.state.reason


def test_of_two_faults_that_begin_together_the_more_telling_is_named(running):
    """A robot whose driver is lost is not told to follow better."""
    running.tick(status=STALE, tick_age=0.2, clearance=-0.01)
    assert running.state.reason == "measurements are 200 ms old"


def test_a_person_comes_before_every_fault(running):
    running.tick(status=REFLEX, stop="stop button")
    assert running.state.reason == "stop button"
    assert running.state.symptom == ASKED
    running.ticks(100)
    running.tick(release=True)
    assert running.state.symptom == ""


@pytest.mark.parametrize(
    "status, symptom",
    [
        (StationStatus(mode=STATION_STOPPED, is_lost=True), LOST),
        (StationStatus(mode=STATION_STOPPED), "station"),
        (StationStatus(protective_stop=True), SCANNER),
    ],
)
def test_the_rule_that_stops_the_robot_is_named(running, status, symptom):
    running.ticks(100, status=status)
    assert running.state.symptom == symptom


def test_a_map_in_which_the_robot_stands_too_near_is_named(running):
    running.ticks(5, revision="first")
    running.ticks(11, revision="second", clearance=0.01)
    assert running.state.reason == (
        "in the new map the clearance 10.0 mm is below 16.0 mm"
    )
    # What touches in the new map is not set going there.
    running.ticks(50, revision="second", clearance=-0.01)
    running.tick(revision="second", clearance=-0.01, release=True)
    assert running.state.mode == STOPPED
    assert "in the new map" in running.state.refusal
    running.tick(revision="first", release=True)
    running.ticks(100, revision="first")
    assert running.state.mode == RUNNING
    running.ticks(11, revision="first", clearance=0.01)
    assert "new map" not in running.state.reason


@pytest.mark.parametrize("start", [0.001, 0.005, 0.01, 0.0159])
def test_a_robot_that_starts_too_near_may_leave(start):
    drive = Drive()
    for clearance in np.linspace(start, 0.03, 200):
        assert drive.tick(clearance=clearance).mode == RUNNING


@pytest.mark.parametrize(
    ("start", "reached", "least"),
    [
        (0.012, 0.012, 0.007),
        (0.012, 0.018, 0.013),
        (0.012, 0.03, MIN_CLEARANCE),
        (0.003, 0.004, 0.0),
    ],
)
def test_it_may_not_come_nearer_again(start, reached, least):
    drive = Drive()
    for clearance in np.linspace(start, reached, 50):
        assert drive.tick(clearance=clearance).mode == RUNNING
    drive.ticks(50, clearance=least + 1e-4)
    assert drive.state.mode == RUNNING
    drive.ticks(11, clearance=least - 1e-4)
    assert drive.state.mode == STOPPING
    assert drive.state.reason.endswith(f"is below {1e3 * least:.1f} mm")


def test_a_robot_that_starts_inside_the_scene_may_leave_it():
    drive = Drive()
    for clearance in np.linspace(-0.008, 0.001, 50):
        assert drive.tick(clearance=clearance).mode == RUNNING
    # Once it is outside, it may not touch again.
    drive.ticks(11, clearance=0.0)
    assert "clearance 0.0 mm is below" in drive.state.reason


def test_a_robot_that_starts_inside_the_scene_may_not_go_deeper():
    drive = Drive()
    drive.ticks(50, clearance=-0.008)
    assert drive.ticks(50, clearance=-0.0129).mode == RUNNING
    drive.ticks(11, clearance=-0.0131)
    assert drive.state.reason == "clearance -13.1 mm is below -13.0 mm"


def test_a_release_lets_it_leave_from_where_it_stands(running):
    running.ticks(100, clearance=0.01)
    assert running.state.mode == STOPPED
    assert running.tick(clearance=0.01, release=True).mode == STARTING
    assert running.ticks(50, clearance=0.01).mode == RUNNING
    running.ticks(11, clearance=0.004)
    assert running.state.reason == "clearance 4.0 mm is below 5.0 mm"


def test_nothing_is_set_going_beside_a_person():
    ada = Mover.sphere("Ada", [0.0, 0.0, 0.12], 0.1, max_acceleration=0.0)
    drive = Drive()
    for _ in range(100):
        movers = Movers(drive.time, [ada])
        drive.tick(clearance=0.01, movers=movers)
    movers = Movers(drive.time, [ada])
    drive.tick(clearance=0.01, movers=movers, release=True)
    assert drive.state.refusal.startswith("not released: Ada came nearer")


@pytest.mark.parametrize(
    ("away", "said"),
    [
        (0.12, "Ada came nearer than 16.0 mm, to 10.0 mm"),
        (0.3, "clearance 10.0"),
    ],
)
def test_who_came_too_near_is_told_from_a_wrong_map(running, away, said):
    """A live map shows her, too, and what it shows is where she stands."""
    for _ in range(11):
        ada = Mover.sphere("Ada", [0.0, 0.0, away], 0.1, max_acceleration=0.0)
        running.tick(clearance=0.01, movers=Movers(running.time, [ada]))
    assert running.state.reason.startswith(said)


def test_optional_rules():
    drive = Drive(make_law(max_target_jump=0.2, max_map_age=1.0))
    drive.ticks(100)
    assert drive.tick(map_age=0.9, x_WT=1.19).mode == RUNNING
    assert drive.tick(x_WT=0.9).mode == STOPPING
    assert drive.state.reason == "the target jumped by 0.29 m"
    drive = Drive(make_law(max_map_age=1.0))
    drive.ticks(100)
    assert drive.tick(map_age=1.1).mode == STOPPING
    assert drive.state.reason == "the map is 1.1 s old"


def make_motion(residual: float, v_measured=FAST, tube=0.02) -> Motion:
    """A robot that is so far off its model, in a tube so wide."""
    none, zeros = np.zeros((1, 3)), np.zeros(3)
    return Motion(
        ActuatorModel.make([Actuator()] * 3),
        *(0.0, np.zeros(1), none, 0.0, zeros, zeros, zeros, zeros),
        v_measured=np.array(v_measured),
        way_measured=zeros,
        residual=np.array([0.0, residual, 0.0]),
        bound=np.full(3, tube),
    )


def test_a_robot_that_leaves_its_tube_is_stopped(running):
    assert running.tick(motion=make_motion(0.019)).mode == RUNNING
    stopped = running.tick(motion=make_motion(0.021))
    assert stopped.mode == STOPPING
    assert "axis 1 is off by 0.021, beyond 0.020" in stopped.reason


def test_a_model_without_a_tube_forgives_rounding(running):
    """As of a description that has delays only, in simulation."""
    assert running.tick(motion=make_motion(1e-14, tube=0)).mode == RUNNING
    assert running.tick(motion=make_motion(1e-5, tube=0)).mode == STOPPING


def test_a_late_robot_follows_as_its_model_says(running):
    # It still stands, as it should by its dead time.
    late = {"u_measured": np.zeros(3), "motion": make_motion(0, np.zeros(3))}
    assert running.ticks(300, **late).mode == RUNNING
    del late["motion"]
    assert running.ticks(300, **late).mode == STOPPED


@pytest.mark.parametrize(
    ("u", "what"),
    [(FAST + np.array([0, 0, 0.2]), "changes by"), (1.3 * FAST, "is")],
)
def test_a_strict_supervisor_passes_nothing_beyond_the_bounds(u, what):
    drive = Drive(dc.replace(make_law(), strict=True))
    for share in np.linspace(0.0, 1.0, 41):  # As fast as joint 0 gets there.
        assert drive.tick(share * FAST).mode == RUNNING
    before = drive.state.command
    after = drive.tick(u)
    assert after.mode == STOPPING
    assert (
        f"out of bounds: u[{2 if what != 'is' else 0}] {what}" in after.reason
    )
    assert (np.abs(after.command) <= np.abs(before)).all()


def test_a_clock_that_goes_back_stops_the_robot(running):
    running.k -= 50
    assert running.tick().mode == STOPPING
    assert running.state.reason == "the clock went back by 0.49 s"
    running.ticks(100)
    assert running.state.mode == STOPPED


def test_after_a_pause_the_ramp_goes_on_where_the_drivers_are_on_it(running):
    running.k += 20
    assert running.tick().mode == STOPPING
    assert running.state.reason == "the control loop paused for 0.21 s"
    # They began it by themselves: it takes 40 ticks in all.
    np.testing.assert_allclose(running.state.command, FAST * (1 - 21 / 40))
    assert not running.ticks(19).command.any()


def test_after_a_long_pause_the_robot_is_not_set_going_again(running):
    running.k += 50
    assert running.tick().mode == STOPPED
    assert not running.state.command.any()
    assert not running.ticks(100).command.any()


# Stopping and releasing


def test_the_ramp_takes_as_long_as_the_slowest_joint(running):
    running.tick(stop="now")
    n = 1
    while running.state.mode == STOPPING:
        np.testing.assert_allclose(
            running.state.command, FAST * (1 - n / 40), atol=1e-9
        )
        running.tick()
        n += 1
    # 0.4 m/s in steps of 0.01 m/s.
    assert n == 40
    assert running.state.mode == STOPPED


def test_a_release_starts_again_from_zero(running):
    running.tick(stop="now")
    running.ticks(100)
    before = running.tick(release=True)
    assert before.mode == STARTING
    assert not before.command.any()
    assert running.tick().mode == RUNNING


def test_a_release_before_the_standstill_does_nothing(running):
    running.tick(stop="now")
    running.tick(release=True)
    assert running.state.mode == STOPPING
    running.ticks(100)
    assert running.state.mode == STOPPED


def test_a_release_while_something_is_wrong_is_refused(running):
    """The base lifts its protective stop by itself; that is no release."""
    trouble = StationStatus(protective_stop=True)
    running.ticks(100, status=trouble)
    state = running.tick(status=trouble, release=True)
    assert state.mode == STOPPED
    assert state.refusal == "not released: protective stop of the base"
    running.ticks(100)
    assert running.state.mode == STOPPED
    assert running.tick(release=True).mode == STARTING


# Any history

ages = st.sampled_from([0.0, 0.01, 0.049, 0.051, 1.0, math.inf, math.nan])
speeds = st.one_of(
    st.floats(-1.0, 1.0), st.sampled_from([0.0, 1.0, -1.0, np.nan, np.inf])
)
statuses = st.builds(
    StationStatus,
    age=ages,
    mode=st.sampled_from(["running"] * 9 + ["stopped"]),
    robot_mode=st.sampled_from(["move"] * 9 + ["reflex", ""]),
    success_rate=st.sampled_from([1.0, 0.9, 0.5, math.nan]),
    protective_stop=st.sampled_from([False] * 9 + [True]),
)
well = st.builds(StationStatus)
histories = st.lists(
    st.fixed_dictionaries(
        {
            "u": st.tuples(speeds, speeds, speeds),
            "repeat": st.integers(1, 30),
        },
        optional={
            "status": st.one_of(well, well, statuses),
            "clearance": st.sampled_from([0.1, 0.02, 0.01, -np.inf]),
            "report_status": st.sampled_from([BRAKING, RELAXED]),
            "tick_age": st.sampled_from([0.0, 0.2, math.nan]),
            "q": st.sampled_from([0.0, np.nan]),
            "skip": st.sampled_from([0, 0, 3, 50, -5]),
            "stop": st.sampled_from(["", "", "stop button"]),
            "release": st.booleans(),
        },
    ),
    max_size=30,
)


@given(histories)
@settings(max_examples=effort(60, 200))
def test_whatever_happens(history):
    law = make_law()
    drive = Drive(law)
    step = ACCELERATION * DT * (1 + 1e-6)
    for seen in history:
        u = np.array(seen.pop("u")) * VELOCITY
        drive.k += seen.pop("skip", 0)
        for _ in range(seen.pop("repeat")):
            before, time = drive.state, drive.time
            now = make_observation(before, time, u, **seen)
            after = drive.tick(u, **seen)
            wrong = symptoms(law, before, now)

            assert np.isfinite(after.command).all()
            change = np.abs(after.command - before.command)
            late = periods_between(before.time, time, DT)
            ramp = braking_command(before.command, ACCELERATION, late * DT)
            if after.mode == RUNNING:
                # The command as it is, or not at all.
                np.testing.assert_array_equal(after.command, u)
                assert not [s for s in wrong if s.dwell == 0]
                assert not seen.get("stop")
            else:
                assert (change <= late * step).all()
            if after.mode in (STOPPING, STOPPED):
                np.testing.assert_array_equal(after.command, ramp)
                assert after.reason
            if after.mode == STOPPED:
                assert not after.command.any()
            if before.mode == STOPPING:
                assert after.mode in (STOPPING, STOPPED)
            if before.mode == STOPPED and after.mode != STOPPED:
                assert seen.get("release")
                assert not wrong
            if before.mode == STOPPED:
                assert not after.command.any()
    # However fast it was, a stop takes no longer than the ramp.
    speed = drive.state.command
    drive.ticks(math.ceil(braking_steps(speed, ACCELERATION, DT)) + 1, stop="x")
    assert drive.state.mode == STOPPED


def test_an_unarmed_robot_stands_until_it_is_released():
    law, u = make_law(), (0.001, 0.0, 0.0)
    unarmed = SupervisorState(np.zeros(3), STOPPED, UNARMED)
    state = unarmed
    for i in range(100):
        state = supervise(law, state, make_observation(state, DT * i, u))
    assert (state.mode, state.reason) == (STOPPED, UNARMED)
    assert not state.command.any()
    near = make_observation(state, 1.0, u, release=True, clearance=0.0)
    refused = supervise(law, state, near)
    assert refused.mode == STOPPED and "clearance" in refused.refusal
    armed = supervise(law, state, make_observation(state, 1.0, u, release=True))
    assert armed.mode == STARTING
    told = supervise(law, state, make_observation(state, 1.0, u, stop="why"))
    assert (told.mode, told.reason) == (STOPPED, "why")
