"""`DeadMan`: whether the page sees its gamepad's dead-man button right now."""

import html
import time

from pydrake.geometry import Meshcat

PULSE = '<span class="remosplat-style remosplat-pulse"></span>'
"""Name of a hidden button that the page clicks while the button is held."""

SILENCE = 0.5
"""A page that is silent for so long does not see the button held [s]."""

_SCRIPT = """
setInterval(() => {{
  const pads = [...(navigator.getGamepads?.() || [])];
  const pad = pads.find((p) => p && p.connected);
  if (document.hidden || !(pad?.buttons[{button}]?.value > 0.5)) return;
  document.querySelector(".remosplat-pulse").closest("li").click();
}}, 50);
"""


class DeadMan:
    """Listens for the page's pulse.

    Meshcat tells of a gamepad when it changes, and only then: a page that is
    closed, hidden or hangs with the button held would leave it pressed for
    ever. So the page says again and again that the button is held. Meshcat
    draws buttons' names as HTML, and a picture that is none runs the script.

    Args:
        meshcat: The page.
        button: Number of the dead-man button.
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
        """Whether the page has said so within the last `SILENCE`."""
        now = time.monotonic()
        pulses = self._meshcat.GetButtonClicks(PULSE)
        if pulses != self._pulses:
            self._pulses = pulses
            self._heard = now
        return now - self._heard < SILENCE
