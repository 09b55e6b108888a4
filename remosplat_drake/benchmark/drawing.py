"""`Drawing`: progress of a suite that draws its scenes and targets."""

from collections.abc import Callable

Drawing = Callable[[str, int, int], None]
"""Callback for what is drawn, and how many of how many there are."""


def no_drawing(what: str, found: int, count: int) -> None:
    """Shows nothing."""
