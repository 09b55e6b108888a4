"""Sentences of closed loops about a robot that something holds."""

import re

import numpy as np
from held_robot import SHELF, drive

from remosplat_drake.controller.program.reactive_program import ReactiveProgram
from remosplat_drake.controller.program.tick import Tick
from remosplat_drake.signals import standing as stands
from remosplat_drake.signals import thing as things


def test_a_solid_is_called_by_its_name(tmp_path):
    result = drive(tmp_path, [0.5, 0.0, 0.05], SHELF)
    standing = result.standing
    assert standing.kind == stands.ENDED
    assert standing.cause == things.SOLID
    assert standing.thing == "the shelf"
    assert standing.link in ("panda_leftfinger", "panda_rightfinger")
    # On the shelf, and no nearer to the robot than the stopping distance.
    assert standing.p_W is not None and standing.clearance is not None
    assert abs(standing.p_W[2] - 0.27) < 1e-6
    assert 0.02 < standing.clearance < 0.03
    assert re.fullmatch(
        r"time limit: (left|right) finger held 2\d mm from the shelf,"
        r" 0\.\d\d m from the target: move or turn the target",
        standing.text,
    )


def test_what_held_it_is_remembered(tmp_path):
    result = drive(tmp_path, [0.5, 0.0, 0.05], SHELF)
    told = [(s.kind, s.cause) for _, s in result.standings]
    assert told[0] == (stands.MOVING, "")
    assert (stands.HELD, things.SOLID) in told
    # It does not flicker: a robot that is held stays so.
    assert len(told) <= 3
    times = [time for time, _ in result.standings]
    assert times == sorted(times)


def test_a_joint_limit(tmp_path):
    """What is above and behind the robot only a bent elbow would reach."""
    result = drive(tmp_path, [0.12, 0.0, 0.25])
    standing = result.standing
    assert standing.cause == stands.JOINT_LIMIT, standing.text
    assert "held at the" in standing.text and "limit of joint" in standing.text
    assert standing.p_W is not None


def test_out_of_reach(tmp_path):
    result = drive(tmp_path, [1.4, 0.0, 0.4])
    standing = result.standing
    assert standing.cause == stands.NO_CONFIGURATION, standing.text


class Leash:
    """Keeps the hand from going to the left."""

    def AddToProgram(self, program: ReactiveProgram, tick: Tick) -> None:
        J = tick.state.Jv_WE[1:2]
        program.add_rows("leash", J, np.zeros(1), lambda i: "panda_hand")


def test_a_constraint_of_another_package(tmp_path):
    result = drive(tmp_path, [0.4, 0.4, 0.4], ingredients=[Leash()])
    standing = result.standing
    assert standing.cause == stands.CONSTRAINT, standing.text
    assert "robot held by leash (hand)" in standing.text


def test_a_robot_that_arrives(tmp_path):
    result = drive(tmp_path, [0.45, 0.1, 0.4])
    assert (result.standing.kind, result.standing.text) == (
        stands.REACHED,
        "reached",
    )
    told = [s.kind for _, s in result.standings]
    assert told in ([stands.MOVING], [stands.MOVING, stands.REACHED])


def test_a_robot_that_is_stopped(tmp_path):
    text = "{supervisor: {robot_modes: [guiding]}}"
    result = drive(tmp_path, [0.45, 0.1, 0.4], text=text)
    assert result.standing.kind == stands.STOPPED
    assert result.standing.text.startswith(
        "stopped: the arm's mode is move; waiting for an operator, 0."
    )
