"""`DeadMan`: the state of a gamepad's dead-man switch."""

import time

from pydrake.geometry import Meshcat

from remosplat_drake.teleop.gamepad import SILENCE


class DeadMan:
    """The watchdog of a gamepad's dead-man switch.

    While the switch is held, the page sends pulses: it clicks a hidden button
    periodically (`web/live.js`). The pulses are necessary, since Meshcat
    reports a gamepad only when the gamepad's state changes. Without pulses, the
    switch would count as held forever if the page is closed, is hidden or hangs
    while it is held.

    Args:
        meshcat: The page's Meshcat server.
        button: Number of the button that is the dead-man switch.

    Attributes:
        pulse: Name of the hidden button that the page clicks while the switch
            is held.
    """

    def __init__(self, meshcat: Meshcat, button: int):
        self._meshcat = meshcat
        self._pulses = 0
        self._heard = -float("inf")
        self.pulse = pulse(button)
        meshcat.AddButton(self.pulse)

    def is_held(self) -> bool:
        """Returns whether the page has sent a pulse within `SILENCE`."""
        now = time.monotonic()
        pulses = self._meshcat.GetButtonClicks(self.pulse)
        if pulses != self._pulses:
            self._pulses = pulses
            self._heard = now
        return now - self._heard < SILENCE


def pulse(button: int) -> str:
    """Returns the name of the hidden button that the page clicks.

    Args:
        button: Number of the button that is the dead-man switch.
    """
    return (
        '<span class="remosplat-hidden remosplat-pulse"'
        f' data-button="{button}"></span>'
    )
