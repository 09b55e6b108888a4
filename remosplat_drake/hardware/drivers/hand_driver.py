"""`HandDriver`: executes LCM commands on a parallel gripper."""

import math
import threading
from typing import Protocol

from pydrake.lcm import DrakeLcmInterface

from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.hardware.drivers.hand_messages import (
    hand_status,
    read_command,
)
from remosplat_drake.hardware.wire.channels import (
    PANDA_HAND_COMMAND,
    PANDA_HAND_STATUS,
)
from remosplat_drake.hardware.wire.inbox import CommandSource, Inbox


class HandLink(Protocol):
    """Protocol of a gripper that `HandDriver` drives."""

    def measure(self) -> tuple[float, float] | None:
        """Returns the fingers' opening and the force of each finger [m, N].

        Returns None if they are unknown. No status is then sent.
        """
        ...

    def go_to(self, width: float, force: float) -> None:
        """Moves the fingers, and returns when they have stopped.

        Args:
            width: Commanded opening [m].
            force: Bound on the gripping force [N].

        Raises:
            RemoSplatError: The fingers did not move as commanded.
        """
        ...


class HandDriver:
    """Moves a hand by commands from LCM, and publishes statuses at 10 Hz.

    A repeated command is ignored. If several different commands come during a
    motion, only the last of them is executed, after the motion.
    """

    def __init__(
        self,
        lcm: DrakeLcmInterface,
        hand: HandLink,
        inbox: CommandSource | None = None,
    ):
        """Subscribes to commands; the fingers do not move.

        Args:
            lcm: The LCM network.
            hand: The hand that the driver controls.
            inbox: Source of commands. If it is None, commands of all senders
                are accepted.
        """
        self._lcm = lcm
        self._hand = hand
        self._inbox = inbox or Inbox(lcm, [PANDA_HAND_COMMAND])
        self._wanted: tuple[float, float] | None = None
        self._done: tuple[float, float] | None = None
        self._motion: threading.Thread | None = None
        self._failure: RemoSplatError | None = None
        self._last = (math.nan, 0)

    def step(self, now: int) -> None:
        """Runs one period: receives commands, starts a motion, publishes.

        Args:
            now: Wall clock [us].

        Raises:
            RemoSplatError: The latest motion failed.
        """
        if self._failure is not None:
            raise self._failure
        for _, data in self._inbox.fetch():
            self._wanted = read_command(data) or self._wanted
        wanted = self._wanted
        if wanted is not None and wanted != self._done and not self._moving():
            self._done = wanted
            self._motion = threading.Thread(
                target=self._move, args=wanted, daemon=True
            )
            self._motion.start()
        measured = self._hand.measure()
        if measured is None:
            return
        width, force = measured
        status = hand_status(width, self._rate(width, now), force, now)
        self._lcm.Publish(PANDA_HAND_STATUS, status.encode())

    def _move(self, width: float, force: float) -> None:
        """Moves the hand in a thread, and stores its exceptions."""
        try:
            self._hand.go_to(width, force)
        except RemoSplatError as error:
            self._failure = error

    def _moving(self) -> bool:
        return self._motion is not None and self._motion.is_alive()

    def _rate(self, width: float, now: int) -> float:
        """Rate of the width since the previous status [m/s]."""
        last, then = self._last
        self._last = (width, now)
        rate = 1e6 * (width - last) / max(now - then, 1)
        return rate if math.isfinite(rate) else 0.0
