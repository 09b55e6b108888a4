"""`Drawing`: progress of a suite that draws its scenes and targets."""

from collections.abc import Callable

Drawing = Callable[[str, int, int], None]
"""Callback with the drawn item, and its number of how many."""


def no_drawing(what: str, found: int, count: int) -> None:
    """Shows nothing."""
