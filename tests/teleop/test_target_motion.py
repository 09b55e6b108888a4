"""Effects of each request on the target, step by step."""

import dataclasses as dc

import numpy as np
import pytest
from effort import effort
from hypothesis import given, settings
from hypothesis import strategies as st

from remosplat_drake.base.errors import FieldError
from remosplat_drake.robot.pose_error import pose_error
from remosplat_drake.signals.operator_command import OperatorCommand
from remosplat_drake.signals.target_state import (
    FOLLOW,
    GO,
    HOLD,
    SCAN,
    VELOCITY,
    TargetState,
)
from remosplat_drake.teleop.motion_law import MotionLaw
from remosplat_drake.teleop.target_motion import advance_target, stand
from remosplat_drake.teleop.teleop_config import (
    SavedPose,
    ScanConfig,
    TeleopConfig,
)

DT = 0.02
CONFIG = TeleopConfig(
    workspace_lower=[-1, -1, 0],
    workspace_upper=[1, 1, 1],
    poses={"shelf": SavedPose([0.5, 0.5, 0.5], [0, 0, 90])},
    scan=ScanConfig(dwell=0.1, timeout=2.0),
)
tries = settings(max_examples=effort(6, 15))
points = st.tuples(*[st.floats(-2, 2)] * 3)


def pose(*p: float, rpy_deg=(0, 0, 0)) -> np.ndarray:
    return SavedPose(list(p), list(rpy_deg)).matrix()


class Hand:
    """A target, and an end effector that stays or goes along with it."""

    def __init__(self, X_WE=None, config=CONFIG, follows=True):
        self.X_WE = pose(0, 0, 0.5) if X_WE is None else X_WE
        # The camera is the end effector itself, looking along its z axis.
        self.law = MotionLaw(config, pose(0.2, 0, 0.4), DT, np.eye(4), 4)
        self.state = TargetState.at_rest(self.X_WE)
        self.command = OperatorCommand(source="page")
        self.follows = follows
        self.time = 0.0

    def say(self, **changes) -> TargetState:
        """Changes the command and advances by a step."""
        self.command = dc.replace(self.command, **changes)
        self.state = advance_target(
            self.law, self.state, self.command, self.X_WE, self.time
        )
        self.time += DT
        if self.follows:
            self.X_WE = self.state.X_WT
        return self.state

    def move_to(self, X_WT) -> TargetState:
        return self.say(X_WT=X_WT, moves=self.command.moves + 1)

    def wait(self, duration: float) -> TargetState:
        for _ in range(round(duration / DT)):
            self.say()
        return self.state


def test_without_wishes_it_rests():
    hand = Hand()
    state = hand.wait(1.0)
    assert state.mode == HOLD
    np.testing.assert_array_equal(state.X_WT, pose(0, 0, 0.5))


def test_a_wished_pose_is_reached_smoothly():
    hand = Hand()
    goal = pose(0.3, -0.2, 0.6, rpy_deg=(10, 20, 170))
    assert hand.move_to(goal).mode == FOLLOW
    state = hand.wait(6.0)
    np.testing.assert_allclose(state.X_WT, goal, atol=1e-7)
    np.testing.assert_allclose(state.V_WT, 0, atol=1e-7)


def test_a_pose_that_merely_shows_the_target_is_no_wish():
    state = Hand().say(X_WT=pose(0.5, 0, 0.5))
    assert state.mode == HOLD


def test_a_stream_is_followed_without_further_moves():
    hand = Hand()
    hand.move_to(pose(0.1, 0, 0.5))
    hand.say(X_WT=pose(0, 0.1, 0.5))
    np.testing.assert_allclose(hand.wait(3).X_WT, pose(0, 0.1, 0.5), atol=1e-9)


