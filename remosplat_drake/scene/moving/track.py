"""`Track`: where things are at any time, and how they move there."""

from collections.abc import Iterable, Iterator, Sequence
from itertools import chain, pairwise
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


def time_goes_on(
    field: str, times: Sequence[float]
) -> Iterator[tuple[str, str]]:
    """Checks that each time of a list exceeds the one before.

    Args:
        field: Name of the list, whose entries have the field `time`.
        times: Their times [s].

    Yields:
        The name of an entry's time, and what is wrong with it.
    """
    for i, (before, after) in enumerate(pairwise(times)):
        if not after > before:
            where = f"{field}[{i + 1}].time"
            yield where, f"must exceed the one before, {before}"
