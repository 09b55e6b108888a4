"""Defines the legend: the colours of the scene's lines and their meanings."""

from collections.abc import Sequence

from pydrake.geometry import Rgba

from remosplat_drake.visualization.trace_colors import HEX, trace_colors

BASE_PATH = Rgba(0.10, 0.42, 0.92)
HOLDS_BACK = Rgba(0.88, 0.06, 0.05)
FUTURE = Rgba(0.55, 0.20, 0.85)

_COMMON = (
    (BASE_PATH, "path of the base"),
    (HOLDS_BACK, "obstacle points that limit the robot's motion"),
    (FUTURE, "future motions that guidance has simulated"),
)


def legend(effectors: Sequence[str]) -> list[tuple[str, str]]:
    """Returns the legend: HTML colour codes, each with its meaning.

    Args:
        effectors: Names of the end effectors; if there is only one, its name is
            empty.
    """
    hands = [
        (HEX[color], f"path of {name or 'the end effector'}")
        for name, color in trace_colors(effectors).items()
    ]
    return [*hands, *((_html(color), meaning) for color, meaning in _COMMON)]


def _html(color: Rgba) -> str:
    parts = (color.r(), color.g(), color.b())
    return "#" + "".join(f"{round(255 * part):02x}" for part in parts)
