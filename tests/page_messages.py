"""Messages of a page to Meshcat, for tests without a browser."""

import struct
from collections.abc import Sequence

from pydrake.geometry import Meshcat


def click(meshcat: Meshcat, name: str):
    """Clicks a button."""
    _send(meshcat, {"type": "button", "name": name})


def slide(meshcat: Meshcat, name: str, value: float):
    """Moves a slider."""
    _send(meshcat, {"type": "slider", "name": name, "value": value})


def move_gamepad(
    meshcat: Meshcat, axes: Sequence[float], buttons: Sequence[float]
):
    """Changes sticks and buttons of a gamepad."""
    gamepad = {"index": 0, "button_values": [*buttons], "axes": [*axes]}
    _send(meshcat, {"type": "gamepad", "name": "", "gamepad": gamepad})


def _send(meshcat: Meshcat, message: dict):
    meshcat._InjectWebsocketMessage(packed(message))


def packed(value) -> bytes:
    """MessagePack: https://github.com/msgpack/msgpack/blob/master/spec.md."""
    if isinstance(value, dict):
        items = [part for item in value.items() for part in item]
        return bytes([0x80 + len(value)]) + b"".join(map(packed, items))
    if isinstance(value, list):
        head = struct.pack(">BH", 0xDC, len(value))
        return head + b"".join(map(packed, value))
    if isinstance(value, str):
        text = value.encode()
        return struct.pack(">BH", 0xDA, len(text)) + text
    if isinstance(value, int):
        return struct.pack(">Bi", 0xD2, value)
    return struct.pack(">Bd", 0xCB, value)
