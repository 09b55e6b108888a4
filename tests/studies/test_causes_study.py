"""Situations of the study of causes, its judgement, and what it counts."""

import dataclasses as dc

import numpy as np
import pytest

from apps.studies.causes.__main__ import table_of
from apps.studies.causes.drive import first_cause
from apps.studies.causes.faults import (
    CLASSES,
    LASTS,
    FaultyStation,
    has_fault,
    status_of,
)
from apps.studies.causes.judge import is_true
from apps.studies.causes.situations import (
    BASE,
    JOINT,
    KINDS,
    LOST,
    MOVER,
    NO_CONFIGURATION,
    NO_PATH,
    SCENE,
    STOP,
    draw_situation,
    is_reachable,
)
from apps.studies.causes.trial import Outcome, Trial, restored, run_trial
from remosplat_drake.signals import motion_status as states
from remosplat_drake.signals import thing as things
from remosplat_drake.signals.binding import JOINT_LIMIT
from remosplat_drake.signals.motion_status import MotionStatus
from remosplat_drake.signals.station_status import STOPPED, StationStatus


@pytest.mark.parametrize("kind", [SCENE, JOINT, NO_CONFIGURATION])
def test_a_target_of_a_kind_cannot_be_reached(kind, tmp_path):
    situation = draw_situation(KINDS.index(kind), tmp_path)
    assert situation.kind == kind
    assert not is_reachable(situation, situation.X_WT)
    again = draw_situation(KINDS.index(kind), tmp_path)
    np.testing.assert_array_equal(situation.X_WT, again.X_WT)


@pytest.mark.parametrize("kind", [MOVER, STOP, LOST, NO_PATH])
def test_a_target_of_a_kind_has_a_configuration(kind, tmp_path):
    situation = draw_situation(KINDS.index(kind), tmp_path)
    assert is_reachable(situation, situation.X_WT)


def test_causes_are_judged_by_the_truth(tmp_path):
    situation = draw_situation(KINDS.index(JOINT), tmp_path)
    robot, at = situation.world.robot, states.HELD
    q = situation.world.q0.copy()
    k = robot.joint_names.index("panda_joint4")
    held = MotionStatus(at, "", cause=JOINT_LIMIT, link="panda_link4")
    assert not is_true(held, situation, 1.0, q)
    q[k] = robot.position_lower[k] + 0.15
    assert is_true(held, situation, 1.0, q)
    for cause in (things.SOLID, states.NOTHING, states.BASE, states.NO_PATH):
        other = dc.replace(held, cause=cause)
        assert not is_true(other, situation, 1.0, q)


def test_a_stop_is_true_while_its_fault_is_there(tmp_path):
    situation = draw_situation(KINDS.index(LOST), tmp_path)
    stop = MotionStatus(states.STOPPED, "", cause=states.LOCALIZATION)
    q, begin = situation.world.q0, situation.fault_at
    assert is_true(stop, situation, begin + 0.1, q)
    assert not is_true(stop, situation, begin - 0.1, q)
    other = dc.replace(stop, cause=states.SUPERVISOR)
    assert not is_true(other, situation, begin + 0.1, q)


@pytest.mark.parametrize("fault", [f for fs in CLASSES.values() for f in fs])
def test_a_fault_lasts(fault):
    config = FaultyStation(fault, begin=1.0)
    assert not has_fault(config, 0.9) and has_fault(config, 1.0)
    assert not has_fault(config, 1.0 + LASTS)
    assert status_of(fault, False, "") == StationStatus()
    is_lost = fault in CLASSES[LOST]
    assert (status_of(fault, True, "") == StationStatus()) == is_lost
    lost = status_of(fault, True, "nothing came")
    assert lost.is_lost and lost.mode == STOPPED


def test_the_first_cause_counts():
    moving = MotionStatus(states.MOVING, "on the way")
    held = MotionStatus(states.HELD, "", cause=things.SOLID)
    assert first_cause(((0.0, moving), (2.0, held), (3.0, moving))) == (
        2.0,
        held,
    )
    assert first_cause(((0.0, moving),)) is None


def test_the_table_counts():
    right = Outcome("0", SCENE, "solid", "held", 0.9, True)
    outcomes = [
        dc.replace(right, actions=("Higher",), works=True),
        dc.replace(right, actions=("Higher",), delay=0.7),
        dc.replace(right, is_true=False),
        dc.replace(right, delay=1.5),
        Outcome("4", SCENE, is_free=True),
        Outcome("5", BASE),
    ]
    scene, base, both = table_of(outcomes).rows
    assert scene == (SCENE, "4", "2", "0.9", "1 of 2")
    assert base == (BASE, "1", "0", "nan", "0 of 0")
    assert both == ("all", "5", "2", "0.9", "1 of 2")
    assert restored(dc.asdict(outcomes[0])) == outcomes[0]


@pytest.mark.slow
@pytest.mark.parametrize("kind", [STOP, LOST, NO_CONFIGURATION, NO_PATH])
def test_a_cause_is_stated_and_an_action_works(kind):
    outcome = run_trial(Trial(KINDS.index(kind)))
    assert outcome.is_right and outcome.works
