"""Turns a gamepad's sticks and buttons into a velocity of the target.

Buttons and axes have the numbers of https://w3c.github.io/gamepad/#remapping.
"""

import dataclasses as dc
from collections.abc import Sequence

import numpy as np

from remosplat_drake.teleop.teleop_config import GamepadConfig

SILENCE = 0.5
"""A dead-man switch counts as released if no message arrives for this time
[s]."""

OPEN, CLOSE, FASTER, SLOWER = "open", "close", "faster", "slower"
"""Effects that a press of a gamepad's button can have."""

_PRESSES = {0: CLOSE, 1: OPEN, 12: FASTER, 13: SLOWER}
"""Effects of buttons, keyed by the button's number: 0 is the lower and 1 the
right button, 12 is up and 13 down on the directional pad.
"""

_DOWN, _UP = 6, 7  # Triggers.
_LEFT, _RIGHT = 14, 15  # Of the directional pad.
_PRESSED = 0.5


@dc.dataclass(frozen=True)
class GamepadState:
    """A gamepad at one moment.

    Attributes:
        axes: Positions of the sticks from -1 to 1, right and towards the
            operator positive.
        buttons: Values of the buttons from 0 to 1.
    """

    axes: tuple[float, ...] = ()
    buttons: tuple[float, ...] = ()


def gamepad_presses(
    buttons: Sequence[float], config: GamepadConfig
) -> frozenset[str]:
    """Returns the effects of pressed buttons if the dead-man switch is held.

    Args:
        buttons: Values of the buttons from 0 to 1; missing buttons count as not
            pressed.
        config: Settings of the gamepad, with the number of the dead-man switch.
            The dead-man switch has no other effect.
    """
    if _value(buttons, config.dead_man, 0.0) < _PRESSED:
        return frozenset()
    return frozenset(
        does
        for i, does in _PRESSES.items()
        if i != config.dead_man and _value(buttons, i, 0.0) >= _PRESSED
    )


def gamepad_velocity(
    axes: Sequence[float], buttons: Sequence[float], config: GamepadConfig
) -> np.ndarray | None:
    """Turns a gamepad's state into the desired velocity of the target.

    The left stick moves the target along x (away) and y (left), and the
    triggers move it down and up; the right stick turns the target about z and
    y, and the directional pad's left and right buttons turn it about x.

    Args:
        axes: Positions of the sticks from -1 to 1, right and towards the
            operator positive; missing sticks count as centred.
        buttons: Values of the buttons from 0 to 1; missing buttons count as not
            pressed.
        config: Speeds, and the number of the dead-man switch.

    Returns:
        The velocity V_W, angular above translational, shape (6,) [rad/s,
        m/s], which may be zero; None unless the dead-man switch is held.
    """

    def axis(i: int) -> float:
        return _beyond_dead_zone(axes, i, config.dead_zone)

    def button(i: int) -> float:
        return _value(buttons, i, 0.0)

    if button(config.dead_man) < _PRESSED:
        return None
    w = [button(_RIGHT) - button(_LEFT), -axis(3), -axis(2)]
    v = [-axis(1), -axis(0), button(_UP) - button(_DOWN)]
    return np.concatenate(
        [np.multiply(config.rotation, w), np.multiply(config.speed, v)]
    )


def _beyond_dead_zone(axes: Sequence[float], i: int, zone: float) -> float:
    """Returns a stick's position, zero in the dead zone and then continuous."""
    value = _value(axes, i, -1.0)
    return float(np.sign(value) * max(abs(value) - zone, 0.0) / (1.0 - zone))


def _value(values: Sequence[float], i: int, lower: float) -> float:
    """Returns a value in its range; zero if it is missing or not finite."""
    if i >= len(values) or not np.isfinite(values[i]):
        return 0.0
    return float(np.clip(values[i], lower, 1.0))
