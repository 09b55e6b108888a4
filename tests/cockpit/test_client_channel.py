"""Messages of a browser's script: what is no message is none."""

import json

import pytest

pytest.importorskip("viser")

from hypothesis import given
from hypothesis import strategies as st

from remosplat_drake.cockpit.client_channel import read_message
from remosplat_drake.teleop.gamepad import GamepadState


def test_a_gamepad_is_read():
    pad = {"at": 3.5, "axes": [0, -1], "buttons": [1, 0.5]}
    text = json.dumps({"asked": 7, "gamepad": pad})
    assert read_message(text) == (7, GamepadState((0, -1), (1, 0.5)))
    assert read_message('{"asked": 8, "gamepad": null}') == (8, None)


@pytest.mark.parametrize(
    "gamepad",
    [
        3,
        {},
        {"axes": 1, "buttons": []},
        {"axes": ["x"], "buttons": []},
        {"axes": [float("nan")], "buttons": []},
        {"axes": [float("inf")], "buttons": []},
        {"axes": [0] * 65, "buttons": []},
    ],
)
def test_a_broken_gamepad_is_none(gamepad):
    text = json.dumps({"asked": 1, "gamepad": gamepad})
    assert read_message(text) == (0, None)


json_values = st.recursive(
    st.none() | st.booleans() | st.floats() | st.integers() | st.text(),
    lambda inner: st.lists(inner) | st.dictionaries(st.text(), inner),
)


@given(st.text())
def test_any_text_is_read(text):
    assert read_message(text)[1] is None


@given(json_values, json_values)
def test_any_values_are_read(asked, gamepad):
    number, _ = read_message(json.dumps({"asked": asked, "gamepad": gamepad}))
    assert isinstance(number, int)
