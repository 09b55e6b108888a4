"""`Person`: a walking and reaching person in a scenario."""

import dataclasses as dc
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path
from typing import Annotated

from annotated_types import Interval, Len

from remosplat_drake.base.ranges import Config
from remosplat_drake.scene.moving.gait import Reach, Step, person_ends
from remosplat_drake.scene.moving.rods import Rods


@dc.dataclass
class Person(Config):
    """A person made of capsules, whose legs and arms swing while walking.

    The person stands at the first and the last step, and walks smoothly through
    the steps between them.
    """

    # Display name of the person.
    name: str = "person"
    # Height, from the floor to the top of the head [m].
    height: Annotated[float, Interval(ge=1.0, le=2.2)] = 1.75
    # Positions of the person over time; with a single position, the person
    # stands there.
    walk: Annotated[list[Step], Len(1, 1000)] = dc.field(
        default_factory=lambda: [Step()]
    )
    # Reaching motions, one after the other.
    reaches: Annotated[list[Reach], Len(0, 100)] = dc.field(
        default_factory=list
    )
    # Speed limit of all parts, as reported to the robot [m/s]; absent: the
    # largest actual speed of each part.
    max_speed: Annotated[float, Interval(ge=0, le=100)] | None = None
    # Acceleration limit of all parts, as reported to the robot [m/s^2]; absent:
    # the largest actual acceleration of each part.
    max_acceleration: Annotated[float, Interval(ge=0, le=1000)] | None = None

    def check(self) -> Iterator[tuple[str, str]]:
        """Checks that times increase.

        Yields:
            The name of a field and what is wrong with it.
        """
        for i, (before, after) in enumerate(pairwise(self.walk)):
            if not after.time > before.time:
                where = f"walk[{i + 1}].time"
                yield where, f"must exceed the one before, {before.time}"
        for i, (before, after) in enumerate(pairwise(self.reaches)):
            if not after.time >= before.end:
                where = f"reaches[{i + 1}].time"
                yield where, f"must be {before.end} or later: the hand is busy"

    def make(self, folder: Path) -> Rods:
        """Makes the person's track.

        Args:
            folder: Unused, since there are no files.
        """
        del folder
        times, ends, parts = person_ends(self.height, self.walk, self.reaches)
        return Rods(
            [f"{self.name}'s {part}" for part in parts],
            list(parts.values()),
            times,
            ends,
            self.max_speed,
            self.max_acceleration,
        )
