"""`Track`: where things are at any time, and how they move there."""

from collections.abc import Iterable, Sequence
from itertools import chain
from pathlib import Path
from typing import Protocol

from remosplat_drake.scene.mover import Mover, Movers

SLACK = 1.02
"""By how much bounds exceed the greatest that is seen at looks."""


class Track(Protocol):
    """Something that moves by itself, in one part or in several."""

    def movers(self, time: float) -> Sequence[Mover]:
        """Returns its parts as they are at a time, with their bounds.

        Args:
            time: Time since the run began [s].
        """
        ...


class TrackMaker(Protocol):
    """Settings of something that moves, as a scenario has them."""

    def make(self, folder: Path) -> Track:
        """Makes the track.

        Args:
            folder: The folder that relative file names refer to.

        Raises:
            RemoSplatError: A file that it names cannot be used.
        """
        ...


def movers_at(tracks: Iterable[Track], time: float) -> Movers:
    """Returns all that moves, as it is at a time.

    Args:
        tracks: How each moves.
        time: Time since the run began [s].
    """
    return Movers(time, list(chain(*(t.movers(time) for t in tracks))))