@tries
@given(st.lists(points, min_size=1, max_size=4), st.floats(0.1, 2))
def test_it_stays_in_the_workspace_and_within_its_speed(goals, pause):
    hand = Hand()
    for goal in goals:
        hand.move_to(pose(*goal))
        for _ in range(round(pause / DT)):
            before = hand.state
            state = hand.say()
            p = state.X_WT[:3, 3]
            assert (p >= CONFIG.workspace_lower).all()
            assert (p <= CONFIG.workspace_upper).all()
            step = p - before.X_WT[:3, 3]
            assert np.linalg.norm(step) <= CONFIG.max_speed * DT * (1 + 1e-9)
    state = hand.wait(24.0)
    inside = np.clip(goals[-1], CONFIG.workspace_lower, CONFIG.workspace_upper)
    np.testing.assert_allclose(state.X_WT[:3, 3], inside, atol=1e-8)


@tries
@given(st.lists(points, min_size=1, max_size=4), st.floats(0.1, 2))
def test_away_from_the_walls_its_acceleration_is_bounded(goals, pause):
    config = dc.replace(
        CONFIG, workspace_lower=[-9.0] * 3, workspace_upper=[9.0] * 3
    )
    hand = Hand(config=config)
    for goal in goals:
        hand.move_to(pose(*goal, rpy_deg=np.multiply(goal, 60)))
        for _ in range(round(pause / DT)):
            before = hand.state.V_WT
            change = np.linalg.norm(
                (hand.say().V_WT - before).reshape(2, 3), axis=1
            )
            assert change[0] <= 2.0 * DT * (1 + 1e-6)
            assert change[1] <= 0.5 * DT * (1 + 1e-6)


def test_a_target_that_began_outside_only_comes_in():
    hand = Hand(pose(2, 0, 0.5))
    hand.move_to(pose(2, 0.5, 0.5))
    state = hand.say()
    assert state.X_WT[0, 3] < 2
    np.testing.assert_allclose(state.X_WT_goal[:3, 3], [1, 0.5, 0.5])
    np.testing.assert_allclose(
        hand.wait(8).X_WT[:3, 3], [1, 0.5, 0.5], atol=1e-9
    )


def test_hold_freezes_where_the_end_effector_is():
    hand = Hand(follows=False)
    hand.move_to(pose(0.9, 0, 0.5))
    hand.wait(1.0)
    state = hand.say(holds=1)
    assert (state.mode, state.text) == (HOLD, "hold")
    np.testing.assert_array_equal(state.X_WT, hand.X_WE)
    np.testing.assert_array_equal(state.V_WT, np.zeros(6))


def test_hold_lasts_while_a_stream_goes_on():
    hand = Hand(follows=False)
    hand.move_to(pose(0.9, 0, 0.5))
    hand.say(holds=1)
    for i in range(10):
        state = hand.say(X_WT=pose(0.1 * i, 0, 0.5))
    assert state.mode == HOLD
    assert hand.say(moves=hand.command.moves + 1).mode == FOLLOW


def test_hold_without_knowing_the_robot_keeps_the_target():
    hand = Hand(follows=False)
    hand.move_to(pose(0.9, 0, 0.5))
    before = hand.wait(1.0)
    hand.X_WE = np.full((4, 4), np.nan)
    np.testing.assert_array_equal(hand.say(holds=1).X_WT, before.X_WT)


def test_home_and_saved_poses():
    hand = Hand()
    assert hand.say(homes=1).mode == GO
    np.testing.assert_allclose(hand.wait(4).X_WT, pose(0.2, 0, 0.4), atol=1e-8)
    state = hand.say(pose="shelf", poses=1)
    assert (state.mode, state.text) == (GO, "going to 'shelf'")
    shelf = CONFIG.poses["shelf"].matrix()
    np.testing.assert_allclose(hand.wait(6).X_WT, shelf, atol=1e-8)


def test_an_unknown_pose_holds_and_says_so():
    state = Hand().say(pose="moon", poses=1)
    assert (state.mode, state.text) == (HOLD, "no saved pose 'moon'")


def test_hold_comes_before_all_else():
    state = Hand().say(
        holds=1, homes=1, scans=1, moves=1, X_WT=pose(0.5, 0, 0.5)
    )
    assert state.mode == HOLD
    hand = Hand()
    hand.say(holds=1, homes=1)
    assert hand.say().mode == HOLD  # The other wish is not taken up later.


