"""Other targets on the page of a run, and what happens after a press."""

import time

import numpy as np
import pytest

from remosplat_drake.app.diagram import build
from remosplat_drake.app.run_result import REACHED
from remosplat_drake.app.scenario import load_scenario
from remosplat_drake.app.simulation import run
from remosplat_drake.cockpit.offers import HIGHER, NEARER, Trouble, trouble_of
from remosplat_drake.cockpit.page_offers import BUTTONS, OfferThread
from remosplat_drake.signals import motion_status as states
from remosplat_drake.signals import thing as things
from remosplat_drake.signals.binding import MOVER
from remosplat_drake.signals.motion_status import MotionStatus
from remosplat_drake.signals.target import Target
from remosplat_drake.visualization.page import MeshcatPage

BELOW = "{time_limit: 60, targets: [{translation: [1.15, 0.0, 0.5],\
  rpy_deg: [180, 0, 0]}], controller: {guidance: {enabled: false}}}"
"""Inside of the table."""


def wait(condition) -> None:
    for _ in range(3000):
        if condition():
            return
        time.sleep(0.01)
    raise AssertionError("it did not happen")


def test_offers_are_found_in_a_thread_that_ends():
    thread = OfferThread()
    trouble = Trouble(np.eye(4), np.eye(4), np.zeros(3))
    field = object()
    thread.ask(trouble, field, lambda X_WT: X_WT[2, 3] > 0.05)
    wait(lambda: any(o.label == HIGHER for o in thread.offers))
    wait(lambda: thread._thread is None)
    thread.ask(None, field, lambda X_WT: False)
    assert thread.offers == ()


@pytest.mark.parametrize(
    "kind, cause, helps",
    [
        (states.HELD, things.SOLID, True),
        (states.MOVING, states.NO_CONFIGURATION, True),
        (states.HELD, states.NO_PATH, True),
        (states.HELD, MOVER, False),
        (states.HELD, states.NOT_OBEYED, False),
        (states.STOPPED, states.SUPERVISOR, False),
        (states.MOVING, "", False),
    ],
)
def test_other_targets_help_a_robot_that_is_held(kind, cause, helps, frankie):
    status = MotionStatus(kind, "", cause=cause)
    target = Target(np.eye(4))
    trouble = trouble_of(status, target, frankie, frankie.q_home)
    assert (trouble is not None) == helps
    if trouble is not None:
        assert trouble.is_cut_off == (cause == states.NO_PATH)


def test_a_camera_may_look_at_the_unseen(frankie):
    p_W = np.array([0.9, 0.1, 0.3])
    unseen = things.UNSEEN_SPACE
    status = MotionStatus(
        states.HELD, "", cause=unseen.kind, thing=unseen.name, p_W=p_W
    )
    X_EC = np.eye(4)
    trouble = trouble_of(
        status, Target(np.eye(4)), frankie, frankie.q_home, X_EC
    )
    assert trouble is not None
    assert trouble.p_WUnseen is p_W and trouble.X_EC is X_EC


def test_a_press_replaces_a_target_that_cannot_be_reached(monkeypatch):
    page = MeshcatPage()
    clicks = page.meshcat.GetButtonClicks

    class Pressed:
        """Meshcat, whose first offer a person presses at once."""

        def __getattr__(self, name):
            return getattr(page.meshcat, name)

        def GetButtonClicks(self, name):
            return 1 if name in BUTTONS.values() else clicks(name)

    application = build(load_scenario("TableGroundTruth", BELOW), page=page)
    offers = application.diagram.GetSubsystemByName("page_offers")
    monkeypatch.setattr(offers, "_meshcat", Pressed())
    result = run(application, realtime_rate=1.0)
    assert result.outcome == REACHED
    assert (
        result.motion_status.text
        == "reached; an operator has replaced the target"
    )
    told = [status.cause for _, status in result.motion_history]
    assert things.SOLID in told
    assert offers._shown == ()


def test_a_run_offers_no_look():
    assert NEARER in BUTTONS and "Look there" not in BUTTONS
