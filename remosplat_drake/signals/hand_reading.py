"""`HandReading`: width and force of a hand, and the state of its grip."""

import dataclasses as dc

import numpy as np

STILL = 0.002
"""Rate of the width below which fingers are at rest [m/s]."""

TOLERANCE = 0.002
"""Difference of two widths that counts as none: reading and pads [m]."""

FORCE_SHARE = 0.5
"""Share of the commanded force that fingers feel at least if they grip."""


@dc.dataclass(frozen=True)
class HandReading:
    """A reading of a station's port `HAND.state`.

    Attributes:
        width: Opening of the fingers [m].
        rate: Rate of the opening; negative while they close [m/s].
        force: Force with which each finger presses [N].
    """

    width: float
    rate: float
    force: float

    @staticmethod
    def of(values: np.ndarray) -> "HandReading":
        """Makes a reading of a port's value, shape (3,) [m, m/s, N]."""
        return HandReading(*map(float, values))

    @property
    def at_rest(self) -> bool:
        """Whether the fingers do not move."""
        return abs(self.rate) < STILL


def has_opened(reading: HandReading, width: float) -> bool:
    """Returns whether a hand stands at the width that it was opened to.

    Args:
        reading: Its reading.
        width: Its commanded width [m].
    """
    return reading.at_rest and abs(reading.width - width) < TOLERANCE


def grips(reading: HandReading, width: float, force: float) -> bool:
    """Returns whether a closed hand has something between its fingers.

    They rest before they have reached the commanded width, and feel force. So
    the width of a grasp is commanded below that of the thing, by more than
    `TOLERANCE`.

    Args:
        reading: The reading of the hand.
        width: Its commanded width [m].
        force: Its commanded force [N].
    """
    stopped = reading.at_rest and reading.width > width + TOLERANCE
    return stopped and reading.force >= FORCE_SHARE * force


def closed_on_nothing(reading: HandReading, width: float) -> bool:
    """Returns whether a closed hand has reached its width, with nothing in it.

    Args:
        reading: The reading of the hand.
        width: Its commanded width [m].
    """
    return reading.at_rest and reading.width <= width + TOLERANCE


def slipped(reading: HandReading, held: float, force: float) -> bool:
    """Returns whether a hand has lost what it held, or is about to.

    Its fingers have come closer than they were around the thing, or feel no
    force. It counts from when the hand has gripped on.

    Args:
        reading: The reading of the hand.
        held: Its width when it gripped [m].
        force: Its commanded force [N].
    """
    closer = reading.width < held - TOLERANCE
    return closer or reading.force < FORCE_SHARE * force
