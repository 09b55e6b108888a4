"""`HandReading`: width and force of a hand."""

import dataclasses as dc
import math

import numpy as np

STILL = 0.002
"""Rate of the width below which fingers are at rest [m/s]."""

SLIP = 0.005
"""Largest change of the width at which a hand still holds its object [m]."""


@dc.dataclass(frozen=True)
class HandReading:
    """A reading of a station's port `HAND.state`.

    Attributes:
        width: Opening of the fingers [m]; NaN if it is not known.
        rate: Rate of the opening; negative while they close [m/s].
        force: Force with which each finger presses [N]. Hands that do not
            measure it report the commanded one while they hold something.
    """

    width: float
    rate: float
    force: float

    @staticmethod
    def of(values: np.ndarray) -> "HandReading":
        """Makes a reading of a port's value, shape (3,) [m, m/s, N]."""
        return HandReading(*map(float, values))

    @property
    def is_known(self) -> bool:
        """Whether the width is known."""
        return math.isfinite(self.width)

    @property
    def at_rest(self) -> bool:
        """Whether the fingers do not move."""
        return abs(self.rate) < STILL

    def is_narrower(self, held: float) -> bool:
        """Returns whether the fingers are too close to hold the object.

        Only the width counts, since many hands measure no force.

        Args:
            held: Width of the hand when it holds the object [m].
        """
        return self.width < held - SLIP

    def has_let_go(self, held: float) -> bool:
        """Returns whether the hand has lost the object that it held.

        Args:
            held: The hand's width when it grasped the object [m].
        """
        return self.is_narrower(held) or self.width > held + SLIP
