"""Since when a robot stands still, and comes no nearer."""

import numpy as np
import pytest

from remosplat_drake.motion_status.hold import Hold, present_hold
from remosplat_drake.motion_status.stillness import (
    STILL,
    Rest,
    Stillness,
    observe,
)
from remosplat_drake.signals.aim import Aim
from remosplat_drake.signals.binding import MOVER
from remosplat_drake.signals.motion_status import NOTHING
from remosplat_drake.signals.thing import SOLID

HERE = np.eye(4)


def look(
    before: Stillness | None,
    time: float,
    at: float,
    distance: float = 1.0,
    X_WT: np.ndarray = HERE,
    may_rest: bool = False,
) -> Stillness:
    X_WE = X_WT.copy()
    X_WE[0, 3] -= distance
    q = np.array([at])
    return observe(before, time, q, Aim.of(X_WT), X_WE[None], may_rest=may_rest)


def test_who_trembles_stands_still():
    still = look(None, 1.0, 0.0)
    for k in range(10):
        still = look(still, 1.1 + 0.1 * k, (-1) ** k * 0.9 * STILL)
    assert still.robot.since == 1.0


def test_who_moves_does_not():
    still = look(None, 1.0, 0.0)
    still = look(still, 1.1, 0.6 * STILL)
    assert look(still, 1.2, 1.2 * STILL).robot.since == 1.2


def test_who_creeps_stands_still_and_then_moves():
    """At half of `STILL` a second, and later at five times as much."""
    still = look(None, 1.0, 0.0)
    for k in range(1, 100):
        still = look(still, 1.0 + 0.1 * k, 0.05 * STILL * k)
    assert still.robot.since == 1.0
    at = 0.05 * STILL * 99
    for k in range(1, 10):
        still = look(still, 10.9 + 0.1 * k, at + 0.5 * STILL * k)
    assert still.robot.since > 11.0


def test_a_jump_after_a_rest_is_motion():
    assert look(look(None, 1.0, 0.0), 9.0, 3.0 * STILL).robot.since == 9.0


def test_who_is_not_measured_does_not():
    assert look(look(None, 1.0, 0.0), 2.0, np.nan).robot.since == 2.0


def test_a_rest_does_not_count():
    still = look(look(None, 1.0, 0.0), 2.0, 0.0, may_rest=True)
    assert look(still, 2.5, 0.0).robot.since == 2.0


def test_a_clock_that_goes_back_begins_anew():
    assert look(look(None, 9.0, 0.0), 1.0, 0.0).robot.since == 1.0


def test_coming_nearer():
    still = look(None, 1.0, 0.0, distance=1.0)
    still = look(still, 2.0, 1.0, distance=0.995)
    assert still.nearest_at == 1.0
    still = look(still, 3.0, 2.0, distance=0.9)
    assert (still.nearest_at, still.nearest) == (3.0, 0.9)
    # Away from there, until there is another target.
    still = look(still, 4.0, 3.0, distance=1.5)
    assert still.nearest_at == 3.0
    still = look(still, 5.0, 4.0, distance=1.5, X_WT=2 * HERE)
    assert (still.nearest_at, still.nearest) == (5.0, 1.5)


def test_a_hand_rests_while_the_robot_moves():
    still = look(None, 1.0, 0.0)
    still = look(still, 2.5, 9.0 * STILL)
    assert still.robot.since == 2.5 and still.hands.since == 1.0
    still = look(still, 3.0, 9.0 * STILL, distance=1.0 - 3.0 * STILL)
    assert still.hands.since == 3.0


def test_a_hand_that_turns_does_not_rest():
    turned = np.eye(4)
    turned[:2, :2] = [[0.8, -0.6], [0.6, 0.8]]
    still = look(None, 1.0, 0.0)
    now = observe(
        still, 1.5, np.zeros(1), Aim.of(HERE), turned[None], may_rest=False
    )
    assert now.hands.since == 1.5


@pytest.mark.parametrize(
    "robot, hands, nearer, cause, lacks, is_held",
    [
        (0.0, 0.0, 0.0, NOTHING, False, True),
        (9.0, 0.0, 0.0, NOTHING, False, False),
        (9.0, 0.0, 0.0, NOTHING, True, True),
        (9.0, 0.0, 0.0, SOLID, False, True),
        (9.0, 9.0, 0.0, SOLID, False, False),
        (9.0, 9.0, 0.0, MOVER, False, True),
        (9.0, 9.0, 9.0, MOVER, False, False),
    ],
)
def test_the_hold_of_a_robot(robot, hands, nearer, cause, lacks, is_held):
    """Times at which robot and hand came to rest, and it last came nearer."""
    still = Stillness(
        Rest(np.zeros(1), 0.0, robot),
        Rest(HERE[None], 0.0, hands),
        Aim.of(HERE),
        1.0,
        nearer,
    )
    hold = present_hold(
        still, 9.2, lambda: Hold(cause), is_there=False, lacks=lacks
    )
    assert (hold is not None) == is_held
