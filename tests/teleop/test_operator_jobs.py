"""An operator takes objects and puts them down, on the kinematic station."""

import numpy as np
import pytest
from job_rig import JobRig
from pydrake.common.value import Value

from remosplat_drake.signals.operator_requests import OperatorRequests
from remosplat_drake.signals.target_state import FOLLOW, HOLD
from remosplat_drake.task.task import DONE, FAILED

STOPPING = 0.021
"""Distance that the robot keeps from the scene [m]."""


@pytest.fixture(scope="module")
def rig(tmp_path_factory):
    return JobRig(tmp_path_factory.mktemp("session") / "session")


def test_a_can_is_taken_moved_by_hand_and_put_on_the_tray(rig):
    """In one run, since it says what happens from job to job."""
    refuses_what_cannot_be(rig)
    takes_the_can(rig)
    jogs_with_the_can(rig)
    refuses_a_second_object(rig)
    gives_up_and_tries_again(rig)
    lets_go_of_the_tray_only(rig)
    # The map over-estimates distances by 3 mm.
    assert rig.closest > STOPPING - 0.004


def refuses_what_cannot_be(rig):
    X_WE = rig.X_WE
    for count, values, reason in (
        ("takes", {"thing": "table"}, "the mass of the table is unknown"),
        ("takes", {"thing": "pot"}, "unknown object 'pot'"),
        ("places", {"support": "tray"}, "the hand is empty: take an object"),
    ):
        rig.ask(count, **values)
        rig.until_idle()
        state = rig.jobs.state
        assert state.outcome == FAILED and reason in state.failures[-1]
        assert reason in rig.led.text and rig.led.mode == HOLD
    assert rig.jobs.state.held == ""
    np.testing.assert_allclose(rig.X_WE, X_WE, atol=1e-4)


def takes_the_can(rig):
    rig.ask("takes", thing="soup can")
    rig.until_idle()
    assert rig.jobs.state.outcome == DONE, rig.jobs.state.failures
    assert rig.said[-6:-1] == [
        f"pick the soup can: {step} the soup can"
        for step in ("reaches for", "approaches", "grasps", "takes", "lifts")
    ]
    assert rig.led.text == "hold: pick the soup can: done"
    assert rig.jobs.state.held == "soup can" and 0.06 < rig.width < 0.07
    # What the steps allowed is over.
    assert rig.jobs.state.rules == ()
    # The target is where the robot stands: nothing moves by itself.
    before = rig.X_WE
    np.testing.assert_allclose(rig.led.X_WT, before, atol=1e-3)


def jogs_with_the_can(rig):
    X_WT = rig.X_WE.copy()
    X_WT[2, 3] += 0.08
    rig.ask("moves", X_WT=X_WT)
    rig.until(lambda: np.linalg.norm(rig.X_WE[:3, 3] - X_WT[:3, 3]) < 0.01)
    assert rig.led.mode == FOLLOW and rig.jobs.state.held == "soup can"
    # The hand holds on, even if the operator closes it.
    width = rig.width
    rig.ask("closes")
    start = rig.time
    rig.until(lambda: rig.time > start + 0.1)
    assert rig.width == width


def refuses_a_second_object(rig):
    rig.ask("takes", thing="box")
    rig.until_idle()
    assert "the hand already holds the soup can" in rig.led.text


def gives_up_and_tries_again(rig):
    rig.ask("places", support="tray")
    rig.until(lambda: "carries the soup can" in rig.jobs.text)
    rig.until(lambda: np.abs(rig.u).max() > 0.1)
    # Jogging is suspended meanwhile.
    rig.ask("moves", X_WT=np.eye(4))
    rig.until(lambda: rig.led.command.moves == rig.person.command.moves)
    assert rig.led.mode == HOLD and rig.jobs.runs
    rig.ask("holds")
    rig.until(lambda: not rig.jobs.runs)
    assert rig.jobs.is_braking and rig.jobs.state.held == "soup can"
    rig.until(lambda: not rig.jobs.leads)
    assert not rig.u.any()
    assert "the operator ended the job" in rig.led.text
    rig.ask("places", support="tray")
    rig.until_idle()
    assert rig.jobs.state.outcome == DONE, rig.jobs.state.failures


def lets_go_of_the_tray_only(rig):
    # On the tray, within 5 mm as for every step, and all of its foot.
    p_WO = rig.p_WO["soup can"]
    assert p_WO[2] == pytest.approx(0.5958 + 0.06, abs=0.0051)
    assert abs(p_WO[0] - 1.14) < 0.12 - 0.033 + 0.005
    assert abs(p_WO[1] - 0.8) < 0.15 - 0.033 + 0.005
    assert rig.jobs.state.held == "" and rig.jobs.state.rules == ()
    assert rig.width == pytest.approx(0.08)


def test_a_stop_ends_a_job(tmp_path):
    rig = JobRig(tmp_path / "session")
    rig.ask("takes", thing="box")
    rig.until(lambda: np.abs(rig.u).max() > 0.1)
    stop(rig)
    rig.until(lambda: not rig.jobs.runs)
    assert "the robot was stopped" in rig.jobs.state.failures[-1]
    rig.until(lambda: rig.supervision.is_latched and not rig.u.any())
    # Requests to a stopped robot are ignored.
    rig.ask("takes", thing="box")
    start = rig.time
    rig.until(lambda: rig.time > start + 0.1)
    assert not rig.jobs.runs


def stop(rig):
    """Presses the stop button."""
    supervisor = rig.application.supervisor
    context = supervisor.GetMyMutableContextFromRoot(
        rig.simulator.get_mutable_context()
    )
    supervisor.GetInputPort("operator").FixValue(
        context, Value(OperatorRequests(stops=1))
    )


def test_an_open_hand_lets_go(tmp_path):
    """A can of a task in the scenario: its own grasps are used."""
    rig = JobRig(tmp_path / "session", "TablePick")
    rig.ask("takes", thing="middle can")
    rig.until_idle()
    assert rig.jobs.state.held == "middle can", rig.jobs.state.failures
    (pick,) = rig.jobs.task.blocks
    assert len(pick.ways) == 1
    X_WT = rig.X_WE.copy()
    X_WT[2, 3] += 0.15
    rig.ask("moves", X_WT=X_WT)
    rig.until(lambda: np.linalg.norm(rig.X_WE[:3, 3] - X_WT[:3, 3]) < 0.01)
    p_WO = (X_WT @ np.linalg.inv(rig.jobs.state.X_OE))[:3, 3]
    rig.ask("opens")
    rig.until_idle()
    assert rig.jobs.state.outcome == DONE, rig.jobs.state.failures
    assert rig.jobs.state.held == "" and rig.width == pytest.approx(0.08)
    # The kinematic station leaves it where it was.
    assert rig.p_WO["middle can"] == pytest.approx(p_WO, abs=0.01)
