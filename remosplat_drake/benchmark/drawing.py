"""`Drawing`: callback for the progress of drawing random scenes and targets."""

from collections.abc import Callable

Drawing = Callable[[str, int, int], None]
"""Callback for each generated item: its name, its number, and the number of
items."""


def no_drawing(what: str, found: int, count: int) -> None:
    """A `Drawing` that does nothing."""
