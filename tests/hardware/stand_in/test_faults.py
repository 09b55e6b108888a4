"""Faults: how they are written, when they are present, what they spoil."""

import math

import pytest
from drake import lcmt_drake_signal, lcmt_panda_status

from remosplat_drake.base.errors import FieldError
from remosplat_drake.hardware.stand_in.faults import (
    FAULTS,
    Fault,
    FaultSchedule,
    parse_fault,
    requested_faults,
    spoil,
)


def status() -> lcmt_panda_status:
    message = lcmt_panda_status()
    message.num_joints = 7
    for name in message.__slots__:
        if name.startswith("joint_"):
            setattr(message, name, [float(i) for i in range(7)])
    return message


def present(*faults: Fault) -> FaultSchedule:
    schedule = FaultSchedule()
    for fault in faults:
        schedule.begin(fault)
    return schedule


@pytest.mark.parametrize(
    ("text", "fault"),
    [
        ("status-stops@3", Fault("status-stops", 0.0, 3.0)),
        ("clock-jump=-0.5@2+1", Fault("clock-jump", -0.5, 2.0, 3.0)),
        ("clock-jump@0.5", Fault("clock-jump", 1.0, 0.5)),
        ("status-joints=0@1", Fault("status-joints", 0.0, 1.0)),
    ],
)
def test_a_fault_is_read(text, fault):
    assert parse_fault(text) == fault


@pytest.mark.parametrize(
    "text", ["", "reflex", "reflex@", "reflex@-1", "reflex@x", "reflex@1+"]
)
def test_what_is_not_written_as_a_fault_is_refused(text):
    with pytest.raises(FieldError, match="START"):
        parse_fault(text)


def test_an_unknown_fault_names_the_known_ones():
    with pytest.raises(FieldError, match="did you mean 'reflex'"):
        parse_fault("reflux@1")


def test_a_fault_is_present_from_its_start_to_its_end():
    schedule = FaultSchedule([parse_fault("clock-jump=2@1+0.5")])
    assert schedule.advance(-1.0) == []
    assert schedule.advance(0.99) == []
    assert "clock-jump" not in schedule
    assert len(schedule.advance(1.0)) == 1
    assert schedule.value("clock-jump", 0.0) == 2.0
    assert schedule.advance(1.4) == []
    assert "clock-jump" in schedule
    schedule.advance(1.5)
    assert "clock-jump" not in schedule
    assert schedule.value("clock-jump", 0.0) == 0.0


def test_recovery_ends_every_fault():
    schedule = present(Fault("status-nan", 0.0), Fault("packet-loss", 0.5))
    schedule.begin(Fault("recover", 0.0))
    assert not any(name in schedule for name in FAULTS)


def test_a_position_that_is_not_a_number():
    message = status()
    spoil(message, present(Fault("status-nan", 0.0)))
    assert math.isnan(message.joint_position[0])
    assert list(message.joint_position[1:]) == [1, 2, 3, 4, 5, 6]


@pytest.mark.parametrize("n", [0, 6, 9])
def test_a_wrong_number_of_joints_is_a_message_all_the_same(n):
    message = status()
    spoil(message, present(Fault("status-joints", float(n))))
    decoded = lcmt_panda_status.decode(message.encode())
    assert decoded.num_joints == n
    assert list(decoded.joint_velocity) == [0, 1, 2, 3, 4, 5, 6, 0, 0][:n]


def test_faults_are_requested_over_the_wire():
    message = lcmt_drake_signal()
    message.dim = 3
    message.coord = ["clock-jump", "nonsense", "packet-loss"]
    message.val = [3.0, 1.0, 0.0]
    assert requested_faults(message.encode()) == [
        Fault("clock-jump", 3.0),
        Fault("packet-loss", 0.5),
    ]
    assert requested_faults(b"nonsense") == []
