"""States of a page in a run, and the buttons of each."""

import numpy as np
import pytest

from remosplat_drake.signals.motion_status import HELD, MOVING, MotionStatus
from remosplat_drake.signals.supervisor_state import (
    RUNNING,
    STARTING,
    STOPPED,
    STOPPING,
    UNARMED,
    SupervisorState,
)
from remosplat_drake.visualization import page_state
from remosplat_drake.visualization.page_state import (
    RELEASE,
    START,
    STOP,
    ended,
    supervised,
    unsupervised,
    waiting,
)

MOVING_ON = MotionStatus(MOVING, "on its way")
IN_THE_WAY = MotionStatus(HELD, "hand held by the can")


def supervision(mode, reason="", refusal="") -> SupervisorState:
    return SupervisorState(np.zeros(2), mode, reason, refusal)


def test_before_a_run_nothing_can_be_stopped():
    assert waiting("TableReach").buttons == (START,)


@pytest.mark.parametrize(
    ("mode", "reason", "phase", "title", "buttons"),
    [
        (STARTING, "no command yet", page_state.LIVE, "Starting", (STOP,)),
        (RUNNING, "", page_state.LIVE, "Live", (STOP,)),
        (STOPPING, "late", page_state.STOPPED, "Stopping", (STOP,)),
        (STOPPED, "late", page_state.STOPPED, "Stopped", (STOP, RELEASE)),
        (STOPPED, UNARMED, page_state.WAITING, "Not armed", (STOP,)),
    ],
)
def test_what_a_supervisor_does(mode, reason, phase, title, buttons):
    state = supervised(supervision(mode, reason), releases=True)
    assert (state.phase, state.title) == (phase, title)
    assert state.text == reason
    assert state.buttons == buttons
    assert not state.is_over


@pytest.mark.parametrize("mode", [STARTING, RUNNING, STOPPING, STOPPED])
@pytest.mark.parametrize("reason", ["", "late", UNARMED])
def test_a_real_robots_page_stops_and_does_nothing_else(mode, reason):
    state = supervised(supervision(mode, reason), releases=False)
    assert state.buttons == (STOP,)


def test_a_refused_release_is_told():
    state = supervised(
        supervision(STOPPED, "too near", "still too near"), releases=True
    )
    assert state.text == "too near: still too near"


def test_what_stands_is_said_while_nothing_is_stopped():
    says = {
        mode: supervised(
            supervision(mode, "late"), releases=True, motion_status=MOVING_ON
        ).text
        for mode in (RUNNING, STOPPED)
    }
    assert says == {RUNNING: "on its way", STOPPED: "late"}


@pytest.mark.parametrize("reached", [True, False])
def test_when_all_is_over_nothing_can_be_pressed(reached):
    state = ended("in 3.2 s", reached=reached)
    assert state.is_over and state.buttons == ()
    assert ("Not" in state.title) != reached


def test_without_a_supervisor_nothing_pretends_to_stop():
    assert unsupervised().buttons == ()


def test_who_is_held_does_not_look_well():
    state = supervised(
        supervision(RUNNING), releases=True, motion_status=IN_THE_WAY
    )
    assert (state.phase, state.title) == (page_state.HELD, "Held")
    assert (state.text, state.buttons) == ("hand held by the can", (STOP,))
    assert unsupervised(IN_THE_WAY).text == "hand held by the can"
