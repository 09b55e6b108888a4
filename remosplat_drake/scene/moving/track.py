"""`Track`: poses and velocities of moving objects at any time."""

from collections.abc import Iterable, Iterator, Sequence
from itertools import chain, pairwise
from pathlib import Path
from typing import Protocol

from remosplat_drake.scene.mover import Mover, Movers

SLACK = 1.02
"""Safety factor: a reported limit is this multiple of the largest sampled
value."""


class Track(Protocol):
    """A moving object of one or several parts."""

    def movers(self, time: float) -> Sequence[Mover]:
        """Returns the object's parts at a time, with limits of their motion.

        Args:
            time: Time since the run began [s].
        """
        ...


class TrackMaker(Protocol):
    """Settings of a moving object in a scenario."""

    def make(self, folder: Path) -> Track:
        """Makes the track.

        Args:
            folder: The folder that relative file names refer to.

        Raises:
            RemoSplatError: A named file cannot be used.
        """
        ...


def movers_at(tracks: Iterable[Track], time: float) -> Movers:
    """Returns all movers at a time.

    Args:
        tracks: Tracks of the movers.
        time: Time since the run began [s].
    """
    return Movers(time, list(chain(*(t.movers(time) for t in tracks))))


def time_goes_on(
    field: str, times: Sequence[float]
) -> Iterator[tuple[str, str]]:
    """Checks that the times of a list increase.

    Args:
        field: Name of the list, whose entries have the field `time`.
        times: Times of the entries [s].

    Yields:
        The name of an entry's time, and what is wrong with it.
    """
    for i, (before, after) in enumerate(pairwise(times)):
        if not after > before:
            where = f"{field}[{i + 1}].time"
            yield where, f"must exceed the one before, {before}"
