"""`stick_velocity`: what the sticks of a gamepad in the browser ask for."""

from collections.abc import Sequence

import numpy as np

from remosplat_drake.teleop.config import GamepadConfig

# The standard layout: https://www.w3.org/TR/gamepad/#remapping
_LEFT_X, _LEFT_Y, _RIGHT_X, _RIGHT_Y = range(4)
_UP, _DOWN, _LEFT, _RIGHT = range(12, 16)


def stick_velocity(
    config: GamepadConfig, axes: Sequence[float], buttons: Sequence[float]
) -> np.ndarray | None:
    """The wished velocity of the target, or None without the dead-man button.

    The left stick moves along W's x (up) and y (left), the right one along z
    (up) and turns about z (left). The cross turns about y (up, down) and x
    (left, right).

    Args:
        config: Speeds, dead zone and the dead-man button.
        axes: Of the sticks: right and down are 1.
        buttons: 1 where pressed.

    Returns:
        V_W, angular above translational, shape (6,) [rad/s, m/s].
    """
    if _at(buttons, config.dead_man) < 0.5:
        return None

    def stick(axis: int) -> float:
        """Up and left are positive; rises from 0 at the dead zone's edge."""
        value = -_at(axes, axis)
        beyond = max(0.0, abs(value) - config.dead_zone)
        return float(np.copysign(beyond / (1 - config.dead_zone), value))

    w_W = [
        _at(buttons, _RIGHT) - _at(buttons, _LEFT),
        _at(buttons, _UP) - _at(buttons, _DOWN),
        stick(_RIGHT_X),
    ]
    v_W = [stick(_LEFT_Y), stick(_LEFT_X), stick(_RIGHT_Y)]
    return np.array(
        [config.rotation * w for w in w_W] + [config.speed * v for v in v_W]
    )


def _at(values: Sequence[float], index: int) -> float:
    """What a gamepad does not have is not pressed."""
    value = values[index] if index < len(values) else 0.0
    return float(np.clip(value, -1.0, 1.0)) if np.isfinite(value) else 0.0
