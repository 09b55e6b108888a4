"""`ClientChannel`: messages between the server and the script in a browser."""

import json
import math
from collections.abc import Callable
from typing import Any

import viser
from viser._messages import RunJavascriptMessage

from remosplat_drake.teleop.gamepad import GamepadState
from remosplat_drake.visualization.live_page.page_files import resource

_MOST = 64
"""A gamepad may have at most this many axes, and at most this many buttons."""

GamepadCallback = Callable[[GamepadState | None], None]


class ClientChannel:
    """Exchanges messages with our script in the browser of one client.

    viser does not support messages of other programs. The browser therefore
    writes its messages into a hidden text field of viser, and the server sends
    short scripts. The browser requests the age of the page's content only after
    it has drawn the previous answer, so that at most one answer is on its way.

    Args:
        client: The client.
        age: Function that returns the age of the page's content [s].
        hear: Function that is called, in the event loop that handles STOP, with
            the state of the client's gamepad (None without a gamepad).
    """

    def __init__(
        self,
        client: viser.ClientHandle,
        age: Callable[[], float],
        hear: GamepadCallback,
    ):
        self._client, self._age, self._hear = client, age, hear
        self._answered = 0
        field = client.gui.add_text("Channel", "", visible=False)
        style = f"<style>{resource('cockpit.css')}</style>"
        client.gui.add_html(style, order=-1.0)
        self._run(
            f"const channel = {json.dumps(field._impl.uuid)};",
            resource("age.js"),
            resource("cockpit.js"),
        )

        @field.on_update
        async def _(event: viser.GuiEvent):
            if event.client is not None:
                self._take(field.value)

    def _take(self, text: str) -> None:
        asked, gamepad = read_message(text)
        self._hear(gamepad)
        if asked > self._answered:
            self._answered = asked
            self._run(f"remosplat.answer({asked}, {self._age():.3f});")

    def _run(self, *scripts: str) -> None:
        message = RunJavascriptMessage("\n".join(scripts))
        self._client._websock_connection.queue_message(message)


def read_message(text: str) -> tuple[int, GamepadState | None]:
    """Parses a message of the script; ignores invalid parts.

    Args:
        text: The message, in JSON.

    Returns:
        The number of the latest request (0 for none), and the state of the
        gamepad (None without a gamepad).
    """
    try:
        message = json.loads(text)
        asked, pad = message["asked"], message["gamepad"]
        if pad is not None:
            pad = GamepadState(_numbers(pad["axes"]), _numbers(pad["buttons"]))
        return int(asked), pad
    except (ValueError, TypeError, KeyError, OverflowError):
        return 0, None


def _numbers(values: Any) -> tuple[float, ...]:
    """Converts a value from a browser to a list of numbers.

    Raises:
        TypeError: The value is not a list.
        ValueError: The list is too long, or contains something other than a
            number.
    """
    numbers = tuple(map(float, values))
    if len(numbers) > _MOST or not all(map(math.isfinite, numbers)):
        raise ValueError
    return numbers
