"""The hand's driver: what it does with commands, and its statuses."""

import threading
import time

import pytest
from drake import lcmt_schunk_wsg_command
from patience import PATIENCE
from pydrake.lcm import DrakeLcm
from robot_process import Client

from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.hardware.drivers.hand_driver import HandDriver
from remosplat_drake.hardware.drivers.hand_messages import (
    hand_status,
    read_command,
)

NOW = 1_700_000_000_000_000


class SlowHand:
    """Fingers that arrive when the test lets them."""

    def __init__(self):
        self.motions: list[tuple[float, float]] = []
        self.arrive = threading.Event()
        self._width = 0.08
        self._force = 0.0

    def measure(self) -> tuple[float, float]:
        return self._width, self._force

    def go_to(self, width: float, force: float) -> None:
        self.motions.append((width, force))
        assert self.arrive.wait(PATIENCE)
        self._width, self._force = width, force


class Setting:
    """A driver, its hand, and a controller that commands, in one process.

    Only the fingers take their time, in a thread.
    """

    def __init__(self):
        wire = DrakeLcm("memq://")
        self.client = Client(wire)
        self.hand = SlowHand()
        self.driver = HandDriver(wire, self.hand)
        self.now = NOW

    def step(self) -> None:
        self.now += 100_000
        self.driver.step(self.now)
        self.client.listen(0.0)

    def step_until(self, done) -> None:
        end = time.monotonic() + PATIENCE
        while not done():
            assert time.monotonic() < end
            self.step()
            time.sleep(0.001)


def test_messages_are_in_millimetres():
    message = lcmt_schunk_wsg_command()
    message.target_position_mm, message.force = 30.0, 12.0
    assert read_command(message.encode()) == (0.03, 12.0)
    assert read_command(b"nonsense") is None
    message.force = float("nan")
    assert read_command(message.encode()) is None
    status = hand_status(0.05, -0.1, 12.0, NOW)
    assert status.actual_position_mm == pytest.approx(50)
    assert status.actual_speed_mm_per_s == pytest.approx(-100)
    assert status.actual_force == 12.0


def test_nothing_moves_before_a_command():
    setting = Setting()
    for _ in range(3):
        setting.step()
    assert not setting.hand.motions
    assert setting.client.hand[-1].actual_position_mm == pytest.approx(80)


def test_statuses_go_on_during_a_motion_and_the_last_command_counts():
    setting = Setting()
    setting.client.send_hand(0.02, 10.0)
    setting.step_until(lambda: setting.hand.motions)
    for width in (0.03, 0.04):
        setting.client.send_hand(width, 10.0)
        setting.step()
    heard = len(setting.client.hand)
    setting.step_until(lambda: len(setting.client.hand) > heard + 1)
    assert setting.hand.motions == [(0.02, 10.0)]
    setting.hand.arrive.set()
    setting.step_until(lambda: len(setting.hand.motions) == 2)
    assert setting.hand.motions[-1] == (0.04, 10.0)


def test_a_motion_that_failed_ends_the_driver():
    setting = Setting()

    def refuse(width: float, force: float) -> None:
        raise RemoSplatError("the hand: no power")

    setting.hand.go_to = refuse
    setting.client.send_hand(0.02, 10.0)
    with pytest.raises(RemoSplatError, match="no power"):
        setting.step_until(lambda: False)


def test_equal_commands_are_carried_out_once():
    setting = Setting()
    setting.hand.arrive.set()
    for _ in range(5):
        setting.client.send_hand(0.02, 10.0)
        setting.step()
    setting.step_until(lambda: setting.hand.measure()[0] == 0.02)
    assert setting.hand.motions == [(0.02, 10.0)]
    setting.step_until(lambda: setting.client.hand[-1].actual_force == 10.0)


def test_the_speed_is_that_between_two_statuses():
    """60 mm in a tenth of a second."""
    setting = Setting()
    setting.hand.arrive.set()
    setting.step()
    setting.client.send_hand(0.02, 10.0)
    setting.step_until(
        lambda: any(
            status.actual_speed_mm_per_s == pytest.approx(-600)
            for status in setting.client.hand
        )
    )
