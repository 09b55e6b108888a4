"""Sentences of closed loops about a robot that something holds."""

import re

import numpy as np
from held_robot import SHELF, drive

from remosplat_drake.controller.program.reactive_program import ReactiveProgram
from remosplat_drake.controller.program.tick import Tick
from remosplat_drake.signals import motion_status as states
from remosplat_drake.signals import thing as things


def test_a_solid_is_called_by_its_name(tmp_path):
    result = drive(tmp_path, [0.5, 0.0, 0.05], SHELF)
    status = result.motion_status
    assert status.kind == states.ENDED
    assert status.cause == things.SOLID
    assert status.thing == "the shelf"
    assert status.link in ("panda_leftfinger", "panda_rightfinger")
    # On the shelf, and no nearer to the robot than the stopping distance.
    assert status.p_W is not None and status.clearance is not None
    assert abs(status.p_W[2] - 0.27) < 1e-6
    assert 0.02 < status.clearance < 0.03
    assert re.fullmatch(
        r"time limit: (left|right) finger held 2\d mm from the shelf,"
        r" 0\.\d\d m from the target: move or turn the target",
        status.text,
    )


def test_what_held_it_is_remembered(tmp_path):
    result = drive(tmp_path, [0.5, 0.0, 0.05], SHELF)
    told = [(s.kind, s.cause) for _, s in result.motion_history]
    assert told[0] == (states.MOVING, "")
    assert (states.HELD, things.SOLID) in told
    # It does not flicker: a robot that is held stays so.
    assert len(told) <= 3
    times = [time for time, _ in result.motion_history]
    assert times == sorted(times)


def test_a_joint_limit(tmp_path):
    """What is above and behind the robot only a bent elbow would reach."""
    result = drive(tmp_path, [0.12, 0.0, 0.25])
    status = result.motion_status
    assert status.cause == states.JOINT_LIMIT, status.text
    assert "held at the" in status.text and "limit of joint" in status.text
    assert status.p_W is not None


def test_out_of_reach(tmp_path):
    result = drive(tmp_path, [1.4, 0.0, 0.4])
    status = result.motion_status
    assert status.cause == states.NO_CONFIGURATION, status.text


class Leash:
    """Keeps the hand from going to the left."""

    def AddToProgram(self, program: ReactiveProgram, tick: Tick) -> None:
        J = tick.state.Jv_WE[1:2]
        program.add_rows("leash", J, np.zeros(1), lambda i: "panda_hand")


def test_a_constraint_of_another_package(tmp_path):
    result = drive(tmp_path, [0.4, 0.4, 0.4], ingredients=[Leash()])
    status = result.motion_status
    assert status.cause == states.CONSTRAINT, status.text
    assert "robot held by leash (hand)" in status.text


def test_a_robot_that_arrives(tmp_path):
    result = drive(tmp_path, [0.45, 0.1, 0.4])
    assert (result.motion_status.kind, result.motion_status.text) == (
        states.REACHED,
        "reached",
    )
    told = [s.kind for _, s in result.motion_history]
    assert told in ([states.MOVING], [states.MOVING, states.REACHED])


def test_a_robot_that_is_stopped(tmp_path):
    text = "{supervisor: {robot_modes: [guiding]}}"
    result = drive(tmp_path, [0.45, 0.1, 0.4], text=text)
    assert result.motion_status.kind == states.STOPPED
    assert result.motion_status.text.startswith(
        "stopped: the arm's mode is move; waiting for an operator, 0."
    )
