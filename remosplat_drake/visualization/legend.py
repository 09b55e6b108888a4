"""Colours of the scene's lines, and their meaning."""

from collections.abc import Sequence

from remosplat_drake.visualization.trace_colors import HEX, trace_colors

_COMMON = (
    ("#1a6beb", "path of the base"),
    ("#e00f0d", "what holds the robot back"),
    ("#8c33d9", "futures that guidance has simulated"),
)


def legend(effectors: Sequence[str]) -> list[tuple[str, str]]:
    """Returns colours as HTML has them, and their meaning.

    Args:
        effectors: Names of the end effectors; one without a name is the only.
    """
    hands = [
        (HEX[color], f"path of {name or 'the end effector'}")
        for name, color in trace_colors(effectors).items()
    ]
    return [*hands, *_COMMON]