class TestDeadManButton:
    AHEAD = np.array([0, 0, 0, 0.1, 0, 0])

    def test_it_moves_while_held_and_holds_when_let_go(self):
        hand = Hand()
        assert hand.say(V_W=self.AHEAD).mode == VELOCITY
        moving = hand.wait(1.0)
        np.testing.assert_allclose(moving.V_WT, self.AHEAD)
        assert 0.08 < moving.X_WT[0, 3] < 0.11
        state = hand.say(V_W=None)
        assert (state.mode, state.text) == (
            HOLD,
            "hold: the dead-man button was released",
        )
        np.testing.assert_array_equal(state.V_WT, np.zeros(6))
        np.testing.assert_array_equal(hand.wait(1).X_WT, moving.X_WT)

    def test_holding_it_alone_stops_what_went_on(self):
        hand = Hand()
        hand.move_to(pose(0.9, 0, 0.5))
        hand.wait(1.0)
        hand.say(V_W=np.zeros(6))
        rest = hand.wait(1.0)
        np.testing.assert_allclose(rest.V_WT, 0, atol=1e-12)
        assert rest.X_WT[0, 3] < 0.3

    def test_a_hold_outlasts_a_button_that_is_still_held(self):
        hand = Hand()
        hand.say(V_W=self.AHEAD)
        hand.say(holds=1)
        assert hand.wait(0.5).mode == HOLD
        hand.say(V_W=None)
        assert hand.say(V_W=self.AHEAD).mode == VELOCITY

    @tries
    @given(st.lists(st.tuples(*[st.floats(-3, 3)] * 6), max_size=5))
    def test_it_stays_in_the_workspace_and_within_its_speeds(self, wishes):
        hand = Hand()
        for wish in wishes:
            hand.say(V_W=np.array(wish))
            for _ in range(100):
                state = hand.say()
                p = state.X_WT[:3, 3]
                assert (p >= CONFIG.workspace_lower).all()
                assert (p <= CONFIG.workspace_upper).all()
                assert np.linalg.norm(state.V_WT[3:]) <= 0.25 * (1 + 1e-9)
                assert np.linalg.norm(state.V_WT[:3]) <= 1.0 * (1 + 1e-9)

    def test_it_does_not_run_away_from_a_robot_held_back(self):
        hand = Hand(follows=False)
        hand.say(V_W=np.array([0, 0, 0, 0.2, 0.1, 0]))
        state = hand.wait(5.0)
        lead = state.X_WT[:3, 3] - hand.X_WE[:3, 3]
        assert np.linalg.norm(lead) == pytest.approx(0.2)
        np.testing.assert_allclose(state.V_WT, 0, atol=1e-9)
        # The way back is free at once.
        hand.say(V_W=np.array([0, 0, 0, -0.2, -0.1, 0]))
        assert np.linalg.norm(hand.wait(1.0).X_WT[:3, 3] - [0, 0, 0.5]) < 0.1

    def test_it_slides_along_a_wall_and_brakes_before_it(self):
        hand = Hand(pose(0.8, 0, 0.5))
        hand.say(V_W=np.array([0, 0, 0, 0.2, 0.1, 0]))
        for _ in range(round(4 / DT)):
            before = hand.state.V_WT[3:]
            change = np.linalg.norm(hand.say().V_WT[3:] - before)
            assert change <= 0.5 * DT * (1 + 1e-6)
        np.testing.assert_allclose(hand.state.X_WT[0, 3], 1.0, atol=1e-9)
        np.testing.assert_allclose(hand.state.V_WT[4], 0.1)


class TestTrouble:
    def test_a_source_in_trouble_is_not_followed(self):
        hand = Hand(follows=False)
        hand.move_to(pose(0.9, 0, 0.5))
        hand.wait(0.5)
        state = hand.say(trouble="the pose stream has been silent")
        assert state.mode == HOLD
        assert state.text == "hold: the pose stream has been silent"
        np.testing.assert_array_equal(state.X_WT, hand.X_WE)

    def test_it_stays_so_until_the_source_takes_hold_anew(self):
        hand = Hand()
        hand.move_to(pose(0.9, 0, 0.5))
        hand.say(trouble="silent")
        assert hand.say(trouble="").mode == HOLD
        assert hand.move_to(pose(0.8, 0, 0.5)).mode == FOLLOW

    def test_going_home_needs_no_source(self):
        hand = Hand()
        hand.say(homes=1)
        assert hand.say(trouble="silent").mode == GO


