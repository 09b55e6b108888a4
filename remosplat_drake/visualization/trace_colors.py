"""Colours of the end effectors' traces, for the page and other displays."""

from collections.abc import Sequence
from itertools import cycle

from pydrake.geometry import Rgba

HEX = {
    "yellow": "#ffdb00",
    "magenta": "#d933bf",
    "green": "#1aa64d",
    "orange": "#f2801a",
}
"""HTML colour codes, keyed by the name of the colour."""


def trace_colors(effectors: Sequence[str]) -> dict[str, str]:
    """Returns the name of the colour of each end effector's trace.

    Args:
        effectors: Names of the end effectors; colours repeat after four.
    """
    return dict(zip(effectors, cycle(HEX), strict=False))


def rgba(color: str) -> Rgba:
    """Returns a colour in Meshcat's type.

    Args:
        color: Name of the colour, a key of `HEX`.
    """
    digits = HEX[color].removeprefix("#")
    return Rgba(*(int(digits[k : k + 2], 16) / 255 for k in (0, 2, 4)))
