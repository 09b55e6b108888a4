"""`Drawing`: a callback that reports the drawing of scenes and targets."""

from collections.abc import Callable

Drawing = Callable[[str, int, int], None]
"""Function that is called for each generated item, with the item's name, the
item's number, and the number of all items."""


def no_drawing(what: str, found: int, count: int) -> None:
    """A `Drawing` that does nothing."""