class TestScan:
    def test_each_view_is_waited_for_and_asks_for_a_frame(self):
        hand = Hand(pose(0, 0, 0.5, rpy_deg=(180, 0, 0)))
        assert hand.say(scans=1).mode == SCAN
        frames, views = 0, set()
        while hand.state.mode == SCAN:
            views.add(hand.state.text)
            goal = hand.state.X_WT_goal
            state = hand.say()
            if state.frames_wanted > frames:
                frames = state.frames_wanted
                assert pose_error(hand.X_WE, goal).angle < 0.1
        assert frames == 4
        assert hand.state.unfinished == 3
        assert views == {f"scan: view {i} of 4" for i in (1, 2, 3, 4)}
        assert (hand.state.mode, hand.state.text) == (HOLD, "scan done")

    def test_a_view_out_of_reach_is_given_up(self):
        hand = Hand(pose(0, 0, 0.5, rpy_deg=(180, 0, 0)), follows=False)
        hand.say(scans=1)
        hand.wait(1.9)
        assert hand.state.text == "scan: view 1 of 4"
        hand.wait(2.0)
        assert hand.state.text == "scan: view 2 of 4"
        hand.wait(12.0)
        assert hand.state.frames_wanted == 4
        assert hand.state.mode == HOLD

    def test_hold_breaks_it_off(self):
        hand = Hand()
        hand.say(scans=1)
        hand.wait(0.1)
        assert hand.say(holds=1).mode == HOLD
        assert hand.wait(5).frames_wanted == 0

    def test_broken_off_its_last_frame_was_its_last_one(self):
        """So that a map is made of those that were taken."""
        hand = Hand()
        hand.say(scans=1)
        while hand.state.frames_wanted < 2:
            hand.say()
        assert hand.state.unfinished == 2
        assert hand.say(homes=1).unfinished == 1
        assert hand.say(holds=1).unfinished == 1

    def test_broken_off_before_its_first_frame_it_was_none(self):
        hand = Hand()
        hand.say(scans=1)
        state = hand.say(holds=1)
        assert (state.frames_wanted, state.unfinished) == (0, 0)

    def test_a_stopped_robot_breaks_it_off(self):
        hand = Hand()
        hand.say(scans=1)
        while hand.state.frames_wanted < 1:
            hand.say()
        state = stand(hand.state, hand.command, hand.X_WE, "stopped")
        assert (state.mode, state.text) == (HOLD, "stopped")
        assert state.unfinished == 0

    def test_without_a_camera_there_is_none(self):
        hand = Hand()
        hand.law = dc.replace(hand.law, X_EC=None)
        state = hand.say(scans=1)
        assert (state.mode, state.text) == (
            HOLD,
            "no scan: the robot has no wrist camera",
        )


def test_a_state_is_not_copied():
    state = TargetState.at_rest(np.eye(4))
    assert state.__deepcopy__({}) is state
    assert pytest.approx(0) == state.V_WT


def test_what_is_free_is_free_while_the_target_moves():
    law = MotionLaw(TeleopConfig(free=["rz"]), pose(0, 0, 0), DT)
    for mode, free in (
        (FOLLOW, ("rz",)),
        (VELOCITY, ("rz",)),
        (GO, ("rz",)),
        (HOLD, ()),
        (SCAN, ()),
    ):
        state = dc.replace(TargetState.at_rest(pose(1, 2, 3)), mode=mode)
        assert law.target(state).free == free


def test_a_scan_begins_as_the_hand_is_turned():
    config = dc.replace(CONFIG, free=["rz"])
    hand = Hand(config=config)
    hand.state = dc.replace(
        hand.state, mode=GO, X_WT=pose(0, 0, 0.5, rpy_deg=(0, 0, 90))
    )
    state = hand.say(scans=1)
    assert state.mode == SCAN
    assert pose_error(state.X_WT, pose(0, 0, 0.5)).angle < 0.1


def test_not_all_directions_can_be_left_to_the_robot():
    with pytest.raises(FieldError, match="none, one or all"):
        TeleopConfig(free=["rx", "ry"])
