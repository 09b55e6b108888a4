"""`DeadMan`: whether the gamepad's dead-man switch is held right now."""

import html
import time

from pydrake.geometry import Meshcat

PULSE = '<span class="remosplat-style remosplat-pulse"></span>'
"""Name of a hidden button that the page clicks while the button is held."""

SILENCE = 0.5
"""Time without a pulse after which the switch counts as let go [s]."""

_SCRIPT = """
setInterval(() => {{
  const pads = [...(navigator.getGamepads?.() || [])];
  const pad = pads.find((p) => p && p.connected);
  if (document.hidden || !(pad?.buttons[{button}]?.value > 0.5)) return;
  document.querySelector(".remosplat-pulse").closest("li").click();
}}, 50);
"""


class DeadMan:
    """The watchdog of a gamepad's dead-man switch.

    It listens for a pulse that the page sends while the button is held.

    Meshcat tells of a gamepad when it changes, and only then: a page that is
    closed, hidden or hangs with the button held would leave it pressed for
    ever. So the page says again and again that the button is held. Meshcat
    draws buttons' names as HTML, and a picture that is none runs the script.

    Args:
        meshcat: The page's Meshcat server.
        button: Number of the button that is the dead-man switch.
    """

    def __init__(self, meshcat: Meshcat, button: int):
        self._meshcat = meshcat
        self._pulses = 0
        self._heard = -float("inf")
        script = html.escape(" ".join(_SCRIPT.format(button=button).split()))
        meshcat.AddButton(PULSE)
        meshcat.AddButton(
            f'<img class="remosplat-style" src="data:," onerror="{script}">'
        )

    def is_held(self) -> bool:
        """Tells whether the page has sent a pulse within `SILENCE`."""
        now = time.monotonic()
        pulses = self._meshcat.GetButtonClicks(PULSE)
        if pulses != self._pulses:
            self._pulses = pulses
            self._heard = now
        return now - self._heard < SILENCE
