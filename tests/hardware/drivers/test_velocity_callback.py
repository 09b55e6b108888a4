"""The 1 kHz callback: a late answer and a lost state do not abort the arm."""

from collections.abc import Iterator
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from remosplat_drake.hardware.drivers.arm_record import RECORD_SIZE
from remosplat_drake.hardware.drivers.shared_record import SharedRecord
from remosplat_drake.hardware.stand_in import fci_library as library
from remosplat_drake.hardware.stand_in.fci_rules import FciRules
from remosplat_drake.hardware.stand_in.simulated_arm import ArmMeasurement

pytest.importorskip("ruckig", reason="needs the extra panda")

from remosplat_drake.hardware.drivers import velocity_callback
from remosplat_drake.hardware.drivers.velocity_callback import (
    SETPOINT_SIZE,
    VelocityCallback,
)
from remosplat_drake.hardware.drivers.velocity_servo import VelocityServo

RATES = np.array([0.5, -0.4, 0.3, 0.2, -0.5, 0.6, 0.7])
POSE = [0.0, -0.6, 0.0, -2.2, 0.0, 1.6, 0.8]
NOWHERE = ArmMeasurement(np.array(POSE), *np.zeros((3, 7)))

NOW = 5.0
"""The time of the callback and of the setpoints, which are never old [s]."""

IN_TIME, LATE, UNHEARD = "in time", "late", "unheard"
"""What happens in a millisecond: the answer to the state comes in time, or
after the robot's next step, or the callback does not get the state."""


class Link:
    """A callback and the robot's rules, with a setpoint at 100 Hz."""

    def __init__(self, setpoints: SharedRecord, states: SharedRecord):
        self.robot, self.tick, self._heard = FciRules(), 0, 0
        self.robot.begin()
        self._setpoints = setpoints
        self._callback = VelocityCallback(
            VelocityServo(), setpoints, states, library.JointVelocities
        )

    def ask(self, rates: np.ndarray) -> np.ndarray:
        """The callback's answer to the robot's present state."""
        self._setpoints.write((NOW, 0.0, *rates))
        command, zero = self.robot.command, [0.0] * 7
        state = library.RobotState(
            *(POSE, POSE, zero),
            command.velocity.tolist(),
            command.acceleration.tolist(),
            *(zero, zero, zero),
            library.RobotMode.kMove,
            self.robot.success_rate,
            library.Duration(self.tick),
        )
        period = library.Duration(self.tick - self._heard)
        self._heard = self.tick
        return np.array(self._callback(state, period).dq)

    def step(self, rates: np.ndarray, event: str = IN_TIME) -> None:
        """A millisecond of the robot."""
        answer = None if event == UNHEARD else self.ask(rates)
        self.robot.step(NOWHERE, answer if event == IN_TIME else None)
        self.tick += 1


@pytest.fixture(scope="module")
def records() -> Iterator[tuple[SharedRecord, SharedRecord]]:
    records = SharedRecord(SETPOINT_SIZE), SharedRecord(RECORD_SIZE)
    with pytest.MonkeyPatch.context() as patch:
        clock = SimpleNamespace(monotonic=lambda: NOW)
        patch.setattr(velocity_callback, "time", clock)
        yield records
    for record in records:
        record.close()


def test_one_late_answer_does_not_abort_the_arm(records):
    link = Link(*records)
    for _ in range(2):
        link.step(RATES)
    link.step(RATES, LATE)
    for _ in range(100):
        link.step(RATES)
        assert link.robot.error == ""
    np.testing.assert_allclose(link.robot.command.velocity, RATES, atol=1e-9)


events = st.sampled_from([IN_TIME, IN_TIME, IN_TIME, LATE, UNHEARD])
setpoints = st.lists(st.floats(-1, 1), min_size=7, max_size=7)
periods = st.lists(
    st.tuples(setpoints, st.lists(events, min_size=10, max_size=10)),
    min_size=1,
    max_size=12,
)


@settings(max_examples=60, deadline=None)
@given(periods=periods)
def test_late_answers_and_lost_states_do_not_abort_the_arm(records, periods):
    """Setpoints change every 10 ms; then the arm reaches the last one.

    Extrapolation over many lost packets may itself leave the robot's limits.
    """
    link = Link(*records)
    for rates, happenings in periods:
        for event in happenings:
            link.step(np.array(rates), event)
            if link.robot.error:
                assert event != IN_TIME
                return
    rates = np.array(periods[-1][0])
    for _ in range(300):
        link.step(rates)
        assert link.robot.error == ""
    np.testing.assert_allclose(link.robot.command.velocity, rates, atol=1e-6)
